#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// The discontinuity buffer (Wald et al. 2002): which pixels of the window around each pixel have normals that agree and
// positions near the plane of its centre. It stands where the G-buffer does.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "packed_surface.glsl"
#include "interleave.glsl"

layout(local_size_x = 32, local_size_y = 2) in;

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 2) uniform utextureBuffer packed_surfaces;
layout(set = 0, binding = 3, rgba32ui) uniform writeonly uimageBuffer discontinuities;

layout(push_constant) uniform Push { uvec2 first; /* thread with anything to do */ } push;

#include "same_surface.glsl"
#include "window.glsl"

// Everything is by pixel of the thread in the components of vectors.
struct Centres {
    vec4 shading_x, shading_y, shading_z;
    vec4 slope_x, slope_y, slope_z;
    vec4 offset, tolerance;
    ivec4 corner_y;
};

Centres centres_at(ivec2 first) {
    Centres centres;
    [[unroll]] for (int row = 0; row < ROWS; row++) {
        ivec2 pixel = first + ivec2(0, row);
        Surface surface = surface_at(min(pixel, ivec2(frame.size) - 1), unpack_depth(packed_at(pixel)));
        centres.shading_x[row] = surface.shading.x;
        centres.shading_y[row] = surface.shading.y;
        centres.shading_z[row] = surface.shading.z;
        centres.slope_x[row] = surface.slope.x;
        centres.slope_y[row] = surface.slope.y;
        centres.slope_z[row] = surface.slope.z;
        centres.offset[row] = surface.offset;
        centres.tolerance[row] = surface.tolerance;
        centres.corner_y[row] = corner_of(pixel).y;
    }
    return centres;
}

// True for each of the centres that the texel lies on the surface of. Twin: `same_surface` in same_surface.glsl.
bvec4 same_surfaces(Centres centres, uint packed, ivec2 at) {
    vec3 normal = unpack_normal(packed);
    float depth = unpack_depth(packed);
    vec4 slope = centres.slope_x * float(at.x) + centres.slope_y * float(at.y) + centres.slope_z;
    vec4 distance = depth * slope - centres.offset;
    vec4 cosine = normal.x * centres.shading_x + normal.y * centres.shading_y + normal.z * centres.shading_z;
    bvec4 near = lessThanEqual(abs(distance), centres.tolerance);
    bvec4 alike = greaterThanEqual(cosine, vec4(MIN_NORMAL_COSINE * length(normal)));
    return bvec4(uvec4(near) & uvec4(alike) & uint(is_surface(packed)));
}

void main() {
    ivec2 thread = ivec2(gl_GlobalInvocationID.xy + push.first);
    ivec2 first = thread * ivec2(1, ROWS);
    if (any(greaterThanEqual(first, ivec2(frame.size)))) return;
    Centres centres = centres_at(first);
    int corner_x = corner_of(first).x;
    uvec4 words[MOST_WORDS];
    [[unroll]] for (int word = 0; word < WORDS; word++) words[word] = uvec4(0u);
    [[unroll]] for (int row = 0; row < WIDTH + ROWS - 1; row++) {
        int y = centres.corner_y[0] + row;
        uvec4 same = uvec4(0u);
        [[unroll]] for (int column = 0; column < WIDTH; column++) {
            ivec2 at = ivec2(corner_x + column, y);
            same |= uvec4(same_surfaces(centres, packed_at(at), at)) << column;
        }
        note_row(words, centres.corner_y, y, same);
    }
    [[unroll]] for (int word = 0; word < WORDS; word++) imageStore(discontinuities, word_texel(thread, word), words[word]);
}
