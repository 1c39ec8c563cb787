#version 460
#extension GL_GOOGLE_include_directive : require
// SVGF's temporal accumulation. In: the noisy signal, its history and where the surface was. Out: both blended, and the moments of
// luminance. History shrinks as far as the last frames contradict it.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"
#include "svgf_accumulation.glsl"
#include "history_rejection.glsl"

// Luminance of the brightest of the eight pixels around, in this frame.
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
    // NaN and infinity never reach the history.
    if (!is_finite(now)) now = then.light;
    vec3 counted = now;
    if ((push.rejection > 0.0 || push.brightest > 0.0) && then.moments.z > 0.0) {
        Recent recent = recent_at(ivec2(floor(vec2(pixel) - imageLoad(reprojected, pixel).xy + 0.5)));
        if (push.rejection > 0.0) then.moments.z *= kept_history(recent, push.rejection);
        if (push.brightest > 0.0 && then.moments.z > FEW_FRAMES) counted = without_firefly(now, pixel, recent);
    }
    accumulate(pixel, now, counted, then);
}
