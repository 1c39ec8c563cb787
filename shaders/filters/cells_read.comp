#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The irradiance of the visible surfaces by cells: that of their own, or for the cache by their light and the cells of the second vertices.
// Where there is no cell it is that of the pixel's own paths, bit for bit. In: means of cells, vertices. Out: irradiance.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "pcg.glsl"
#include "cells.glsl"
#define CELL_MAP_BINDING 5
#include "cell_map.glsl"
#include "cell_push.glsl"
#include "cell_of_vertex.glsl"
#include "cell_filter.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D irradiance;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D filtered;
#define PATH_VERTICES_BINDING 20
#define PATH_VERTICES_ACCESS readonly
#include "path_vertices.glsl"

const uint READS_VISIBLE = 16u;

// The mean over the pixel's paths of the irradiance that cells_insert.comp has left: by the path's own light and its second vertex's cell.
vec3 cached(ivec2 pixel) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < push.samples; i++) sum += unpack_emission(imageLoad(path_lights, ivec3(pixel, i * VERTICES)).x);
    return sum / float(push.samples);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    vec4 own = imageLoad(irradiance, pixel);
    vec3 light = own.rgb;
    if (surface.depth > 0.0 && push.probes > 0u) {
        if (CACHE) {
            light = cached(pixel);
        } else {
            vec4 mean = read_cells(surface.position, surface.geometric, true, pixel, 0u, READS_VISIBLE, false);
            if (mean.a > 0.0) light = mean.rgb;
        }
    }
    imageStore(filtered, pixel, storable(vec4(light, own.a)));
}
