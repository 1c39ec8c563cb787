#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// Sums the n x n classes around each pixel, from the pixels that lie on its surface (discontinuities.comp), scaled up by
// what the missing classes would have brought (Wald et al. 2002). That share is taken over all temporal sets
// (present_flux.comp), so that it does not depend on how the VPLs of a class are dealt to sets. Out: the set buffer,
// irradiance and view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "packed_surface.glsl"
#include "packed_irradiance.glsl"
#include "interleave.glsl"
#include "vpls.glsl"
#define VPL_SET_BINDING 6
#include "vpl_set.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 2) uniform utextureBuffer class_irradiance;
layout(set = 0, binding = 3) uniform utextureBuffer packed_surfaces;
layout(set = 0, binding = 4) uniform utextureBuffer discontinuities;
layout(set = 0, binding = 5) uniform utextureBuffer present_flux;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2DArray set_buffers;

layout(push_constant) uniform Push {
    float total_flux; // of all classes
    uint layer;       // of the set buffers, for this set
    uint first_texel; // of the VPLs
} push;

#include "same_surface.glsl"
#include "window.glsl"

// Share of the flux that the window has to bring; else pixels farther away are asked as well.
const float MIN_PRESENT = 0.25;

// Irradiance from the VPLs of a pixel's class.
vec3 class_at(int texel) { return unpack_irradiance(texelFetch(class_irradiance, texel).rg); }

// By pixel of the thread.
struct Sums {
    vec4 red, green, blue;
    vec4 present; // luminous flux of the classes that were found, each as often as it was
};

// Adds up the pixels of the windows that lie on the centres' surfaces.
Sums window_sums(ivec2 thread, ivec2 corner, ivec4 corner_y) {
    uvec4 words[WORDS];
    [[unroll]] for (int word = 0; word < WORDS; word++) words[word] = texelFetch(discontinuities, word_texel(thread, word));
    vec4 present = uintBitsToFloat(texelFetch(present_flux, word_texel(thread, 0)));
    Sums sums = Sums(vec4(0.0), vec4(0.0), vec4(0.0), present);
    // Below the picture nothing counts.
    int last = int(frame.size.x * frame.size.y) - 1;
    [[unroll]] for (int row = 0; row < WIDTH + ROWS - 1; row++) {
        int y = corner.y + row;
        Row windows = row_at(words, corner_y, y);
        int texel = y * int(frame.size.x) + corner.x;
        [[unroll]] for (int column = 0; column < WIDTH; column++) {
            vec3 of_class = class_at(min(texel + column, last));
            vec4 shares = shares_at(windows, column);
            sums.red += shares * of_class.r;
            sums.green += shares * of_class.g;
            sums.blue += shares * of_class.b;
        }
    }
    return sums;
}

// Adds pixels farther away, one of each class again: every STEP-th, with no factor in common with n. Loops ask at their end
// whether to go on: see tracer_find.
const int STEP = INTERLEAVE % 3u != 0u ? 3 : INTERLEAVE == 6u ? 5 : 2;

void add_farther(inout Sums sums, ivec2 pixel, int row) {
    Surface surface = surface_at(pixel, unpack_depth(packed_at(pixel)));
    ivec2 corner = pixel - (int(INTERLEAVE - 1u) * STEP) / 2;
    uint place = 0u;
    do {
        ivec2 at = corner + ivec2(place % INTERLEAVE, place / INTERLEAVE) * STEP;
        bool same = same_surface(surface, packed_at(at), at);
        vec3 of_class = same ? class_at(at.y * int(frame.size.x) + at.x) : vec3(0.0);
        sums.red[row] += of_class.r;
        sums.green[row] += of_class.g;
        sums.blue[row] += of_class.b;
        sums.present[row] += same ? vpl_class(push.first_texel, class_of(uvec2(at))).flux : 0.0;
    } while (++place < INTERLEAVE * INTERLEAVE);
}

void main() {
    ivec2 thread = ivec2(gl_GlobalInvocationID.xy);
    ivec2 first = thread * ivec2(1, ROWS);
    if (any(greaterThanEqual(first, ivec2(frame.size)))) return;
    ivec2 corner = corner_of(first);
    ivec4 corner_y;
    vec4 depth; // 0 where no surface is
    [[unroll]] for (int row = 0; row < ROWS; row++) {
        corner_y[row] = corner_of(first + ivec2(0, row)).y;
        depth[row] = unpack_depth(packed_at(first + ivec2(0, row)));
    }
    Sums sums = window_sums(thread, corner, corner_y);
    // On thin and curved things few classes lie on the surface: without more of them it would be speckled.
    uint few = 0u;
    [[unroll]] for (int row = 0; row < ROWS; row++) {
        bool lacks = depth[row] > 0.0 && sums.present[row] < MIN_PRESENT * push.total_flux;
        few |= lacks ? 1u << row : 0u;
    }
    if (few != 0u) {
        do {
            int row = findLSB(few);
            add_farther(sums, first + ivec2(0, row), row);
            few &= few - 1u;
        } while (few != 0u);
    }
    [[unroll]] for (int row = 0; row < ROWS; row++) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= int(frame.size.y)) continue;
        vec3 irradiance = vec3(sums.red[row], sums.green[row], sums.blue[row]);
        float scale = sums.present[row] > 0.0 ? push.total_flux / sums.present[row] * frame.irradiance_scale : 0.0;
        vec4 stored = depth[row] > 0.0 ? vec4(irradiance * scale, depth[row]) : vec4(0.0);
        imageStore(set_buffers, ivec3(pixel, int(push.layer)), stored);
    }
}
