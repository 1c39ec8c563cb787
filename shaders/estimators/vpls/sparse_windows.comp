#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Texels of the set buffer whose windows hold too few classes, on thin things and in grooves, gather the set, or every so many
// of its VPLs, by rays of their own; the threads of a workgroup share these rays out. Out: the layer of the set, without
// negative depths.
#include "frame.glsl"
#include "gbuffer.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#define RAY_COUNTER_BINDING 6
#include "ray_counter.glsl"
#include "representative.glsl"
#define TRACER_BINDING 7
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, rgba16f) uniform image2DArray set_buffers;
#include "surface.glsl"
#include "gather.glsl"

layout(push_constant) uniform Push {
    uint set_step;
    uint stride; // from one VPL that is gathered to the next; each stands for so many
} push;

// The budget: most texels of a workgroup's 64 that gather by themselves. The others stay as the filter left them.
const uint MOST = 32u;

shared uint sparse_bits[2]; // a bit for each texel
shared uint chosen[MOST];   // texels, as thread numbers
shared vec3 partial[64];

ivec2 texel_of(uint thread) { return ivec2(gl_WorkGroupID.xy * 8u + uvec2(thread % 8u, thread / 8u)); }

void main() {
    uint thread = gl_LocalInvocationIndex;
    ivec3 texel = ivec3(texel_of(thread), vpl.layer);
    bool inside = all(lessThan(uvec2(texel.xy), set_extent(frame.size, push.set_step)));

    // Find the sparse texels, and choose among them.
    if (thread < 2u) sparse_bits[thread] = 0u;
    barrier();
    vec4 stored = inside ? imageLoad(set_buffers, texel) : vec4(0.0);
    bool sparse = stored.a < 0.0;
    if (sparse) atomicOr(sparse_bits[thread / 32u], 1u << (thread % 32u));
    barrier();
    uint count = uint(bitCount(sparse_bits[0]) + bitCount(sparse_bits[1]));
    if (count == 0u) return;
    uint most = min(count, MOST);
    uint below = (1u << (thread % 32u)) - 1u;
    uint rank = uint(bitCount(sparse_bits[thread / 32u] & below)) + (thread < 32u ? 0u : uint(bitCount(sparse_bits[0])));
    uint place = rank * most / count;
    if (sparse && (rank == 0u || (rank - 1u) * most / count < place)) chosen[place] = thread;
    barrier();

    // Gather: as many threads for each as there are.
    uint threads = 64u >> uint(findMSB(2u * most - 1u));
    uint mine = thread / threads;
    uint rays = 0u;
    vec3 sum = vec3(0.0);
    if (mine < most) {
        ivec2 pixel = representative(texel_of(chosen[mine]), push.set_step, vpl.representative, frame.size);
        // Neighbours begin at other VPLs.
        uint first = vpl.first_vpl + uint(pixel.x + 3 * pixel.y) % push.stride + thread % threads * push.stride;
        sum = gather(surface_at(pixel), first, vpl.first_vpl + vpl.vpl_count, threads * push.stride, rays);
    }
    partial[thread] = sum;
    count_rays(rays);
    barrier();

    // Write what was gathered; of those that were not chosen, only the sign of the depth goes.
    if (!sparse) return;
    if (chosen[place] == thread) {
        sum = vec3(0.0);
        for (uint i = 0u; i < threads; i++) sum += partial[place * threads + i];
        stored.rgb = min(sum * (vpl.irradiance_scale * float(push.stride)), MAX_STORED);
    }
    imageStore(set_buffers, texel, vec4(stored.rgb, -stored.a));
}
