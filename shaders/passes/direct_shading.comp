#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Direct light of point, spot and directional lights: diffuse and normalised Blinn-Phong specular
// reflection; what surfaces emit; the background. Out: radiance; a: 1 where a surface is.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene.glsl"

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
layout(set = 0, binding = 8, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D direct;

// Diffuse and normalised Blinn-Phong; specular: rgb: Ks; w: Ns.
vec3 reflectance(vec3 albedo, vec4 specular, float half_cosine) {
    return albedo / PI + specular.rgb * (specular.w + 8.0) / (8.0 * PI) * pow(half_cosine, specular.w);
}

vec3 radiance_of(uvec2 id, ivec2 pixel) {
    Surface surface = surface_at(pixel);
    MaterialData material = materials.data[id.y & MATERIAL];
    vec3 albedo = imageLoad(gbuffer_albedo, pixel).rgb;
    vec3 to_eye = normalize(frame.eye.xyz - surface.position);

    vec3 radiance = vec3(0.0);
    if ((id.y & FRONT_FACING) != 0u) radiance = material.emission.rgb * instances.data[id.x - 1u].emission.rgb;
    for (uint i = 0u; i < frame.light_count; i++) {
        uint visible = imageLoad(direct_shadows, ivec3(pixel, i / LIGHTS_PER_LAYER)).r;
        if ((visible >> (i % LIGHTS_PER_LAYER) & 1u) == 0u) continue;
        vec3 to_light;
        vec3 irradiance = unshadowed_irradiance(lights.data[i], surface, to_light);
        float half_cosine = max(dot(surface.shading, normalize(to_light + to_eye)), 0.0);
        radiance += reflectance(albedo, material.specular, half_cosine) * irradiance;
    }
    return radiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    imageStore(direct, pixel, id.x != 0u ? vec4(radiance_of(id, pixel), 1.0) : vec4(frame.background.rgb, 0.0));
}
