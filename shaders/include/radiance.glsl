// What a pixel sends to the eye: L = direct + (albedo + specular albedo)/pi * indirect irradiance. The GGX lobe, too, gets the mean
// of the light above the surface: exact under uniform light, and no picture of it. Sheets before it let their share of that
// pass and add what they reflect. Needs frame.glsl. Twin: `Light` in src/renderer/picture.rs.
#include "has_sheets.glsl"

layout(set = 0, binding = 1, rgba32f) uniform readonly image2D direct;
layout(set = 0, binding = 2, rgba32f) uniform readonly image2D irradiance;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 6, rgba8) uniform readonly image2D specular_albedo;
layout(set = 0, binding = 7, rgba32f) uniform readonly image2D sheet_light;
layout(set = 0, binding = 8, rgba16f) uniform readonly image2D sheet_albedo;
layout(set = 0, binding = 9, rgba16f) uniform readonly image2D sheet_transmittance;

// a: 0 where no surface is.
vec4 radiance_at(ivec2 pixel) {
    vec4 light = imageLoad(direct, pixel);
    vec3 albedo = imageLoad(gbuffer_albedo, pixel).rgb + imageLoad(specular_albedo, pixel).rgb;
    if (HAS_SHEETS) {
        vec3 transmittance = imageLoad(sheet_transmittance, pixel).rgb;
        light.rgb = light.rgb * transmittance + imageLoad(sheet_light, pixel).rgb;
        albedo = albedo * transmittance + imageLoad(sheet_albedo, pixel).rgb;
    }
    return vec4(light.rgb + albedo / PI * imageLoad(irradiance, pixel).rgb, light.a);
}
