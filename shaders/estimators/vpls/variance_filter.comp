#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One step of an edge-avoiding a-trous filter over the sum of all sets (Dammertz et al. 2010), as wide as its variance asks for
// (Schied et al. 2017): texels count if they lie on the same surface and differ by no more than noise explains. The variance comes
// from the sets, which are independent estimates. Out: irradiance; a: how many sets saw the surface; and the variance of its
// luminance.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, rgba32f) uniform readonly image2D noisy_irradiance;
layout(set = 0, binding = 6, r32f) uniform readonly image2D noisy_variance;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D coarse_irradiance;
layout(set = 0, binding = 8, r32f) uniform writeonly image2D coarse_variance;
#include "surface.glsl"

layout(push_constant) uniform Push { int step; } push; // texels between taps

// Standard deviations by which luminances on one surface may differ.
const float LUMINANCE_TOLERANCE = 3.0;

float weight_at(int place) { return place == 0 ? 1.0 : 0.5; }

// Variance around a texel: that of a single one is itself noisy.
float smooth_variance(ivec2 texel, ivec2 extent) {
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 9; i++) {
        ivec2 offset = ivec2(i % 3, i / 3) - 1;
        ivec2 at = clamp(texel + offset, ivec2(0), extent - 1);
        float weight = weight_at(offset.x) * weight_at(offset.y);
        sum += weight * vec2(imageLoad(noisy_variance, at).r, 1.0);
    }
    return sum.x / sum.y;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 extent = ivec2(set_extent(frame.size, 2u));
    if (any(greaterThanEqual(texel, extent))) return;
    Surface centre = surface_at(2 * texel);
    vec4 middle = imageLoad(noisy_irradiance, texel);
    float variance = imageLoad(noisy_variance, texel).r;
    if (centre.depth > 0.0 && variance > 0.0) {
        float tolerance = LUMINANCE_TOLERANCE * sqrt(smooth_variance(texel, extent));
        float light = luminance(middle.rgb);
        vec4 sum = vec4(middle.rgb, 1.0);
        float sum_of_variances = variance;
        for (int i = 0; i < 9; i++) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            ivec2 at = texel + offset * push.step;
            if (i == 4 || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, extent))) continue;
            float depth = imageLoad(gbuffer_depth, 2 * at).r;
            vec4 normals = imageLoad(gbuffer_normal, 2 * at);
            vec4 noisy = imageLoad(noisy_irradiance, at);
            vec3 d = position_at(2 * at, depth) - centre.position;
            bool same = depth > 0.0 && noisy.a > 0.0
                && dot(octahedral_decode(normals.xy), centre.shading) >= MIN_NORMAL_COSINE
                && same_surface(d, centre.geometric, octahedral_decode(normals.zw), centre.depth);
            float likeness = exp(-abs(luminance(noisy.rgb) - light) / tolerance);
            float weight = same ? weight_at(offset.x) * weight_at(offset.y) * likeness : 0.0;
            sum += weight * vec4(noisy.rgb, 1.0);
            sum_of_variances += weight * weight * imageLoad(noisy_variance, at).r;
        }
        middle.rgb = sum.rgb / sum.a;
        variance = sum_of_variances / (sum.a * sum.a);
    }
    imageStore(coarse_irradiance, texel, middle);
    imageStore(coarse_variance, texel, vec4(variance));
}
