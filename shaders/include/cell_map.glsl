// The map's buffers, its insertion and lookup. Define CELL_MAP_BINDING, the first of three, and include cells.glsl before.
// Twin: tests/device/cells.rs.

// The verification of each slot; 0: free.
layout(set = 0, binding = CELL_MAP_BINDING, std430) buffer CellKeyBlock { uint words[]; } cell_keys;
// Sums of this frame's samples: SUM_WORDS a slot.
layout(set = 0, binding = CELL_MAP_BINDING + 1, std430) buffer CellSumBlock { uint words[]; } cell_sums;
// rgb: mean irradiance up to the last frame that was resolved; a: samples in it.
layout(set = 0, binding = CELL_MAP_BINDING + 2, std430) buffer CellMeanBlock { vec4 data[]; } cell_means;

const uint NO_SLOT = 0xffffffffu;

uint slot_of(CellKey key, uint probe) { return (key.index + probe) & (uint(cell_keys.words.length()) - 1u); }

// The slot of a cell; NO_SLOT where it has none.
uint find_cell(CellKey key, uint probes) {
    for (uint probe = 0u; probe < probes; probe++) {
        uint slot = slot_of(key, probe);
        if (cell_keys.words[slot] == key.verification) return slot;
    }
    return NO_SLOT;
}

// The slot of a cell, or a free one that becomes its own; NO_SLOT where there is neither.
uint claim_cell(CellKey key, uint probes) {
    uint slot = find_cell(key, probes);
    if (slot != NO_SLOT) return slot;
    for (uint probe = 0u; probe < probes; probe++) {
        slot = slot_of(key, probe);
        uint before = atomicCompSwap(cell_keys.words[slot], 0u, key.verification);
        if (before == 0u || before == key.verification) return slot;
    }
    return NO_SLOT;
}

void add_to_cell(uint slot, vec3 sample_light) {
    for (uint channel = 0u; channel < 3u; channel++) {
        float light = clamp(sample_light[channel], 0.0, MOST_SAMPLE);
        uint high = uint(light / HIGH);
        uint low = uint(min((light - float(high) * HIGH) * QUANTA, MOST_LOW));
        uint word = slot * SUM_WORDS + channel;
        if (atomicAdd(cell_sums.words[word], low) > 0xffffffffu - low) high++;
        if (high > 0u) atomicAdd(cell_sums.words[word + SUM_HIGH], high);
    }
    atomicAdd(cell_sums.words[slot * SUM_WORDS + SUM_COUNT], 1u);
}
