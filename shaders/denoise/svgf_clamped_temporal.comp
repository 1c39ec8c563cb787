#version 460
#extension GL_GOOGLE_include_directive : require
// SVGF's temporal accumulation with history bounded by the colours of the new frame (Granja 2021, section 3.6, after Salvi 2016): to
// the mean of 3x3 pixels and as many standard deviations to each side, in YCoCg. In and out as svgf_temporal.comp.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"
#include "svgf_accumulation.glsl"
#include "ycocg.glsl"

vec3 bounded(vec3 then, ivec2 pixel) {
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 at = pixel + ivec2(i % 3, i / 3) - 1;
        if (!inside(at)) continue;
        vec3 light = noisy_at(at);
        if (!is_finite(light)) continue;
        vec3 colour = ycocg(light);
        sum += colour;
        squares += colour * colour;
        count += 1.0;
    }
    if (count == 0.0) return then;
    vec3 middle = sum / count;
    vec3 side = push.clamp_deviations * sqrt(max(squares / count - middle * middle, 0.0));
    vec3 from_middle = ycocg(then) - middle;
    vec3 inner = clamp(from_middle, -side, side);
    if (push.clips == 1u) {
        // Along the line to the middle, to where it meets the box.
        vec3 shares = mix(vec3(1.0), side / max(abs(from_middle), 1e-12), greaterThan(abs(from_middle), side));
        inner = from_middle * min(min(shares.x, shares.y), shares.z);
    }
    return max(rgb_of_ycocg(middle + inner), 0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    vec3 now = noisy_at(pixel);
    if (surface_of_pixel(pixel).depth == 0.0) {
        imageStore(light, pixel, is_finite(now) ? rounded(vec4(now, 0.0)) : vec4(0.0));
        imageStore(moments, pixel, vec4(0.0));
        return;
    }
    History then = History(vec3(0.0), vec4(0.0));
    if (push.has_history == 1u) then = history_at(pixel);
    if (!is_finite(now)) now = then.light;
    if (then.moments.z > 0.0) then.light = bounded(then.light, pixel);
    accumulate(pixel, now, now, then);
}
