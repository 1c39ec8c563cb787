#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One level of an edge-avoiding a-trous filter (Dammertz et al. 2010) over a signal whose variance is known, as wide as that variance
// asks for (Schied et al. 2017): texels count if they differ by no more than noise explains, those on other surfaces less. In: the
// signal, a: 0 where a texel has none; the variance of its luminance. Out: both, filtered.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "same_surface.glsl"
#include "shrinkage.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D noisy;
layout(set = 0, binding = 4, r32f) uniform readonly image2D noisy_variance;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D filtered;
layout(set = 0, binding = 6, r32f) uniform writeonly image2D filtered_variance;
#include "surface.glsl"

layout(push_constant) uniform Push {
    int step;        // texels between taps
    int pixels;      // from one texel to the next
    float tolerance; // standard deviations by which luminances on one surface may differ
} push;

// Most that a tap on another surface weighs. A surface one texel wide has no others.
const float OTHER_SURFACE = 0.5;

float weight_at(int place) { return place == 0 ? 1.0 : 0.5; }

// The variance around a texel: that of a single one is itself noisy.
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
    ivec2 extent = (ivec2(frame.size) + push.pixels - 1) / push.pixels;
    if (any(greaterThanEqual(texel, extent))) return;
    Surface centre = surface_at(push.pixels * texel);
    vec4 middle = imageLoad(noisy, texel);
    float variance = imageLoad(noisy_variance, texel).r;
    // Where few sets know a place, as at an edge that the camera turns to, all of them may be black by chance.
    float deviation = centre.depth > 0.0 ? sqrt(smooth_variance(texel, extent)) : 0.0;
    if (deviation > 0.0) {
        float light = luminance(middle.rgb);
        vec4 sum = vec4(middle.rgb, 1.0);
        float footprint = centre.depth * pixel_footprint() * float(push.pixels * push.step);
        // A pixel that may be black by chance stays black: irradiance_upsampling.comp fills it.
        float other_surface = may_be_black_by_chance(middle) ? 0.0 : OTHER_SURFACE;
        float sum_of_variances = variance;
        for (int i = 0; i < 9; i++) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            ivec2 at = texel + offset * push.step;
            if (i == 4 || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, extent))) continue;
            ivec2 pixel = push.pixels * at;
            float depth = imageLoad(gbuffer_depth, pixel).r;
            vec4 normals = imageLoad(gbuffer_normal, pixel);
            vec4 tap = imageLoad(noisy, at);
            vec3 d = position_at(pixel, depth) - centre.position;
            bool known = depth > 0.0 && tap.a > 0.0;
            float cosine = dot(octahedral_decode(normals.xy), centre.shading);
            bool same = known && cosine >= MIN_NORMAL_COSINE
                && same_surface(d, centre.geometric, octahedral_decode(normals.zw), centre.depth);
            float tap_variance = imageLoad(noisy_variance, at).r;
            // The tolerance takes both texels alike: by the centre's alone, a bright noisy texel would take more darkness than it gives light.
            float tolerance = push.tolerance * 0.5 * (deviation + sqrt(tap_variance));
            float likeness = exp(-abs(luminance(tap.rgb) - light) / tolerance);
            float surfaces = same ? 1.0 : known ? other_surface * neighbour_weight(cosine, d / footprint) : 0.0;
            float weight = weight_at(offset.x) * weight_at(offset.y) * likeness * surfaces;
            sum += weight * vec4(tap.rgb, 1.0);
            sum_of_variances += weight * weight * tap_variance;
        }
        middle.rgb = sum.rgb / sum.a;
        variance = sum_of_variances / (sum.a * sum.a);
    }
    imageStore(filtered, texel, rounded(middle));
    imageStore(filtered_variance, texel, vec4(variance));
}
