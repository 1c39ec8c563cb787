#version 460
#extension GL_GOOGLE_include_directive : require
// Takes the sums of a frame into the means of cells, and evicts cells that had no samples for long. In: sums. Out: means, ages, free slots.
#include "cells.glsl"
#define CELL_MAP_BINDING 5
#include "cell_map.glsl"
#include "cell_push.glsl"
#include "cell_counters.glsl"

layout(local_size_x = 256) in;

// Frames with samples, at most 65535; in the low half: without, since the last one.
layout(set = 0, binding = 9, std430) buffer CellAgeBlock { uint words[]; } cell_ages;

// Most samples that a mean counts: beyond, single precision would not change.
const float MOST_SAMPLES = 4194304.0;

float sum_of(uint word) { return float(cell_sums.words[word + SUM_HIGH]) * HIGH + float(cell_sums.words[word]) / QUANTA; }

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= uint(cell_keys.words.length()) || cell_keys.words[slot] == 0u) return;
    uint first = slot * SUM_WORDS;
    float count = float(cell_sums.words[first + SUM_COUNT]);
    if (count == 0.0) {
        uint age = cell_ages.words[slot] + 1u;
        bool is_evicted = (age & 0xffffu) >= push.life;
        cell_ages.words[slot] = is_evicted ? 0u : age;
        count_cells(is_evicted ? CELLS_EVICTED : CELLS_OCCUPIED, 1u);
        if (!is_evicted) return;
        cell_keys.words[slot] = 0u;
        cell_means.data[slot] = vec4(0.0);
        return;
    }
    count_cells(CELLS_OCCUPIED, 1u);
    float frames = min(float(cell_ages.words[slot] >> 16) + 1.0, 65535.0);
    // Once the window is short, as where light changes, it grows from there.
    if (push.window > 0u) frames = min(frames, ceil(float(push.window - 1u) / push.growth));
    cell_ages.words[slot] = uint(frames) << 16;
    vec3 mean = vec3(sum_of(first), sum_of(first + 1u), sum_of(first + 2u)) / count;
    for (uint i = 0u; i < SUM_WORDS; i++) cell_sums.words[first + i] = 0u;
    vec4 before = cell_means.data[slot];
    // The newest frame has at least the share of one in `window`; at first of fewer.
    float window = 1.0 + push.growth * frames;
    if (push.window > 0u) window = min(window, float(push.window));
    before.a = min(before.a, count * (window - 1.0));
    float all = min(before.a + count, MOST_SAMPLES);
    cell_means.data[slot] = vec4(mix(before.rgb, mean, count / all), all);
}
