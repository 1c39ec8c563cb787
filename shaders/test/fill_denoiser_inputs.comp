#version 460
#extension GL_GOOGLE_include_directive : require
// Fills the inputs of a denoiser from a buffer, for tests/denoise.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

struct DenoiserPixel {
    vec4 noisy;
    vec4 normals; // octahedral: shading, geometric
    vec4 reprojected;
    float depth;
    uint pad0;
    uint pad1;
    uint pad2;
};

layout(set = 0, binding = 1, std430) readonly buffer PixelBlock { DenoiserPixel data[]; } pixels;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D noisy;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D gbuffer_normal;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D reprojected;
layout(set = 0, binding = 5, r32f) uniform writeonly image2D gbuffer_depth;
layout(set = 0, binding = 6, rgba16ui) uniform writeonly uimage2D surface;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    DenoiserPixel data = pixels.data[pixel.y * int(frame.size.x) + pixel.x];
    imageStore(noisy, pixel, data.noisy);
    imageStore(gbuffer_normal, pixel, data.normals);
    imageStore(reprojected, pixel, data.reprojected);
    imageStore(gbuffer_depth, pixel, vec4(data.depth));
    vec3 shading = octahedral_decode(data.normals.xy);
    imageStore(surface, pixel, data.depth > 0.0 ? pack_surface(VisibleSurface(data.depth, shading)) : uvec4(0u));
}
