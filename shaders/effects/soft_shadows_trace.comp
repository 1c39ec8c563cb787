#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shadows of lights with an extent, one ray a pixel: of all lights one is chosen, and a point on it (Heitz et al. 2018). Out: what
// arrives over what would without shadows, by channel, an unbiased estimate; 1 where no light shines at all.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "tracer.glsl"
#include "rounded.glsl"
#include "noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 7) uniform utexture2D gbuffer_surface;
#include "unshadowed.glsl"
#include "shading_point.glsl"
#include "light_sampling.glsl"
layout(set = 0, binding = 11, rgba16f) uniform writeonly image2D shadow;

// Most of a channel of the ratio: highlights of wide lights differ from what is expected of them.
const float MOST = 1000.0;

vec3 ratio_at(ivec2 pixel, uvec2 id) {
    ShadingPoint point = shading_point_at(pixel, id);
    ChosenLight chosen = choose_light(point, noise(pixel, 0u).x);
    if (chosen.probability <= 0.0) return vec3(1.0);
    vec3 radiance = sampled_radiance(point, chosen, sample_light(chosen.index, point, noise(pixel, 1u)));
    vec3 ratio = mix(vec3(1.0), radiance / max(chosen.unshadowed, vec3(1e-30)), greaterThan(chosen.unshadowed, vec3(0.0)));
    return min(ratio, MOST);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    vec3 ratio = id.x != 0u ? ratio_at(pixel, id) : vec3(1.0);
    imageStore(shadow, pixel, rounded(vec4(ratio, 1.0)));
}
