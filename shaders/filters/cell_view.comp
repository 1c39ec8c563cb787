#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shows the cells of the visible surfaces instead of the picture: those that a vertex there reads, not jittered. In: the hash map. Out:
// display.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "pcg.glsl"
#include "false_colour.glsl"
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
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D display;
layout(set = 0, binding = 8, std430) readonly buffer CellAgeBlock { uint words[]; } cell_ages;

// Twin: VIEWS in src/filters/cell_view.rs.
const uint CELLS = 0u;
const uint LOD = 1u;
const uint SAMPLE_COUNT = 2u;
const uint AGE = 3u;
const uint PROBES = 4u;
const uint OCCUPANCY = 5u;

const vec3 MISSING = vec3(1.0, 0.0, 1.0);
// Samples that are shown brightest.
const float FULL_SAMPLES = 65536.0;

struct ShownCell {
    CellKey key;
    int lod;
    uint slot;
    float samples;
};

// The cell that `read_cells` would choose.
ShownCell shown_cell(Surface surface) {
    // The cache has cells from the second vertex of a path on.
    bool is_visible = !CACHE;
    ShownCell best;
    best.slot = NO_SLOT;
    best.samples = 0.0;
    for (uint level = 0u; level < push.levels && best.samples < ENOUGH; level++) {
        CellKey key = cell_of(surface.position, surface.geometric, is_visible, vec3(0.0), 0.0, level);
        uint slot = find_cell(key, push.probes);
        float samples = slot == NO_SLOT ? 0.0 : cell_means.data[slot].a;
        if (level > 0u && samples <= best.samples) continue;
        best = ShownCell(key, level_of(cell_width(surface.position, is_visible)) + int(level) * LEVEL_STEP, slot, samples);
    }
    return best;
}

vec3 cell_colour(ShownCell cell) {
    uint mask = uint(cell_keys.words.length()) - 1u;
    if (push.view == CELLS) return number_colour(cell.key.verification & 0xffffu);
    if (push.view == LOD) return number_colour(uint(cell.lod + 64));
    if (cell.slot == NO_SLOT) return MISSING;
    switch (push.view) {
        case SAMPLE_COUNT: return share_colour(log2(max(cell.samples, 1.0)) / log2(FULL_SAMPLES));
        case AGE: return share_colour(float(cell_ages.words[cell.slot] & 0xffffu) / float(push.life));
        default: return share_colour(float((cell.slot - cell.key.index) & mask) / float(push.probes));
    }
}

// The map itself, in rows: the share of a pixel's slots that hold a cell.
vec3 occupancy(ivec2 pixel) {
    float slots = float(cell_keys.words.length());
    float scale = slots / (float(frame.size.x) * float(frame.size.y));
    float at = float(pixel.y) * float(frame.size.x) + float(pixel.x);
    uint first = uint(at * scale), end = max(uint((at + 1.0) * scale), first + 1u);
    uint held = 0u;
    for (uint slot = first; slot < end; slot++) held += cell_keys.words[min(slot, uint(slots) - 1u)] != 0u ? 1u : 0u;
    return share_colour(float(held) / float(end - first));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec3 colour = vec3(0.0);
    if (push.view == OCCUPANCY) {
        colour = occupancy(pixel);
    } else {
        Surface surface = surface_at(pixel);
        if (surface.depth > 0.0) colour = cell_colour(shown_cell(surface));
    }
    imageStore(display, pixel, vec4(clamp(colour, 0.0, 1.0), 1.0));
}
