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
    if (nearest > 0.0) return texelFetch(gbuffer_motion, at, 0).xy;
    vec3 then = (frame.previous_view_projection * vec4(pixel_ray(vec2(pixel)), 0.0)).xyw;
    if (then.z <= 0.0) return vec2(frame.size);
    return vec2(pixel) + 0.5 + frame.jitter - (then.xy / then.z * 0.5 + 0.5) * vec2(frame.size);
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

// The colour on the way to the mean of those around where it leaves their box: their standard deviation, within their range. Next to
// a light the deviation exceeds the mean, and alone would admit the dark rings that cubic weights leave there.
vec3 clipped(vec3 colour, ivec2 pixel) {
    vec3 sum = vec3(0.0);
    vec3 squares = vec3(0.0);
    vec3 least = vec3(1e30);
    vec3 most = vec3(-1e30);
    for (int i = 0; i < 9; i++) {
        vec3 around = ycocg(radiance_of(pixel + ivec2(i % 3, i / 3) - 1).rgb);
        sum += around;
        squares += around * around;
        least = min(least, around);
        most = max(most, around);
    }
    vec3 mean = sum / 9.0;
    vec3 reach = REACH * sqrt(max(squares / 9.0 - mean * mean, 0.0));
    vec3 off = ycocg(colour) - mean;
    vec3 side = mix(mean - least, most - mean, greaterThan(off, vec3(0.0)));
    vec3 times = abs(off) / max(min(reach, side), vec3(1e-6) * abs(mean.x) + 1e-20);
    float farthest = max(times.x, max(times.y, times.z));
    return max(rgb_of_ycocg(mean + off / max(farthest, 1.0)), 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    vec4 now = radiance_of(pixel);
    vec2 place = vec2(pixel) - motion_at(pixel);
    bool seen = all(greaterThan(place, vec2(-0.5))) && all(lessThan(place, vec2(frame.size) - 0.5));
    vec4 result = now;
    if (push.alpha < 1.0 && seen) {
        vec4 then = history_at(clamp(place, vec2(0.0), vec2(frame.size) - 1.0));
        then.rgb = clipped(then.rgb, pixel);
        result = mix(then, now, push.alpha);
    }
    imageStore(antialiased, pixel, rounded(result));
}
