#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Direct light of point, spot and directional lights, by both lobes of the BSDF; what surfaces emit; the environment behind them.
// Out: radiance; a: 1 where a surface is; and the directional albedo of the GGX lobe.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene.glsl"
#include "bsdf.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 5, std430) readonly buffer LightBlock { LightData data[]; } lights;
layout(set = 0, binding = 6, r32ui) uniform readonly uimage2DArray direct_shadows;
layout(set = 0, binding = 7, std430) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 0, binding = 8) uniform utexture2D gbuffer_surface;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D direct;
layout(set = 0, binding = 10, rgba8) uniform writeonly image2D specular_albedo;
#define ENVIRONMENT_BINDING 11
#include "environment.glsl"

vec3 radiance_of(uvec2 id, ivec2 pixel, out vec3 specular) {
    Surface surface = surface_at(pixel);
    MaterialData material = materials.data[id.y & MATERIAL];
    vec4 albedo_roughness = imageLoad(gbuffer_albedo, pixel);
    vec3 albedo = albedo_roughness.rgb;
    uvec2 packed = texelFetch(gbuffer_surface, pixel, 0).xy;
    vec4 base = unpack_base(packed.x);
    Bsdf bsdf = Bsdf(base.rgb, base.a, material.reflectance.rgb, material.reflectance.w, albedo_roughness.a);
    Reflection reflection;
    bool is_glossy = reflects(bsdf);
    if (is_glossy) reflection = seen(bsdf, surface.shading, normalize(frame.eye.xyz - surface.position));
    specular = is_glossy ? reflection.reflected : vec3(0.0);

    vec3 radiance = unpack_emission(packed.y);
    for (uint i = 0u; i < frame.light_count; i++) {
        vec3 arriving = unpacked_arrival(imageLoad(direct_shadows, ivec3(pixel, i / LIGHTS_PER_LAYER)).r, i);
        if (arriving == vec3(0.0)) continue;
        vec3 to_light;
        vec3 irradiance = unshadowed_irradiance(lights.data[i], surface, to_light) * arriving;
        radiance += albedo / PI * irradiance;
        if (is_glossy) radiance += reflected_towards_eye(reflection, to_light) * irradiance;
    }
    return radiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    bool is_surface = id.x != 0u;
    vec3 specular = vec3(0.0);
    vec3 radiance = is_surface ? radiance_of(id, pixel, specular) : environment_radiance(pixel_ray(vec2(pixel)));
    imageStore(specular_albedo, pixel, vec4(specular, 0.0));
    imageStore(direct, pixel, vec4(radiance, is_surface ? 1.0 : 0.0));
}
