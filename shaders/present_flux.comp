#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// Luminous flux, over all temporal sets, of the classes in each pixel's window that lie on its surface, each as often as it
// is there: what the discontinuity filter scales its sums by. Only where frames share it: a single one works it out in the
// filter. Out: a texel for the pixels of a thread.
#include "frame.glsl"
#include "interleave.glsl"
#include "window.glsl"
#include "vpls.glsl"
#define VPL_SET_BINDING 1
#include "vpl_set.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

layout(set = 0, binding = 2) uniform utextureBuffer discontinuities;
layout(set = 0, binding = 3, rgba32ui) uniform writeonly uimageBuffer present_flux;

layout(push_constant) uniform Push {
    uvec2 first;      // thread with anything to do
    uint first_texel; // of the VPLs
    uint pad0;
} push;

void main() {
    ivec2 thread = ivec2(gl_GlobalInvocationID.xy + push.first);
    ivec2 first = thread * ivec2(1, ROWS);
    if (any(greaterThanEqual(first, ivec2(frame.size)))) return;
    uvec4 words[MOST_WORDS];
    [[unroll]] for (int word = 0; word < WORDS; word++) words[word] = texelFetch(discontinuities, word_texel(thread, word));
    ivec2 corner = corner_of(first);
    ivec4 corner_y;
    [[unroll]] for (int row = 0; row < ROWS; row++) corner_y[row] = corner_of(first + ivec2(0, row)).y;
    vec4 present = vec4(0.0);
    // By class, from the corner on.
    float flux[INTERLEAVE][INTERLEAVE];
    const int n = int(INTERLEAVE);
    [[unroll]] for (int row = 0; row < WIDTH + ROWS - 1; row++) {
        Row windows = row_at(words, corner_y, corner.y + row);
        [[unroll]] for (int column = 0; column < WIDTH; column++) {
            if (row < n && column < n) {
                flux[row][column] = flux_at(push.first_texel, corner + ivec2(column, row));
            }
            present += shares_at(windows, column, weight_at(column)) * flux[row % n][column % n];
        }
    }
    imageStore(present_flux, word_texel(thread, 0), floatBitsToUint(present));
}
