// SVGF's temporal accumulation (Schied et al. 2017, section 4.1, with Falcor's 3x3 fallback): what its passes share, which differ in how
// they keep history from lagging. Needs svgf.glsl.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, rgba16f) uniform readonly image2D noisy;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D reprojected;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D history;
layout(set = 0, binding = 5, rgba16f) uniform readonly image2D last_moments;
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D light;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D moments;

#include "history_taps.glsl"

layout(push_constant) uniform Push {
    float least_alpha;         // of the signal
    float least_moments_alpha;
    float recent_alpha;        // of the last frames' mean
    float longest;             // history, frames
    float rejection;           // by which a change is told from noise, see history_rejection.glsl; 0: never
    float brightest;           // standard deviations above the mean, beyond which a lone sample is a firefly; 0: none is
    float clamp_deviations;    // of svgf_clamped_temporal.comp: from the mean to the sides of the box
    uint clips;                // of the same; 1: history moves towards the middle of the box
    uint has_history;
    uint compress;             // 1: the signal is accumulated in compressed form
    uint adaptive;             // 1: `noisy` says how wide a blur is of use
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

// Least share of the new frame in a sharp signal whose history is interpolated halfway between texels: bilinear interpolation blurs
// history anew in each frame of motion.
const float SHARP_ALPHA = 0.5;
// Width of the useful blur, as in the alpha of `noisy`, from which on that of interpolation does not matter.
const float SOFT = 0.25;

// The least share of the new frame, by how sharp the signal is and how far from texel centres its history is read.
float sharp_alpha(ivec2 pixel) {
    float sharpness = push.adaptive == 1u ? max(1.0 - imageLoad(noisy, pixel).a / SOFT, 0.0) : 0.0;
    vec2 part = fract(imageLoad(reprojected, pixel).xy);
    vec2 blur = 4.0 * part * (1.0 - part);
    return SHARP_ALPHA * sharpness * max(blur.x, blur.y);
}

// Blends the pixel's light, as it counts, and the moments of its luminance with history.
void accumulate(ivec2 pixel, vec3 now, vec3 counted, History then) {
    float frames = min(then.moments.z + 1.0, push.longest);
    float alpha = max(max(push.least_alpha, sharp_alpha(pixel)), 1.0 / frames);
    float moments_alpha = max(push.least_moments_alpha, 1.0 / frames);
    float now_luminance = luminance(now);
    float mean = then.moments.x + (now_luminance - then.moments.x) * moments_alpha;
    // The variance of history and frame together: each one's own, and that between their means.
    float between = (now_luminance - then.moments.x) * (now_luminance - then.moments.x);
    float variance = (1.0 - moments_alpha) * (then.moments.y * then.moments.y + moments_alpha * between);
    float deviation = sqrt(variance);
    float recent_mean = then.moments.w + (now_luminance - then.moments.w) * max(push.recent_alpha, 1.0 / frames);
    // The deviation of a mean over 1 / alpha frames.
    imageStore(light, pixel, rounded(vec4(then.light + (counted - then.light) * alpha, deviation * sqrt(alpha))));
    imageStore(moments, pixel, rounded(vec4(mean, deviation, frames, recent_mean)));
}
