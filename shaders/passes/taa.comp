#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Temporal antialiasing (Karis 2014, Salvi 2016): each frame samples pixels at another position; history follows what moves and
// stays within the colours of the 3x3 pixels around. In: radiance, motion, depth, history. Out: both blended.
#include "frame.glsl"
#include "ycocg.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D radiance;
layout(set = 0, binding = 2) uniform texture2D gbuffer_motion;
layout(set = 0, binding = 3, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 4) uniform sampler2D history;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D antialiased;

layout(push_constant) uniform Push {
    float alpha; // share of this frame
} push;

// Standard deviations around the mean of the 3x3 pixels in which history is kept.
const float REACH = 1.0;

// Least difference between the motion of a surface and that of its place by which it counts as moving, pixels.
const float LEAST_MOTION = 0.1;

// Share of the inverse depth by which what is before a silhouette stands out from the plane behind it.
const float EDGE = 0.02;

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(frame.size))); }

bool is_finite(vec4 light) { return !any(isnan(light)) && !any(isinf(light)); }

vec4 radiance_of(ivec2 pixel) {
    vec4 light = texelFetch(radiance, clamp(pixel, ivec2(0), ivec2(frame.size) - 1), 0);
    return is_finite(light) ? min(light, MOST_HALF) : vec4(0.0);
}

// 1 / depth; 0 for the environment, which is infinitely far away. Over a plane it is linear in the pixels.
float inverse_depth(ivec2 pixel) {
    float depth = inside(pixel) ? imageLoad(gbuffer_depth, pixel).r : 0.0;
    return depth > 0.0 ? 1.0 / depth : 0.0;
}

// Motion of the place that the pixel sees, if only the camera moves.
vec2 motion_of_place(ivec2 pixel) {
    float depth = imageLoad(gbuffer_depth, pixel).r;
    vec4 place = depth > 0.0 ? vec4(position_at(pixel, depth), 1.0) : vec4(pixel_ray(vec2(pixel)), 0.0);
    vec3 then = (frame.previous_view_projection * place).xyw;
    if (then.z <= 0.0) return vec2(frame.size);
    return vec2(pixel) + 0.5 + frame.jitter - (then.xy / then.z * 0.5 + 0.5) * vec2(frame.size);
}

// Motion of the surface at the pixel, or at a silhouette that of the nearer surface (Karis 2014). On a slanted plane the nearest of the
// pixels around has another motion, so it counts only where it stands out from the plane through the pixel and its opposite one.
vec2 motion_at(ivec2 pixel) {
    float around[9];
    for (int i = 0; i < 9; i++) around[i] = inverse_depth(pixel + ivec2(i % 3, i / 3) - 1);
    float own = around[4];
    float nearest = own;
    ivec2 at = pixel;
    for (int i = 0; i < 9; i++) {
        float plane = 2.0 * own - around[8 - i];
        if (around[i] > nearest && around[i] > plane + EDGE * own) {
            nearest = around[i];
            at = pixel + ivec2(i % 3, i / 3) - 1;
        }
    }
    return nearest > 0.0 ? texelFetch(gbuffer_motion, at, 0).xy : motion_of_place(pixel);
}

// Weights of four texels in a row by cubic convolution (Keys 1981), sharper than at a slope of -1/2, Catmull and Rom's: what moves is
// interpolated anew in each of ten frames and more.
const float SLOPE = -0.75;

vec4 cubic_weights(float t) {
    float u = 1.0 - t;
    vec2 middle = 1.0 + vec2(t * t, u * u) * ((SLOPE + 2.0) * vec2(t, u) - (SLOPE + 3.0));
    return vec4(SLOPE * t * u * u, middle, SLOPE * u * t * t);
}

// Interpolated without blur: bilinear history loses contrast in each frame of motion. The two middle texels of a row have positive
// weights, so a bilinear read between them gives both: 9 reads for 16 texels (Sigg and Hadwiger 2005).
vec4 history_at(vec2 place) {
    vec2 first = floor(place);
    vec2 part = place - first;
    if (part == vec2(0.0)) return texelFetch(history, ivec2(first), 0);
    vec4 x = cubic_weights(part.x);
    vec4 y = cubic_weights(part.y);
    vec3 weights[2] = vec3[](vec3(x.x, x.y + x.z, x.w), vec3(y.x, y.y + y.z, y.w));
    vec2 middle = vec2(x.z, y.z) / vec2(weights[0].y, weights[1].y);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 9; i++) {
        ivec2 tap = ivec2(i % 3, i / 3);
        vec2 offset = mix(vec2(tap) * 1.5 - 1.0, middle, equal(tap, ivec2(1)));
        vec2 at = (first + 0.5 + offset) / vec2(frame.size);
        sum += weights[0][tap.x] * weights[1][tap.y] * textureLod(history, at, 0.0);
    }
    return max(sum, 0.0);
}

// The colours of the 3x3 pixels around, YCoCg.
struct Box {
    vec3 mean;
    vec3 deviation;
    vec3 least;
    vec3 most;
};

Box box_around(ivec2 pixel) {
    Box box = Box(vec3(0.0), vec3(0.0), vec3(1e30), vec3(-1e30));
    for (int i = 0; i < 9; i++) {
        vec3 around = ycocg(radiance_of(pixel + ivec2(i % 3, i / 3) - 1).rgb);
        box.mean += around / 9.0;
        box.deviation += around * around / 9.0;
        box.least = min(box.least, around);
        box.most = max(box.most, around);
    }
    box.deviation = sqrt(max(box.deviation - box.mean * box.mean, 0.0));
    return box;
}

// History clipped to the box, and how far it lay from the mean; 1: at the border, which is the standard deviation within the range. Next to
// a light the deviation exceeds the mean, and alone would admit the dark rings that cubic weights leave there.
struct History { vec4 colour; float off; };

History history_in(Box box, vec2 place) {
    History found = History(vec4(0.0), 1e30);
    if (any(lessThanEqual(place, vec2(-0.5))) || any(greaterThanEqual(place, vec2(frame.size) - 0.5))) return found;
    found.colour = history_at(clamp(place, vec2(0.0), vec2(frame.size) - 1.0));
    vec3 off = ycocg(found.colour.rgb) - box.mean;
    vec3 side = mix(box.mean - box.least, box.most - box.mean, greaterThan(off, vec3(0.0)));
    vec3 times = abs(off) / max(min(REACH * box.deviation, side), vec3(1e-6) * abs(box.mean.x) + 1e-20);
    found.off = max(times.x, max(times.y, times.z));
    found.colour.rgb = max(rgb_of_ycocg(box.mean + off / max(found.off, 1.0)), 0.0);
    return found;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    vec4 result = radiance_of(pixel);
    if (push.alpha < 1.0) {
        Box box = box_around(pixel);
        vec2 motion = motion_at(pixel);
        History before = history_in(box, vec2(pixel) - motion);
        // Light stays with the place when an object turns: where the object's history leaves the box, that of the place may not.
        if (before.off > 1.0) {
            vec2 of_place = motion_of_place(pixel);
            if (distance(motion, of_place) > LEAST_MOTION) {
                History there = history_in(box, vec2(pixel) - of_place);
                if (there.off < before.off) before = there;
            }
        }
        if (before.off < 1e30) result = mix(before.colour, result, push.alpha);
    }
    imageStore(antialiased, pixel, rounded(result));
}
