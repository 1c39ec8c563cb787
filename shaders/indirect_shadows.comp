#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// One occlusion ray for each pixel and VPL of its class (interleaved sampling, Wald et al. 2002). Out: irradiance of the
// pixel from those that it sees,
//   E = sum phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term)
#include "frame.glsl"
#include "gbuffer.glsl"
#include "vpls.glsl"
#include "packed_irradiance.glsl"
#include "interleave.glsl"
#define VPL_SET_BINDING 3
#include "vpl_set.glsl"
#define TRACER_BINDING 7
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, std430) buffer IrradianceBlock { uvec2 words[]; } class_irradiance;
layout(set = 0, binding = 6, std430) buffer CounterBlock { uvec2 rays[]; } counters;

// Twins: COUNTERS and COUNTER_STRIDE in src/passes/indirect_shadows.rs.
const uint COUNTERS = 4u;
const uint COUNTER_STRIDE = 8u;

layout(push_constant) uniform Push {
    uint first_texel; // of the VPLs
    uint word;        // which 32 VPLs of each class
    uint first_row;   // of blocks
    uint first_pixel; // in class_irradiance: as much of it as a storage buffer may show
} push;

// Pixels of a thread, 1 to 4: those of its class that follow one another down the picture.
layout(constant_id = 1) const uint PIXELS = 1u;

struct Surface {
    vec3 position;
    vec3 shading;
    vec3 geometric;
    bool exists;
};

Surface surface_at(uvec2 pixel) {
    bool inside = all(lessThan(pixel, frame.size));
    float depth = inside ? imageLoad(gbuffer_depth, ivec2(pixel)).r : 0.0;
    vec4 normals = imageLoad(gbuffer_normal, ivec2(min(pixel, frame.size - 1u)));
    vec3 position = position_at(ivec2(pixel), depth);
    return Surface(position, octahedral_decode(normals.xy), octahedral_decode(normals.zw), depth > 0.0);
}

// What the VPL brings to the surface if it sees it. share: of such rays that are cast, each of which stands for the others.
vec3 weighted_contribution(GpuVpl vpl, Surface surface, out float share) {
    vec3 full = contribution(vpl, surface.position, surface.shading);
    share = ray_share(full);
    return share > 0.0 ? full / share : vec3(0.0);
}

void main() {
    // All pixels of a workgroup have the same class, and so the same VPLs, which keeps rays coherent. The
    // groups of the n^2 classes of one block of the picture follow one another, which keeps the block in
    // the caches. Twin: `threads` in src/passes/indirect_shadows.rs.
    uint pixel_class = gl_WorkGroupID.x % (INTERLEAVE * INTERLEAVE);
    uvec2 block = uvec2(gl_WorkGroupID.x / (INTERLEAVE * INTERLEAVE), gl_WorkGroupID.y + push.first_row);
    uvec2 place = uvec2(pixel_class % INTERLEAVE, pixel_class / INTERLEAVE);
    uvec2 first = (block * 8u + gl_LocalInvocationID.xy) * uvec2(1u, PIXELS) * INTERLEAVE + place;
    uvec2 next = uvec2(0u, INTERLEAVE);

    VplClass of_pixels = vpl_class(push.first_texel, pixel_class);
    uint begin = of_pixels.first + push.word * 32u;
    uint end = min(begin + 32u, of_pixels.end);
    // What faces away needs no ray, and what brings little gets one seldom.
    uvec4 chosen = uvec4(0u);
    Surface surfaces[4];
    [[unroll]] for (uint i = 0u; i < PIXELS; i++) surfaces[i] = surface_at(first + i * next);
    if (begin < end) {
        // Loops that ask at their end whether to go on: see tracer_find.
        uint v = begin;
        do {
            GpuVpl vpl = vpl_at(push.first_texel, v);
            [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
                float share;
                weighted_contribution(vpl, surfaces[i], share);
                bool casts = surfaces[i].exists && share > ray_chance(first + i * next, vpl.slot);
                chosen[i] |= casts ? 1u << (v - begin) : 0u;
            }
        } while (++v < end);
    }
    ivec4 counts = bitCount(chosen);
    uint rays = uint(counts.x + counts.y + counts.z + counts.w);

    mat4x3 irradiance = mat4x3(0.0);
    if (chosen != uvec4(0u)) {
        do {
            uint i = PIXELS == 1u || chosen.x != 0u ? 0u : chosen.y != 0u ? 1u : chosen.z != 0u ? 2u : 3u;
            Surface surface = surfaces[0];
            if (PIXELS > 1u && i == 1u) surface = surfaces[1];
            if (PIXELS > 2u && i == 2u) surface = surfaces[2];
            if (PIXELS > 3u && i == 3u) surface = surfaces[3];
            GpuVpl vpl = vpl_at(push.first_texel, begin + uint(findLSB(chosen[i])));
            chosen[i] &= chosen[i] - 1u;
            vec3 start = surface.position + surface.geometric * ray_offset(surface.position);
            vec3 to_vpl = vpl.position + vpl.normal * ray_offset(vpl.position) - start;
            if (!trace_occluded(start, to_vpl, 0.0, 1.0)) {
                float share;
                irradiance[i] += weighted_contribution(vpl, surface, share);
            }
        } while (chosen != uvec4(0u));
    }

    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        uvec2 pixel = first + i * next;
        if (any(greaterThanEqual(pixel, frame.size))) continue;
        int at = texel_of(ivec2(pixel)) - int(push.first_pixel);
        // Later words of the set's VPLs add to the earlier ones.
        vec3 sum = irradiance[i];
        if (push.word > 0u) sum += unpack_irradiance(class_irradiance.words[at]);
        class_irradiance.words[at] = pack_irradiance(sum);
    }
    // 64-bit sums, low word first, apart from one another so that workgroups seldom meet at one.
    uint counter = gl_WorkGroupID.x % COUNTERS * COUNTER_STRIDE;
    if (rays > 0u && atomicAdd(counters.rays[counter].x, rays) > 0xffffffffu - rays) atomicAdd(counters.rays[counter].y, 1u);
}
