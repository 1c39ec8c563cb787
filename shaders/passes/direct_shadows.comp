#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One occlusion ray for each pixel and light that it faces. Out: a bit for each light, set where the pixel sees it.
#include "frame.glsl"
#include "gbuffer.glsl"
#define TRACER_BINDING 5
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, std430) readonly buffer LightBlock { LightData data[]; } lights;
layout(set = 0, binding = 4, r32ui) uniform writeonly uimage2DArray direct_shadows;

// Beyond every scene, for rays to lights that are infinitely far away.
const float FAR = 1e30;

bool sees(Surface surface, LightData light) {
    vec3 to_light;
    if (surface.depth == 0.0 || unshadowed_irradiance(light, surface, to_light) == vec3(0.0)) return false;
    vec3 origin = ray_origin(surface);
    bool directional = light.kind == LIGHT_DIRECTIONAL;
    vec3 direction = directional ? to_light : light.position.xyz - origin;
    return !trace_occluded(origin, direction, 0.0, directional ? FAR : 1.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    for (uint first = 0u; first < frame.light_count; first += LIGHTS_PER_LAYER) {
        uint visible = 0u;
        uint end = min(first + LIGHTS_PER_LAYER, frame.light_count);
        for (uint i = first; i < end; i++) {
            if (sees(surface, lights.data[i])) visible |= 1u << (i - first);
        }
        imageStore(direct_shadows, ivec3(pixel, first / LIGHTS_PER_LAYER), uvec4(visible));
    }
}
