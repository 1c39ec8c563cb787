#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Direct light of point, spot and directional lights, by both lobes of the BSDF; emission of surfaces; the environment behind them.
// Out: radiance; a: how much it counts for automatic exposure; and the directional albedo of the GGX lobe.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Lights arrive by `direct_shadows`, by `shadow`, or with the irradiance of the estimator.
layout(constant_id = 1) const uint SHADOWS = 0u;
const uint HARD = 0u;
const uint SOFT = 1u;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 6, r32ui) uniform readonly uimage2DArray direct_shadows;
layout(set = 0, binding = 8) uniform utexture2D gbuffer_surface;
layout(set = 0, binding = 9, rgba16f) uniform writeonly image2D direct;
layout(set = 0, binding = 10, rgba16f) uniform writeonly image2D specular_albedo;
#include "environment.glsl"
#include "unshadowed.glsl"
#include "shading_point.glsl"
// Shadowed over unshadowed radiance.
layout(set = 0, binding = 13, rgba16f) uniform readonly image2D shadow;

// The radiance of punctual lights, behind hard shadows.
vec3 hard_shadowed(ShadingPoint point, ivec2 pixel) {
    vec3 radiance = vec3(0.0);
    for (uint i = 0u; i < frame.light_count; i++) {
        vec3 arriving = unpack_transmittance(imageLoad(direct_shadows, ivec3(pixel, i / LIGHTS_PER_LAYER)).r, i);
        if (arriving == vec3(0.0)) continue;
        vec3 to_light;
        vec3 irradiance = unshadowed_irradiance(lights.data[i], point.surface, to_light) * arriving;
        radiance += bsdf_of(point, to_light, 1.0) * irradiance;
    }
    return radiance;
}

// The radiance of all lights, behind soft shadows.
vec3 soft_shadowed(ShadingPoint point, ivec2 pixel) {
    vec3 radiance = vec3(0.0);
    for (uint i = 0u; i < frame.direct_lights; i++) radiance += unshadowed_radiance(i, point);
    return radiance * imageLoad(shadow, pixel).rgb;
}

// Weight of pixels that emit in automatic exposure; the environment has none. Twin: src/reference/film.rs.
const float SHARE_OF_LIGHTS = 1.0 / 16.0;

vec4 radiance_of(uvec2 id, ivec2 pixel, out vec3 specular) {
    ShadingPoint point = shading_point_at(pixel, id);
    specular = point.is_glossy ? point.reflection.reflected : vec3(0.0);
    vec3 lit = vec3(0.0);
    if (SHADOWS == HARD) lit = hard_shadowed(point, pixel);
    else if (SHADOWS == SOFT) lit = soft_shadowed(point, pixel);
    vec3 emission = unpack_emission(texelFetch(gbuffer_surface, pixel, 0).y);
    return vec4(emission + lit, emission == vec3(0.0) ? 1.0 : SHARE_OF_LIGHTS);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    vec3 specular = vec3(0.0);
    vec4 radiance = id.x != 0u ? radiance_of(id, pixel, specular) : vec4(environment_radiance(pixel_ray(vec2(pixel)), true), 0.0);
    imageStore(specular_albedo, pixel, rounded(vec4(specular, 0.0)));
    imageStore(direct, pixel, storable(radiance));
}
