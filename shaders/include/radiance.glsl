// What a pixel sends to the eye: L = direct + (albedo + specular albedo)/pi * indirect irradiance. The GGX lobe, too, gets the mean
// of the light above the surface: exact under uniform light, and no picture of it. Needs frame.glsl. Twin: `Light::radiance` in
// src/renderer/picture.rs.

layout(set = 0, binding = 1, rgba32f) uniform readonly image2D direct;
layout(set = 0, binding = 2, rgba32f) uniform readonly image2D irradiance;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 6, rgba8) uniform readonly image2D specular_albedo;

// a: 0 where no surface is.
vec4 radiance_at(ivec2 pixel) {
    vec4 first = imageLoad(direct, pixel);
    vec3 albedo = imageLoad(gbuffer_albedo, pixel).rgb + imageLoad(specular_albedo, pixel).rgb;
    return vec4(first.rgb + albedo / PI * imageLoad(irradiance, pixel).rgb, first.a);
}
