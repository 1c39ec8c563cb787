#version 460
#extension GL_GOOGLE_include_directive : require
// What the discontinuity filter needs of each pixel's surface, in a word: depth and shading normal.
#include "frame.glsl"
#include "packed_surface.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, r32ui) uniform writeonly uimageBuffer packed_surfaces;

layout(push_constant) uniform Push { uvec2 first; /* pixel that may have changed */ } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy + push.first);
    if (any(greaterThanEqual(pixel, ivec2(frame.size)))) return;
    float depth = imageLoad(gbuffer_depth, pixel).r;
    uint packed = pack_surface(depth, imageLoad(gbuffer_normal, pixel).xy);
    imageStore(packed_surfaces, texel_of(pixel), uvec4(packed));
}
