#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// Adds the irradiance of vertices to their cells. From a path's end to its beginning: own light, and the albedo of the next vertex times
// its irradiance, by the cells as they were in the last frame where there are any (Meijer 2019, nHPSF), else by the path itself. In:
// vertices. Out: sums of cells; the irradiance of each vertex as the path and the cells behind it have it, as its light.
#include "frame.glsl"
#include "gbuffer.glsl"
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
#include "cell_counters.glsl"
#define PATH_VERTICES_BINDING 20
#define PATH_VERTICES_ACCESS
#include "path_vertices.glsl"
layout(set = 0, binding = 22, r32ui) uniform readonly uimage2D path_depths;

const uint INSERTS = 0u;
const uint READS = 8u;
const uint MOST_DEPTH = 16u;

PathVertex vertex_at(ivec2 pixel, uint layer) {
    ivec3 place = ivec3(pixel, layer);
    return unpack_vertex(imageLoad(path_places, place), imageLoad(path_lights, place).xy);
}

void insert(PathVertex vertex, vec3 light, bool is_visible, ivec2 pixel, uint k) {
    for (uint i = 0u; i < push.jitters; i++) {
        vec3 random = jitter_of(pixel, k, INSERTS + i);
        for (uint level = 0u; level < push.levels; level++) {
            CellKey key = cell_of(vertex.position, vertex.normal, is_visible, random, CACHE ? 0.5 + 0.5 * random.z : 0.0, level);
            uint slot = claim_cell(key, push.probes);
            if (slot == NO_SLOT) count_cells(CELLS_DROPPED, 1u);
            else add_to_cell(slot, light);
        }
    }
}

// Irradiance of a vertex, W/m^2: the mean of its cell where the segment to it is long enough, else `found`, as the path has it.
vec3 look_up(PathVertex vertex, float segment_length, ivec2 pixel, uint layer, vec3 found) {
    // The last vertex of a path has no estimate but its cell.
    if (CACHE && vertex.state == VERTEX_LIT && segment_length < cell_width(vertex.position, false)) return found;
    vec4 mean = read_cells(vertex.position, vertex.normal, false, pixel, layer, READS, CACHE);
    return mean.a > 0.0 ? mean.rgb : found;
}

// A run of vertices, one behind the other, from layer `first` on. All count, also where the last one's cell is not known: cells with only
// the light of paths that end elsewhere, as in the sky, would be too bright.
void insert_path(ivec2 pixel, uint first) {
    uint count = 0u;
    for (uint state = VERTEX_LIT; count < VERTICES && state == VERTEX_LIT; count++) state = imageLoad(path_places, ivec3(pixel, first + count)).w >> 30;
    vec3 incoming = vec3(0.0);
    for (uint i = count; i-- > 0u;) {
        uint layer = first + i;
        PathVertex vertex = vertex_at(pixel, layer);
        if (vertex.state == VERTEX_ABSENT) continue;
        if (vertex.state == VERTEX_LIT) {
            vertex.light += vertex.next * incoming;
            if (i >= FIRST && i <= LAST) insert(vertex, vertex.light, i == 0u, pixel, layer);
            imageStore(path_lights, ivec3(pixel, layer), uvec4(pack_light(vertex), 0u, 0u));
            incoming = vertex.light;
        }
        if (i == 0u) return;
        float segment_length = distance(vertex.position, vertex_at(pixel, layer - 1u).position);
        incoming = look_up(vertex, segment_length, pixel, layer, incoming);
    }
}

// Counts the paths that the next frame goes on with, by their vertices; a subgroup adds once.
void count_kept(uint vertices) {
    for (uint i = 1u; i <= MOST_DEPTH; i++) {
        uint kept = subgroupAdd(vertices == i ? 1u : 0u);
        if (kept > 0u && subgroupElect()) count_cells(PATHS_KEPT + i - 1u, kept);
    }
}

// The vertex that a path of earlier frames went on from: its light and the cell of the next one (Meijer 2019, A-nHPSF).
void insert_continued(ivec2 pixel, uint layer) {
    PathVertex vertex = vertex_at(pixel, layer), next = vertex_at(pixel, layer + 1u);
    count_kept(imageLoad(path_depths, pixel).x);
    vec3 incoming = vec3(0.0);
    if (next.state != VERTEX_ABSENT) incoming = look_up(next, distance(vertex.position, next.position), pixel, layer + 1u, incoming);
    insert(vertex, vertex.light + vertex.next * incoming, false, pixel, layer);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    if (surface.depth == 0.0 || push.probes == 0u) return;
    if (VERTICES == 0u) {
        vec3 none = vec3(0.0);
        PathVertex visible = PathVertex(surface.position, surface.geometric, none, none, VERTEX_LIT);
        insert(visible, imageLoad(irradiance, pixel).rgb, true, pixel, 0u);
        return;
    }
    for (uint i = 0u; i < push.samples; i++) insert_path(pixel, i * VERTICES);
    if (CONTINUES) insert_continued(pixel, push.samples * VERTICES);
}
