#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// Which tiles of the picture lie on one surface with all of their pixels' windows, which do not, and which have windows that
// are moved inside, at the picture's edges: the fewer of these a filter has to do with, the shorter it is. CPU drivers would
// run all of them where pixels side by side differ.
#include "frame.glsl"
#include "interleave.glsl"
#include "window.glsl"
#include "tile_list.glsl"
#include "filter_tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1) uniform utextureBuffer discontinuities;
layout(set = 0, binding = 2, std430) buffer WholeBlock { TileList list; uint tiles[]; } whole_tiles;
layout(set = 0, binding = 3, std430) buffer MixedBlock { TileList list; uint tiles[]; } mixed_tiles;
layout(set = 0, binding = 4, std430) buffer EdgeBlock { TileList list; uint tiles[]; } edge_tiles;

// All texels of the rows of a window that a word has.
uint all_of(int word) {
    uint bits = uint(min(WIDTH - word * ROWS_IN_WORD, ROWS_IN_WORD) * WIDTH);
    return bits == 32u ? 0xffffffffu : (1u << bits) - 1u;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    uint columns = uint(tile_columns());
    if (index >= columns * uint(tile_rows())) return;
    uint tile = pack_tile(uvec2(index % columns, index / columns));
    ivec2 corner = corner_of_tile(tile);
    ivec2 reach = ivec2(WIDTH / 2);
    bool inside = all(greaterThanEqual(corner, reach)) && all(lessThanEqual(corner + TILE + reach, ivec2(frame.size)));
    bool whole = true;
    uvec4 same[MOST_WORDS];
    [[unroll]] for (int word = 0; word < WORDS; word++) same[word] = uvec4(0xffffffffu);
    [[unroll]] for (int column = 0; column < TILE.x; column++) {
        [[unroll]] for (int row = 0; row < TILE.y; row += ROWS) {
            ivec2 thread = thread_inside(ivec2(corner.x + column, (corner.y + row) / ROWS));
            [[unroll]] for (int word = 0; word < WORDS; word++) {
                same[word] &= texelFetch(discontinuities, word_texel(thread, word));
            }
        }
    }
    [[unroll]] for (int word = 0; word < WORDS; word++) {
        whole = whole && all(equal(same[word] & all_of(word), uvec4(all_of(word))));
    }
    const uint per_group = GROUP_THREADS / TILE_THREADS;
    const uint whole_per_group = GROUP_THREADS / WHOLE_THREADS;
    if (inside && whole) {
        ADD_TILE(whole_tiles.list, whole_per_group, place);
        whole_tiles.tiles[place] = tile;
    } else if (inside) {
        ADD_TILE(mixed_tiles.list, per_group, place);
        mixed_tiles.tiles[place] = tile;
    } else {
        ADD_TILE(edge_tiles.list, per_group, place);
        edge_tiles.tiles[place] = tile;
    }
}
