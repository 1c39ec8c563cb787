#version 460
#extension GL_GOOGLE_include_directive : require
// Inserts samples into a map of cells, for tests/device/cells.rs. In: vertices. Out: their keys, and the map.
#include "cells.glsl"
#define CELL_MAP_BINDING 5
#include "cell_map.glsl"

layout(local_size_x = 64) in;

struct Vertex {
    vec4 position; // w: width of the cell
    vec4 normal;   // w: the sample
};

layout(set = 0, binding = 0, std430) readonly buffer VertexBlock { Vertex data[]; } vertices;
layout(set = 0, binding = 1, std430) writeonly buffer KeyBlock { uvec2 data[]; } keys;
layout(set = 0, binding = 2, std430) buffer DropBlock { uint count; } dropped;

layout(push_constant) uniform Push { uint bits; uint probes; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(vertices.data.length())) return;
    Vertex vertex = vertices.data[i];
    int level = level_of(vertex.position.w);
    CellKey key = key_of(place_of(vertex.position.xyz, level), level, normal_bits(vertex.normal.xyz, push.bits), true);
    keys.data[i] = uvec2(key.index, key.verification);
    uint slot = claim_cell(key, push.probes);
    if (slot == NO_SLOT) atomicAdd(dropped.count, 1u);
    else add_to_cell(slot, vec3(vertex.normal.w, 2.0 * vertex.normal.w, 1e6 * vertex.normal.w));
}
