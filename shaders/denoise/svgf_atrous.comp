#version 460
#extension GL_GOOGLE_include_directive : require
// One level of SVGF's edge-avoiding a-trous filter (Schied et al. 2017, section 4.3, equations 1 to 5): 5x5 taps, or 5 along one
// axis, then along the other. In: light and its standard deviation. Out: both filtered.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Taps to each side.
layout(constant_id = 0) const int RADIUS_X = 2;
layout(constant_id = 1) const int RADIUS_Y = 2;

layout(set = 0, binding = 2, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D light;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D filtered;
#include "surface.glsl"

layout(push_constant) uniform Push {
    int step;                // pixels between taps
    float depth_tolerance;   // as in svgf_variance.comp, at a distance of one pixel
    float normal_exponent;
    float luminance_tolerance; // standard deviations, by which the weight falls to 1/e
} push;

// Falcor's B3 spline, 1 in the middle.
const float KERNEL[3] = float[](1.0, 2.0 / 3.0, 1.0 / 6.0);
const float GAUSSIAN[2] = float[](0.5, 0.25);

// Standard deviation around a pixel: that of a single one is itself noisy.
float smooth_deviation(ivec2 pixel) {
    vec2 sum = vec2(0.0);
    for (int y = -1; y <= 1; y++) {
        for (int x = -1; x <= 1; x++) {
            ivec2 at = pixel + ivec2(x, y);
            if (!inside(at)) continue;
            float weight = GAUSSIAN[abs(x)] * GAUSSIAN[abs(y)];
            float deviation = imageLoad(light, at).a;
            sum += weight * vec2(deviation * deviation, 1.0);
        }
    }
    return sqrt(sum.x / sum.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    VisibleSurface centre = surface_of_pixel(pixel);
    vec4 middle = imageLoad(light, pixel);
    if (centre.depth == 0.0) {
        imageStore(filtered, pixel, middle);
        return;
    }
    Surface seen = surface_at(pixel);
    float middle_luminance = luminance(middle.rgb);
    float tolerance = push.luminance_tolerance * smooth_deviation(pixel) + 1e-6;
    vec4 sum = vec4(middle.rgb, middle.a * middle.a);
    float weights = 1.0;
    for (int y = -RADIUS_Y; y <= RADIUS_Y; y++) {
        for (int x = -RADIUS_X; x <= RADIUS_X; x++) {
            ivec2 at = pixel + ivec2(x, y) * push.step;
            if ((x == 0 && y == 0) || !inside(at)) continue;
            VisibleSurface other = surface_of_pixel(at);
            if (other.depth == 0.0) continue;
            vec4 tap = imageLoad(light, at);
            float distance = float(push.step) * length(vec2(x, y));
            float off = plane_distance(seen.position, seen.geometric, centre.depth, at, other.depth);
            float likeness = off / (push.depth_tolerance * distance) + abs(luminance(tap.rgb) - middle_luminance) / tolerance;
            float weight = KERNEL[abs(x)] * KERNEL[abs(y)] * exp(-likeness)
                * normal_weight(centre.normal, other.normal, push.normal_exponent);
            sum += vec4(weight * tap.rgb, weight * weight * tap.a * tap.a);
            weights += weight;
        }
    }
    imageStore(filtered, pixel, rounded(vec4(sum.rgb / weights, sqrt(sum.a) / weights)));
}
