#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Indirect light by path tracing: a few paths a pixel, each from the visible surface. In: the visible surfaces. Out: irradiance, and the
// vertices of the paths where a filter asks for them.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "rounded.glsl"
#include "tracer.glsl"
#include "hit.glsl"
#include "noise.glsl"
#define RAY_COUNTER_BINDING 8
#include "ray_counter.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
#include "unshadowed.glsl"
#include "light_sampling.glsl"
#include "environment.glsl"
#include "environment_sampling.glsl"
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D irradiance;
#include "path_push.glsl"
#define PATH_VERTICES_BINDING 20
#define PATH_VERTICES_ACCESS writeonly
#include "path_vertices.glsl"

// Paths a pixel.
layout(constant_id = 3) const uint SAMPLES = 1u;
// Vertices of a path that are stored for filters.
layout(constant_id = 4) const uint VERTICES = 0u;
const uint STORED_VERTICES = VERTICES;
#include "store_vertices.glsl"
#include "path.glsl"

// The first ones are those of soft shadows and reflections.
const uint FIRST_DIMENSION = 20u;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool in_picture = all(lessThan(gl_GlobalInvocationID.xy, frame.size));
    uint rays = 0u;
    vec3 sum = vec3(0.0);
    if (in_picture) {
        Surface surface = surface_at(pixel);
        RayCone cone = RayCone(push.spread * surface.depth, push.spread);
        for (uint i = 0u; i < (surface.depth > 0.0 ? SAMPLES : 0u); i++) {
            first_layer = i * VERTICES;
            stored = 0u;
            sum += path_irradiance(surface, cone, frame.direct_lights, pixel, frame.noise_frame * SAMPLES + i, FIRST_DIMENSION, rays);
        }
        imageStore(irradiance, pixel, storable(vec4(sum / float(SAMPLES), 1.0)));
    }
    count_rays(rays);
}
