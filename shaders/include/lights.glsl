// Point, spot and directional lights. Twin: LightData in src/gpu_scene/structs.rs. Needs frame.glsl and surface.glsl.
#include "has_thin_surfaces.glsl"

// Beyond every scene, for rays to lights that are infinitely far away.
const float FAR = 1e30;

const uint LIGHT_POINT = 0u;
const uint LIGHT_SPOT = 1u;
const uint LIGHT_DIRECTIONAL = 2u;
// A spot whose intensity falls by the square, as that of glTF.
const uint LIGHT_SQUARE_SPOT = 3u;

// Irradiance on a plane across the direction to the light, unoccluded.
vec3 unshadowed(LightData light, vec3 p, out vec3 to_light) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        to_light = -light.direction.xyz;
        return light.power.rgb;
    }
    vec3 d = light.position.xyz - p;
    float squared = max(dot(d, d), 1e-30);
    to_light = d * inversesqrt(squared);
    float falloff = 1.0;
    if (light.kind == LIGHT_SPOT || light.kind == LIGHT_SQUARE_SPOT) {
        float inner = light.position.w, outer = light.direction.w;
        float t = clamp((dot(-to_light, light.direction.xyz) - outer) / (inner - outer), 0.0, 1.0);
        falloff = t * t * (light.kind == LIGHT_SPOT ? 3.0 - 2.0 * t : 1.0);
    }
    return light.power.rgb * falloff / squared;
}

// Irradiance of the surface, unoccluded: 0 where it faces away.
vec3 unshadowed_irradiance(LightData light, Surface surface, out vec3 to_light) {
    vec3 irradiance = unshadowed(light, surface.position, to_light);
    float cosine = dot(surface.shading, to_light);
    bool faces = cosine > 0.0 && dot(surface.geometric, to_light) > 0.0;
    return faces ? irradiance * cosine : vec3(0.0);
}

// Lights whose transmittance a texel of a layer of `direct_shadows` holds: a bit each or, where thin surfaces tint it, the colour of
// one with 11, 11 and 10 bits. Twin: `lights_per_layer` in src/passes/direct_shadows.rs.
const uint LIGHTS_PER_LAYER = HAS_THIN_SURFACES ? 1u : 32u;

// Packs the share of a light that reaches a surface, 0 to 1, at the light's place in a texel.
uint pack_transmittance(vec3 share, uint light) {
    if (!HAS_THIN_SURFACES) return uint(share != vec3(0.0)) << (light % LIGHTS_PER_LAYER);
    uvec3 steps = uvec3(round(clamp(share, 0.0, 1.0) * vec3(2047.0, 2047.0, 1023.0)));
    return steps.r | steps.g << 11 | steps.b << 22;
}

vec3 unpack_transmittance(uint texel, uint light) {
    if (!HAS_THIN_SURFACES) return vec3(texel >> (light % LIGHTS_PER_LAYER) & 1u);
    return vec3(uvec3(texel, texel >> 11, texel >> 22) & uvec3(2047u, 2047u, 1023u)) / vec3(2047.0, 2047.0, 1023.0);
}
