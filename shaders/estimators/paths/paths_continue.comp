#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Goes on with the path that the last frame kept, by one light and one scattered ray (Meijer 2019, A-nHPSF). Where none was kept, or it
// has all the vertices that it may have, it goes on from the deepest vertex of this frame's path. In: the vertices of the paths, the kept
// one in the last of two layers behind them. Out: its light in the first, what it meets in the last, to be kept.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
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
#include "path_push.glsl"
#define PATH_VERTICES_BINDING 20
#define PATH_VERTICES_ACCESS
#include "path_vertices.glsl"
layout(set = 0, binding = 22, r32ui) uniform uimage2D path_depths;

layout(constant_id = 3) const uint SAMPLES = 1u;
layout(constant_id = 4) const uint VERTICES = 1u;
// Vertices of a path at most.
layout(constant_id = 5) const uint DEPTH = 4u;

// The vertex that is lit, and what it meets.
const uint STORED_VERTICES = 2u;
#include "store_vertices.glsl"
#include "path.glsl"

// The first ones are those of other rays.
const uint FIRST_DIMENSION = 110u;

PathVertex vertex_at(ivec2 pixel, uint layer) {
    ivec3 place = ivec3(pixel, layer);
    return unpack_vertex(imageLoad(path_places, place), imageLoad(path_lights, place).xy);
}

// The deepest vertex of this frame's path; `depth`: its number, from 1.
PathVertex deepest_vertex(ivec2 pixel, out uint depth) {
    PathVertex deepest = vertex_at(pixel, 0u);
    depth = 1u;
    while (depth < min(VERTICES, DEPTH) && deepest.state == VERTEX_LIT) {
        PathVertex next = vertex_at(pixel, depth);
        if (next.state == VERTEX_ABSENT) break;
        deepest = next;
        depth++;
    }
    return deepest;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool in_picture = all(lessThan(gl_GlobalInvocationID.xy, frame.size));
    uint rays = 0u;
    if (in_picture) {
        first_layer = SAMPLES * VERTICES;
        stored = 0u;
        uint depth = push.keeps == 1u ? imageLoad(path_depths, pixel).x : 0u;
        bool is_kept = depth > 0u;
        if (surface_at(pixel).depth > 0.0) {
            PathVertex vertex;
            if (is_kept) vertex = vertex_at(pixel, first_layer + 1u);
            else vertex = deepest_vertex(pixel, depth);
            Surface surface = Surface(vertex.position, vertex.normal, vertex.normal, 1.0, 0.0);
            path_irradiance(surface, RayCone(0.0, push.spread), 0u, pixel, frame.noise_frame, FIRST_DIMENSION, rays);
            bool goes_on = vertex_at(pixel, first_layer + 1u).state != VERTEX_ABSENT;
            depth = goes_on && depth < DEPTH ? depth + 1u : 0u;
        } else {
            depth = 0u;
        }
        imageStore(path_depths, pixel, uvec4(depth));
    }
    count_rays(rays);
}
