#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lights what reflection rays have hit by the cells there, if they are far enough from the mirror. In: the hits, means of cells. Out: their
// light is added to the reflection; hits that are lit have no weight any more.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "pcg.glsl"
#include "cells.glsl"
#define CELL_MAP_BINDING 5
#include "cell_map.glsl"
#include "cell_push.glsl"
#include "cell_of_vertex.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "hit_record.glsl"
layout(set = 0, binding = 8, rgba32ui) uniform readonly uimage2D hit_place;
layout(set = 0, binding = 9, rgba16f) uniform image2D hit_weight;
layout(set = 0, binding = 10, rgba16f) uniform image2D reflection;

// The layer and the turn of the random numbers, which no vertex of a path has.
const uint LAYER = 255u;
const uint READS_HITS = 24u;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size)) || push.probes == 0u) return;
    vec4 weight = imageLoad(hit_weight, pixel);
    if (weight.rgb == vec3(0.0)) return;
    HitRecord hit = unpack_hit(imageLoad(hit_place, pixel), weight);
    if (distance(hit.position, surface_at(pixel).position) < cell_width(hit.position, false)) return;
    vec4 mean = read_cells(hit.position, hit.geometric, false, pixel, LAYER, READS_HITS, true);
    if (mean.a == 0.0) return;
    vec4 before = imageLoad(reflection, pixel);
    imageStore(reflection, pixel, storable(vec4(before.rgb + hit.weight * mean.rgb, before.a)));
    imageStore(hit_weight, pixel, vec4(0.0, 0.0, 0.0, weight.a));
}
