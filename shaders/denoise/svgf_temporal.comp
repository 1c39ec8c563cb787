#version 460
#extension GL_GOOGLE_include_directive : require
// SVGF's temporal accumulation (Schied et al. 2017, section 4.1, with Falcor's 3x3 fallback). In: the noisy signal, its history
// and where the surface was. Out: both blended, and the moments of luminance.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, rgba16f) uniform readonly image2D noisy;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D reprojected;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D history;
layout(set = 0, binding = 5, rgba16f) uniform readonly image2D last_moments;
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D light;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D moments;

layout(push_constant) uniform Push {
    float least_alpha;         // of the signal
    float least_moments_alpha;
    float longest;             // history, frames
    float clamp_width;         // standard deviations of the 3x3 noisy pixels around that history may lie off their mean; 0: any
    uint has_history;
} push;

struct History {
    vec3 light;
    vec3 moments; // mean, standard deviation, length
};

bool is_finite(vec3 light) { return !any(isnan(light)) && !any(isinf(light)); }

// The mean of what the texels show that saw this surface. Standard deviations are averaged as variances.
History history_at(ivec2 pixel) {
    vec4 found = imageLoad(reprojected, pixel);
    vec2 place = vec2(pixel) - found.xy;
    bool bilinear = found.z > 0.0;
    ivec2 first = bilinear ? ivec2(floor(place)) : ivec2(floor(place + 0.5)) - 1;
    uint mask = uint(bilinear ? found.z : found.w);
    int side = bilinear ? 2 : 3;
    vec2 part = place - floor(place);
    History sum = History(vec3(0.0), vec3(0.0));
    float weights = 0.0;
    for (int tap = 0; tap < side * side; tap++) {
        if ((mask >> tap & 1u) == 0u) continue;
        ivec2 offset = ivec2(tap % side, tap / side);
        // No tap weighs nothing: it may be the only one.
        vec2 along = max(mix(1.0 - part, part, vec2(offset)), 1e-5);
        float weight = bilinear ? along.x * along.y : 1.0;
        vec3 then = imageLoad(last_moments, first + offset).rgb;
        sum.light += weight * imageLoad(history, first + offset).rgb;
        sum.moments += weight * vec3(then.x, then.y * then.y, then.z);
        weights += weight;
    }
    if (weights == 0.0) return sum;
    vec3 mean = sum.moments / weights;
    return History(sum.light / weights, vec3(mean.x, sqrt(mean.y), mean.z));
}

// History within the colours of the noisy pixels around, in YCoCg (Salvi 2016): what has changed is forgotten at once.
vec3 clamped(vec3 light, ivec2 pixel) {
    const mat3 to_ycocg = mat3(0.25, 0.5, -0.25, 0.5, 0.0, 0.5, 0.25, -0.5, -0.25);
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float count = 0.0;
    for (int tap = 0; tap < 9; tap++) {
        ivec2 at = pixel + ivec2(tap % 3, tap / 3) - 1;
        if (!inside(at) || surface_of_pixel(at).depth == 0.0) continue;
        vec3 here = imageLoad(noisy, at).rgb;
        if (!is_finite(here)) continue;
        vec3 colour = to_ycocg * here;
        sum += colour;
        squares += colour * colour;
        count += 1.0;
    }
    if (count == 0.0) return light;
    vec3 mean = sum / count;
    vec3 reach = push.clamp_width * sqrt(max(squares / count - mean * mean, 0.0));
    return max(inverse(to_ycocg) * clamp(to_ycocg * light, mean - reach, mean + reach), 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    if (surface_of_pixel(pixel).depth == 0.0) {
        imageStore(light, pixel, vec4(0.0));
        imageStore(moments, pixel, vec4(0.0));
        return;
    }
    vec3 now = imageLoad(noisy, pixel).rgb;
    History then = History(vec3(0.0), vec3(0.0));
    if (push.has_history == 1u) then = history_at(pixel);
    // What is not a number never reaches the history.
    if (!is_finite(now)) now = then.light;
    if (push.clamp_width > 0.0 && then.moments.z > 0.0) then.light = clamped(then.light, pixel);

    float frames = min(then.moments.z + 1.0, push.longest);
    float alpha = max(push.least_alpha, 1.0 / frames);
    float moments_alpha = max(push.least_moments_alpha, 1.0 / frames);
    float now_luminance = luminance(now);
    float mean = then.moments.x + (now_luminance - then.moments.x) * moments_alpha;
    // Of both together: the variance of each, and that of their means.
    float between = (now_luminance - then.moments.x) * (now_luminance - then.moments.x);
    float variance = (1.0 - moments_alpha) * (then.moments.y * then.moments.y + moments_alpha * between);
    float deviation = sqrt(variance);
    imageStore(light, pixel, rounded(vec4(then.light + (now - then.light) * alpha, deviation)));
    imageStore(moments, pixel, rounded(vec4(mean, deviation, frames, 0.0)));
}
