// Radiance of a pixel to the eye: L = direct + albedo/pi * indirect irradiance + specular albedo * reflection. Where no reflection rays
// are traced, the GGX lobe gets the mean of the light above the surface, irradiance/pi: exact under uniform light, and no picture of
// it. Thin surfaces before it let their share of that pass and add what they reflect. Needs frame.glsl. Twin: `Light` in
// src/renderer/picture.rs.
#include "has_thin_surfaces.glsl"
#include "reflection_weight.glsl"

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D direct;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 6, rgba16f) uniform readonly image2D specular_albedo;
layout(set = 0, binding = 7, rgba16f) uniform readonly image2D thin_light;
layout(set = 0, binding = 8, rgba16f) uniform readonly image2D thin_albedo;
layout(set = 0, binding = 9, rgba16f) uniform readonly image2D thin_transmittance;
layout(set = 0, binding = 10, rgba16f) uniform readonly image2D reflection;
layout(set = 0, binding = 13, rgba16f) uniform readonly image2D thin_mirrored;

// a: how much the pixel counts for automatic exposure.
vec4 radiance_at(ivec2 pixel, vec3 irradiance) {
    vec4 light = imageLoad(direct, pixel);
    vec4 albedo_roughness = imageLoad(gbuffer_albedo, pixel);
    vec3 specular = imageLoad(specular_albedo, pixel).rgb;
    float mirrored = reflection_weight(albedo_roughness.a);
    vec3 albedo = albedo_roughness.rgb + specular * (1.0 - mirrored);
    specular *= mirrored;
    if (HAS_THIN_SURFACES) {
        vec3 transmittance = imageLoad(thin_transmittance, pixel).rgb;
        light.rgb = light.rgb * transmittance + imageLoad(thin_light, pixel).rgb;
        albedo = albedo * transmittance + imageLoad(thin_albedo, pixel).rgb;
        specular = specular * transmittance + imageLoad(thin_mirrored, pixel).rgb;
    }
    if (specular != vec3(0.0)) light.rgb += specular * imageLoad(reflection, pixel).rgb;
    return vec4(light.rgb + albedo / PI * irradiance, light.a);
}
