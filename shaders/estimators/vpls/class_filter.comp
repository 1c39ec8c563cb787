#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The discontinuity filter over a window of n x n pixels, one of each class, that lie on the surface of the pixel (Wald et al. 2002).
// Out: the layer of the set: scaled irradiance by all its VPLs; view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 4
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#define SET_BUFFERS_BINDING 6
#define SET_BUFFERS_WRITTEN
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 9, rgba32f) uniform readonly image2D gathered_irradiance;
#include "surface.glsl"

layout(constant_id = 0) const uint INTERLEAVE = 4u; // n

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface centre = surface_at(pixel);
    vec4 sum = vec4(0.0);
    int n = int(INTERLEAVE);
    for (int i = 0; i < n * n && centre.depth > 0.0; i++) {
        ivec2 at = pixel + ivec2(i % n, i / n) - (n - 1) / 2;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        Surface other = surface_at(at);
        bool same = other.depth > 0.0 && dot(other.shading, centre.shading) >= MIN_NORMAL_COSINE
            && same_surface(other.position - centre.position, centre.geometric, other.geometric, centre.depth);
        vec3 irradiance = imageLoad(gathered_irradiance, at).rgb;
        if (same && !any(isnan(irradiance)) && !any(isinf(irradiance))) sum += vec4(min(irradiance, MAX_STORED), 1.0);
    }
    // Where classes are missing the others stand for them.
    vec3 all = sum.rgb * float(n * n) / max(sum.a, 1.0);
    imageStore(set_buffers, ivec3(pixel, vpl.target), pack_texel(all, centre.depth, 0.0, vec3(0.5)));
}
