// One level of SVGF's edge-avoiding a-trous filter (Schied et al. 2017, section 4.3, equations 1 to 5): 5x5 taps, or 5 along one
// axis, then along the other. Needs svgf.glsl. Define STEP_AT(pixel), the pixels between taps, before including.

layout(local_size_x = 8, local_size_y = 8) in;

// Taps to each side.
layout(constant_id = 0) const int RADIUS_X = 2;
layout(constant_id = 1) const int RADIUS_Y = 2;

layout(set = 0, binding = 2, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D light;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D filtered;
layout(set = 0, binding = 6, rgba16f) uniform readonly image2D noisy;
#include "surface.glsl"

layout(push_constant) uniform Push {
    int step;                // pixels between taps
    float depth_tolerance;   // as in svgf_variance.comp, at a distance of one pixel
    float normal_exponent;
    float luminance_tolerance; // standard deviations, by which the weight falls to 1/e
    float widest;            // pixels that all levels radius; 0: blur as far whatever is of use
    uint expand;             // 1: the signal is compressed, and this is the last step
} push;

// Falcor's B3 spline, 1 in the middle.
const float KERNEL[3] = float[](1.0, 2.0 / 3.0, 1.0 / 6.0);
const float GAUSSIAN[2] = float[](0.5, 0.25);

// Standard deviation around a pixel, along the axes of the taps: that of a single one is itself noisy.
float smooth_deviation(ivec2 pixel) {
    vec2 sum = vec2(0.0);
    for (int y = -min(RADIUS_Y, 1); y <= min(RADIUS_Y, 1); y++) {
        for (int x = -min(RADIUS_X, 1); x <= min(RADIUS_X, 1); x++) {
            ivec2 at = pixel + ivec2(x, y);
            if (!inside(at)) continue;
            float weight = GAUSSIAN[abs(x)] * GAUSSIAN[abs(y)];
            float deviation = imageLoad(light, at).a;
            sum += weight * vec2(deviation * deviation, 1.0);
        }
    }
    return sqrt(sum.x / sum.y);
}

vec4 result_of(vec4 light) {
    if (push.expand == 0u) return light;
    // The deviation grows by the slope of the curve.
    vec3 full = expanded(light.rgb);
    float slope = 1.0 + luminance(full);
    return vec4(full, light.a * slope * slope);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    VisibleSurface centre = surface_of_pixel(pixel);
    int step = STEP_AT(pixel);
    vec4 middle = imageLoad(light, pixel);
    // Taps that are left for this level, after those before it.
    float radius = (filter_radius(imageLoad(noisy, pixel).a, push.widest) - 2.0 * float(step - 1)) / float(step);
    if (centre.depth == 0.0 || radius <= 0.0) {
        imageStore(filtered, pixel, rounded(result_of(middle)));
        return;
    }
    Surface here = surface_at(pixel);
    float middle_luminance = luminance(middle.rgb);
    float deviation = smooth_deviation(pixel);
    vec4 sum = vec4(middle.rgb, middle.a * middle.a);
    float weights = 1.0;
    for (int y = -RADIUS_Y; y <= RADIUS_Y; y++) {
        for (int x = -RADIUS_X; x <= RADIUS_X; x++) {
            ivec2 at = pixel + ivec2(x, y) * step;
            if ((x == 0 && y == 0) || !inside(at)) continue;
            VisibleSurface other = surface_of_pixel(at);
            if (other.depth == 0.0) continue;
            vec4 tap = imageLoad(light, at);
            // The tolerance takes both pixels alike: by the centre's alone, a bright noisy pixel would take more darkness than it gives light.
            float tolerance = push.luminance_tolerance * 0.5 * (deviation + tap.a) + 1e-6;
            float distance = float(step) * length(vec2(x, y));
            float off = plane_distance(here.position, here.geometric, centre.depth, at, other.depth);
            float likeness = off / (push.depth_tolerance * distance) + abs(luminance(tap.rgb) - middle_luminance) / tolerance;
            float weight = kernel_falloff(max(abs(x), abs(y)), radius) * KERNEL[abs(x)] * KERNEL[abs(y)] * exp(-likeness)
                * normal_weight(centre.normal, other.normal, push.normal_exponent);
            sum += vec4(weight * tap.rgb, weight * weight * tap.a * tap.a);
            weights += weight;
        }
    }
    imageStore(filtered, pixel, rounded(result_of(vec4(sum.rgb / weights, sqrt(sum.a) / weights))));
}
