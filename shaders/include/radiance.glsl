// What a pixel sends to the eye: L = direct + albedo/pi * indirect irradiance. Needs frame.glsl. Twin: `read_colour`
// in src/renderer/picture.rs.

layout(set = 0, binding = 1) uniform texture2D direct;
layout(set = 0, binding = 2) uniform texture2D irradiance;
layout(set = 0, binding = 3) uniform texture2D gbuffer_albedo;

// a: 1 where a surface is.
vec4 radiance_at(ivec2 pixel) {
    vec4 first = texelFetch(direct, pixel, 0);
    vec3 albedo = texelFetch(gbuffer_albedo, pixel, 0).rgb;
    return vec4(first.rgb + albedo / PI * texelFetch(irradiance, pixel, 0).rgb, first.a);
}
