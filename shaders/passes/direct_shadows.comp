#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One ray for each pixel and light that it faces. Out: the transmittance to each light: a bit, or a colour with thin surfaces.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
#include "light_transmittance.glsl"
layout(set = 0, binding = 4, r32ui) uniform writeonly uimage2DArray direct_shadows;

vec3 transmittance_at(Surface surface, LightData light) {
    vec3 to_light;
    if (surface.depth == 0.0 || unshadowed_irradiance(light, surface, to_light) == vec3(0.0)) return vec3(0.0);
    return light_transmittance(light, surface, to_light);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    for (uint first = 0u; first < frame.light_count; first += LIGHTS_PER_LAYER) {
        uint arriving = 0u;
        uint end = min(first + LIGHTS_PER_LAYER, frame.light_count);
        for (uint i = first; i < end; i++) {
            arriving |= pack_transmittance(transmittance_at(surface, lights.data[i]), i);
        }
        imageStore(direct_shadows, ivec3(pixel, first / LIGHTS_PER_LAYER), uvec4(arriving));
    }
}
