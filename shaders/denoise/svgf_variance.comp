#version 460
#extension GL_GOOGLE_include_directive : require
// SVGF's spatial estimate of the variance (Schied et al. 2017, section 4.2): where the history is shorter than four frames, from the
// 7x7 pixels around that show the same surface. In: light and moments. Out: light, there averaged likewise.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D moments;
layout(set = 0, binding = 5, rgba16f) uniform readonly image2D light;
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D filtered;
layout(set = 0, binding = 7, rgba16f) uniform readonly image2D noisy;
#include "surface.glsl"

layout(push_constant) uniform Push {
    float depth_tolerance; // pixel footprints off the plane, by which the weight falls to 1/e
    float normal_exponent;
    float widest; // as in svgf_atrous.comp
} push;

const float ENOUGH_FRAMES = 4.0;
const int RADIUS = 3;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    VisibleSurface centre = surface_of_pixel(pixel);
    vec4 result = imageLoad(light, pixel);
    float frames = imageLoad(moments, pixel).b;
    if (centre.depth > 0.0 && frames < ENOUGH_FRAMES) {
        Surface here = surface_at(pixel);
        vec3 sum = vec3(0.0);
        vec2 sum_of_moments = vec2(0.0); // of luminance and its square
        float weights = 0.0;
        // The variance is that of all pixels around, the light as far as a blur is of use.
        float radius = filter_radius(imageLoad(noisy, pixel).a, push.widest);
        float light_weights = 0.0;
        for (int y = -RADIUS; y <= RADIUS; y++) {
            for (int x = -RADIUS; x <= RADIUS; x++) {
                ivec2 at = pixel + ivec2(x, y);
                if (!inside(at)) continue;
                VisibleSurface other = surface_of_pixel(at);
                if (other.depth == 0.0) continue;
                float off = plane_distance(here.position, here.geometric, centre.depth, at, other.depth);
                float weight = exp(-off / push.depth_tolerance) * normal_weight(centre.normal, other.normal, push.normal_exponent);
                vec2 mean_deviation = imageLoad(moments, at).rg;
                float light_weight = kernel_falloff(max(abs(x), abs(y)), radius) * weight;
                sum += light_weight * imageLoad(light, at).rgb;
                light_weights += light_weight;
                sum_of_moments += weight * vec2(mean_deviation.x, dot(mean_deviation, mean_deviation));
                weights += weight;
            }
        }
        vec2 mean = sum_of_moments / weights;
        float variance = max(mean.y - mean.x * mean.x, 0.0) / frames;
        result = vec4(sum / light_weights, sqrt(variance));
    }
    imageStore(filtered, pixel, rounded(result));
}
