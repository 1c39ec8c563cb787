// The cells of a vertex. Needs cells.glsl, cell_map.glsl, cell_push.glsl and pcg.glsl.

// Each level's cells are so many powers of two wider than those of the one before.
const int LEVEL_STEP = 2;
// Samples from which on a cell is read, before a coarser one is.
const float ENOUGH = 8.0;
// How far a normal is jittered.
const float NORMAL_JITTER = 0.3;

// In the key beside the bits of the normal: the light of visible surfaces lacks direct light that other passes bring, so that their cells are
// not those of further vertices.
const uint WITHOUT_DIRECT_LIGHT = 16u;

// Random numbers of vertex k: `turn` tells insertion, reading, and jitters apart.
vec3 jitter_of(ivec2 pixel, uint k, uint turn) {
    uvec3 bits = pcg3d(uvec3(pixel, frame.noise_frame));
    bits = pcg3d(bits ^ uvec3(frame.seed, k, turn));
    return vec3(bits >> 8u) * exp2(-23.0) - 1.0;
}

// The width of the cell of a vertex, before it is rounded to a power of two.
float cell_width(vec3 position, bool is_visible) {
    return distance(position, frame.eye.xyz) * push.spread * (is_visible ? 1.0 : push.widening);
}

// The cell of a vertex, moved by `random` of -1 to 1 along its surface. `dither`: powers of two that the width is raised by before it is
// rounded, so that borders of levels are not seen.
CellKey cell_of(vec3 position, vec3 normal, bool is_visible, vec3 random, float dither, uint level) {
    float width = width_of(level_of(cell_width(position, is_visible) * exp2(dither)));
    vec3 moved = position + push.jitter * width * (random - normal * dot(normal, random));
    int exponent = level_of(cell_width(moved, is_visible) * exp2(dither)) + int(level) * LEVEL_STEP;
    if (push.normal == CELL_NORMAL_JITTERED) normal = normalize(normal + NORMAL_JITTER * random.zxy);
    uint bits = normal_bits(normal, push.bits) | (is_visible && frame.direct_lights > 0u ? WITHOUT_DIRECT_LIGHT : 0u);
    return key_of(place_of(moved, exponent), exponent, bits, push.normal != CELL_NORMAL_VERIFICATION);
}

// The mean irradiance of a vertex's cells at jittered positions; a: how many of these had a cell. Where that has few samples a coarser
// one is read.
vec4 read_cells(vec3 position, vec3 normal, bool is_visible, ivec2 pixel, uint k, uint turn, bool dithers) {
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < push.jitters; i++) {
        vec3 random = jitter_of(pixel, k, turn + i);
        vec4 best = vec4(0.0);
        for (uint level = 0u; level < push.levels && best.a < ENOUGH; level++) {
            CellKey key = cell_of(position, normal, is_visible, random, dithers ? 0.5 + 0.5 * random.z : 0.0, level);
            uint slot = find_cell(key, push.probes);
            if (slot == NO_SLOT) continue;
            vec4 mean = cell_means.data[slot];
            if (mean.a > best.a) best = mean;
        }
        if (best.a > 0.0) sum += vec4(best.rgb, 1.0);
    }
    return sum.a > 0.0 ? vec4(sum.rgb / sum.a, sum.a) : vec4(0.0);
}
