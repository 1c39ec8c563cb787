#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// Sums the n x n classes around each pixel, from the pixels that lie on its surface (discontinuities.comp), scaled up by
// what the missing classes would have brought (Wald et al. 2002). That share is taken over all temporal sets, so that it
// does not depend on how the VPLs of a class are dealt to sets. Out: the set buffer, irradiance and view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "packed_surface.glsl"
#include "packed_irradiance.glsl"
#include "interleave.glsl"
#include "vpls.glsl"
#define VPL_SET_BINDING 6
#include "vpl_set.glsl"
#include "tile_list.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 2) uniform utextureBuffer class_irradiance;
layout(set = 0, binding = 3) uniform utextureBuffer packed_surfaces;
layout(set = 0, binding = 4) uniform utextureBuffer discontinuities;
layout(set = 0, binding = 5) uniform utextureBuffer present_flux;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2DArray set_buffers;
layout(set = 0, binding = 8, std430) readonly buffer ListBlock { TileList list; uint tiles[]; } filter_tiles;

struct Push {
    float total_flux; // of all classes
    uint layer;       // of the set buffers, for this set
    uint first_texel; // of the VPLs
};
// Loaded before threads part, as `frame` is.
layout(push_constant) uniform PushBlock { Push data; } pushed;
Push push = pushed.data;

#include "same_surface.glsl"
#include "window.glsl"
#include "filter_tiles.glsl"

// Share of the flux that the window has to bring; else pixels farther away are asked as well. Not a quarter: that is what a
// line of pixels brings, and rounding would decide.
const float MIN_PRESENT = 0.27;

// Whether the flux that windows bring is worked out here, or was in present_flux.comp.
layout(constant_id = 1) const bool WEIGHS = false;
// Whether no window reaches beyond the picture, so that each begins a row below the one above.
layout(constant_id = 2) const bool INSIDE = false;

// Irradiance from the VPLs of a pixel's class.
vec3 class_at(int texel) { return unpack_irradiance(texelFetch(class_irradiance, texel).rg); }

// By pixel of a column.
struct Sums {
    vec4 red, green, blue;
};

// A column of pixels that a thread takes care of.
struct Strip {
    ivec2 first; // pixel
    ivec2 corner; // of its window
    ivec4 corner_y; // of each
    vec4 depth; // 0 where no surface is
    vec4 present; // luminous flux of the classes that were found, each as often as it was
    uvec4 words[MOST_WORDS];
};

Strip strip_at(ivec2 place) {
    Strip strip;
    strip.first = place * ivec2(1, ROWS);
    strip.corner = corner_of(strip.first);
    [[unroll]] for (int row = 0; row < ROWS; row++) {
        ivec2 pixel = strip.first + ivec2(0, row);
        strip.corner_y[row] = corner_of(pixel).y;
        strip.depth[row] = unpack_depth(packed_at(pixel));
    }
    // Beside and below the picture there is nothing to fetch, and nothing is written.
    ivec2 inside = thread_inside(place);
    strip.present = WEIGHS ? vec4(0.0) : uintBitsToFloat(texelFetch(present_flux, word_texel(inside, 0)));
    [[unroll]] for (int word = 0; word < WORDS; word++) {
        strip.words[word] = texelFetch(discontinuities, word_texel(inside, word));
    }
    return strip;
}

// Adds up the pixels of the windows that lie on the centres' surfaces.
Sums[COLUMNS] window_sums(inout Strip strips[COLUMNS]) {
    Sums sums[COLUMNS];
    [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) sums[strip] = Sums(vec4(0.0), vec4(0.0), vec4(0.0));
    // Below the picture nothing counts.
    int last = int(frame.size.x * frame.size.y) - 1;
    int offsets[COLUMNS]; // of the windows; at the picture's borders they lie on one another
    [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
        offsets[strip] = INSIDE ? strip : strips[strip].corner.x - strips[0].corner.x;
    }
    // Luminous, by class, from the corner on.
    float flux[INTERLEAVE][INTERLEAVE];
    const int n = int(INTERLEAVE);
    [[unroll]] for (int row = 0; row < WIDTH + ROWS - 1; row++) {
        Row windows[COLUMNS];
        [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
            ivec4 corner_y = INSIDE ? ivec4(0, 1, 2, 3) : strips[strip].corner_y - strips[0].corner.y;
            windows[strip] = row_at(strips[strip].words, corner_y, row);
            windows[strip].same <<= offsets[strip];
        }
        int texel = texel_of(strips[0].corner + ivec2(0, row));
        [[unroll]] for (int column = 0; column < WIDTH + COLUMNS - 1; column++) {
            vec3 of_class = class_at(min(texel + column, last));
            if (WEIGHS && row < n && column < n) {
                flux[row][column] = flux_at(push.first_texel, strips[0].corner + ivec2(column, row));
            }
            [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
                if (column >= strip + WIDTH) continue;
                vec4 shares = shares_at(windows[strip], column, weight_at(column - offsets[strip]));
                sums[strip].red += shares * of_class.r;
                sums[strip].green += shares * of_class.g;
                sums[strip].blue += shares * of_class.b;
                if (WEIGHS) strips[strip].present += shares * flux[row % n][column % n];
            }
        }
    }
    return sums;
}

// From one pixel to the next of those farther away: no factor in common with n, so that each class is there once.
const int STEP = INTERLEAVE % 3u != 0u ? 3 : INTERLEAVE == 6u ? 5 : 2;

// What pixels farther away bring, one of each class again; a: luminous flux of those that lie on the surface. Loops ask at
// their end whether to go on: see tracer_find.
vec4 farther_sum(ivec2 pixel) {
    Surface surface = surface_at(pixel, unpack_depth(packed_at(pixel)));
    ivec2 corner = pixel - (int(INTERLEAVE - 1u) * STEP) / 2;
    vec4 sum = vec4(0.0);
    uint place = 0u;
    do {
        ivec2 at = corner + ivec2(place % INTERLEAVE, place / INTERLEAVE) * STEP;
        bool same = same_surface(surface, packed_at(at), at);
        if (same) sum += vec4(class_at(texel_of(at)), flux_at(push.first_texel, at));
    } while (++place < INTERLEAVE * INTERLEAVE);
    return sum;
}

void main() {
    uint thread = group_in_list() * GROUP_THREADS + gl_LocalInvocationID.x;
    uint place = thread / TILE_THREADS;
    if (place >= filter_tiles.list.count) return;
    ivec2 first = corner_of_tile(filter_tiles.tiles[place]) / ivec2(1, ROWS);
    int in_tile = int(thread % TILE_THREADS);
    first += ivec2(in_tile % THREADS_ACROSS * COLUMNS, in_tile / THREADS_ACROSS);
    Strip strips[COLUMNS];
    [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) strips[strip] = strip_at(first + ivec2(strip, 0));
    Sums sums[COLUMNS] = window_sums(strips);
    // On thin and curved things few classes lie on the surface: without more of them it would be speckled.
    uint few = 0u;
    [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
        [[unroll]] for (int row = 0; row < ROWS; row++) {
            bool lacks = strips[strip].depth[row] > 0.0
                && strips[strip].present[row] < MIN_PRESENT * push.total_flux;
            few |= lacks ? 1u << (strip * ROWS + row) : 0u;
        }
    }
    if (few != 0u) {
        do {
            int lacking = findLSB(few);
            vec4 found = farther_sum(strips[0].first + ivec2(lacking / ROWS, lacking % ROWS));
            [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
                bvec4 here = equal(ivec4(lacking), ivec4(0, 1, 2, 3) + strip * ROWS);
                sums[strip].red += mix(vec4(0.0), vec4(found.r), here);
                sums[strip].green += mix(vec4(0.0), vec4(found.g), here);
                sums[strip].blue += mix(vec4(0.0), vec4(found.b), here);
                strips[strip].present += mix(vec4(0.0), vec4(found.a), here);
            }
            few &= few - 1u;
        } while (few != 0u);
    }
    [[unroll]] for (int strip = 0; strip < COLUMNS; strip++) {
        [[unroll]] for (int row = 0; row < ROWS; row++) {
            ivec2 pixel = strips[strip].first + ivec2(0, row);
            if (any(greaterThanEqual(pixel, ivec2(frame.size)))) continue;
            vec3 irradiance = vec3(sums[strip].red[row], sums[strip].green[row], sums[strip].blue[row]);
            float present = strips[strip].present[row];
            float depth = strips[strip].depth[row];
            float scale = present > 0.0 ? push.total_flux / present * frame.irradiance_scale : 0.0;
            vec4 stored = depth > 0.0 ? vec4(irradiance * scale, depth) : vec4(0.0);
            imageStore(set_buffers, ivec3(pixel, int(push.layer)), stored);
        }
    }
}
