#version 460
#extension GL_GOOGLE_include_directive : require
// BMFR's accumulation of a signal over time (Koskela et al. 2019, section 4.2), before and, as `SECOND`, after the fit. In: the signal,
// its history and where the surface was. Out: both blended; a: frames in it.
#include "frame.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// The second accumulation takes the number of frames from the first.
layout(constant_id = 0) const bool SECOND = false;

layout(set = 0, binding = 2, rgba16f) uniform readonly image2D signal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D reprojected;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D history;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D accumulated;
#include "history_taps.glsl"

layout(push_constant) uniform Push {
    float least_alpha; // share of the newest frame, at least
    uint has_history;
    int pixels;        // of the picture, from one texel of the signal to the next
} push;

// So many frames are counted.
const float MOST_FRAMES = 255.0;

bool is_finite(vec3 light) { return !any(isnan(light)) && !any(isinf(light)); }

// Mean luminance of the history over 5x5 texels.
float history_around(ivec2 texel) {
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 25; i++) {
        ivec2 at = texel + ivec2(i % 5, i / 5) - 2;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, imageSize(history)))) continue;
        vec4 then = imageLoad(history, at);
        if (then.a > 0.0) sum += vec2(luminance(then.rgb), 1.0);
    }
    return sum.x / max(sum.y, 1.0);
}

// Means of history by which a sample may be brighter than all around: where few paths find the light, those few are all there is.
const float FIREFLY = 32.0;

// A sample that is brighter than all around are and have been by far is a firefly: it is taken down to them.
vec3 without_firefly(vec3 light, ivec2 texel, ivec2 texel_then) {
    float most = FIREFLY * history_around(texel_then);
    float is = luminance(light);
    if (is <= most) return light;
    for (int i = 0; i < 9; i++) {
        ivec2 at = texel + ivec2(i % 3, i / 3) - 1;
        if (i == 4 || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, imageSize(signal)))) continue;
        vec3 other = imageLoad(signal, at).rgb;
        if (is_finite(other)) most = max(most, luminance(other));
    }
    return light * min(most / is, 1.0);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(signal)))) return;
    vec4 now = imageLoad(signal, texel);
    vec4 then = vec4(0.0);
    HistoryTaps taps;
    if (push.has_history == 1u) {
        taps = history_taps(texel, push.pixels);
        float weights = 0.0;
        for (int tap = 0; tap < taps.side * taps.side; tap++) {
            float weight = tap_weight(taps, tap);
            if (weight == 0.0) continue;
            then += weight * imageLoad(history, tap_place(taps, tap));
            weights += weight;
        }
        if (weights > 0.0) then /= weights;
    }
    // NaN and infinity never reach the history.
    if (!is_finite(now.rgb)) now.rgb = then.rgb;
    else if (!SECOND && then.a > 0.0) now.rgb = without_firefly(now.rgb, texel, taps.first + taps.side / 2);
    float frames = SECOND ? now.a : min(round(then.a) + 1.0, MOST_FRAMES);
    // Without a history of its own, the second accumulation begins anew.
    float alpha = then.a > 0.0 ? max(1.0 / max(frames, 1.0), push.least_alpha) : 1.0;
    imageStore(accumulated, texel, storable(vec4(mix(then.rgb, now.rgb, alpha), frames)));
}
