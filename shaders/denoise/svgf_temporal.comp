#version 460
#extension GL_GOOGLE_include_directive : require
// SVGF's temporal accumulation (Schied et al. 2017, section 4.1, with Falcor's 3x3 fallback). In: the noisy signal, its history
// and where the surface was. Out: both blended, and the moments of luminance. History shrinks as far as the last frames contradict it.
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

#include "history_rejection.glsl"
#include "history_taps.glsl"

layout(push_constant) uniform Push {
    float least_alpha;         // of the signal
    float least_moments_alpha;
    float recent_alpha;        // of the last frames' mean
    float longest;             // history, frames
    float rejection;           // by which a change is told from noise, see history_rejection.glsl; 0: never
    float brightest;           // standard deviations above the mean, beyond which a lone sample is a firefly; 0: none is
    uint has_history;
    uint compress;             // 1: the signal is accumulated in compressed form
} push;

struct History {
    vec3 light;
    vec4 moments; // mean, standard deviation, length, mean of the last frames
};

bool is_finite(vec3 light) { return !any(isnan(light)) && !any(isinf(light)); }

vec3 noisy_at(ivec2 pixel) {
    vec3 light = imageLoad(noisy, pixel).rgb;
    return push.compress == 1u ? compressed(light) : light;
}

// The mean of what the texels show that saw this surface. Standard deviations are averaged as variances.
History history_at(ivec2 pixel) {
    HistoryTaps taps = history_taps(pixel, 1);
    History sum = History(vec3(0.0), vec4(0.0));
    float weights = 0.0;
    for (int tap = 0; tap < taps.side * taps.side; tap++) {
        float weight = tap_weight(taps, tap);
        if (weight == 0.0) continue;
        ivec2 place = tap_place(taps, tap);
        vec4 then = imageLoad(last_moments, place);
        sum.light += weight * imageLoad(history, place).rgb;
        sum.moments += weight * vec4(then.x, then.y * then.y, then.zw);
        weights += weight;
    }
    if (weights == 0.0) return sum;
    vec4 mean = sum.moments / weights;
    return History(sum.light / weights, vec4(mean.x, sqrt(mean.y), mean.zw));
}

// Of the eight pixels around, in this frame.
float brightest_around(ivec2 pixel) {
    float brightest = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 at = pixel + ivec2(i % 3, i / 3) - 1;
        if (i == 4 || !inside(at)) continue;
        vec3 light = noisy_at(at);
        if (is_finite(light)) brightest = max(brightest, luminance(light));
    }
    return brightest;
}

// A sample that is brighter than its pixel and those around have been and are is taken down to what they are.
vec3 without_firefly(vec3 now, ivec2 pixel, Recent recent) {
    float most = recent.mean + push.brightest * recent.deviation;
    float is = luminance(now);
    if (is <= most) return now;
    return now * min(1.0, max(most, brightest_around(pixel)) / is);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    vec3 now = noisy_at(pixel);
    if (surface_of_pixel(pixel).depth == 0.0) {
        // Where nothing is seen there is nothing to average.
        imageStore(light, pixel, is_finite(now) ? rounded(vec4(now, 0.0)) : vec4(0.0));
        imageStore(moments, pixel, vec4(0.0));
        return;
    }
    History then = History(vec3(0.0), vec4(0.0));
    if (push.has_history == 1u) then = history_at(pixel);
    // What is not a number never reaches the history.
    if (!is_finite(now)) now = then.light;
    vec3 counted = now;
    if ((push.rejection > 0.0 || push.brightest > 0.0) && then.moments.z > 0.0) {
        Recent recent = recent_at(ivec2(floor(vec2(pixel) - imageLoad(reprojected, pixel).xy + 0.5)));
        if (push.rejection > 0.0) then.moments.z *= kept_history(recent, push.rejection);
        if (push.brightest > 0.0 && then.moments.z > FEW_FRAMES) counted = without_firefly(now, pixel, recent);
    }

    float frames = min(then.moments.z + 1.0, push.longest);
    float alpha = max(push.least_alpha, 1.0 / frames);
    float moments_alpha = max(push.least_moments_alpha, 1.0 / frames);
    float now_luminance = luminance(now);
    float mean = then.moments.x + (now_luminance - then.moments.x) * moments_alpha;
    // Of both together: the variance of each, and that of their means.
    float between = (now_luminance - then.moments.x) * (now_luminance - then.moments.x);
    float variance = (1.0 - moments_alpha) * (then.moments.y * then.moments.y + moments_alpha * between);
    float deviation = sqrt(variance);
    float recent_mean = then.moments.w + (now_luminance - then.moments.w) * max(push.recent_alpha, 1.0 / frames);
    // The deviation of a mean over 1 / alpha frames.
    imageStore(light, pixel, rounded(vec4(then.light + (counted - then.light) * alpha, deviation * sqrt(alpha))));
    imageStore(moments, pixel, rounded(vec4(mean, deviation, frames, recent_mean)));
}
