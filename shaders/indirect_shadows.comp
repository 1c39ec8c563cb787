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
#define WORK_BINDING 14
#include "work.glsl"

layout(local_size_x = GROUP) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, std430) buffer IrradianceBlock { uvec2 words[]; } class_irradiance;
layout(set = 0, binding = 6, std430) buffer CounterBlock { uvec2 rays[]; } counters;

// Twins: COUNTERS and COUNTER_STRIDE in src/passes/indirect_shadows.rs.
const uint COUNTERS = 4u;
const uint COUNTER_STRIDE = 8u;

layout(push_constant) uniform Push {
    uint first_texel; // of the VPLs
    uint first_vpl;   // of each class
    uint vpls;        // from there on
    uint first_row;   // of blocks
    uint stride;      // from one run of blocks to the next; no factor in common with their number
    uint first_pixel; // in class_irradiance: as much of it as a storage buffer may show
    uint columns;     // of blocks
    uint rows;
    Work work;        // a group is the 8x8 threads of one class of one block
} push;

// Blocks, side by side. Twin: `RUN` in src/passes/indirect_shadows.rs.
const uint RUN = 4u;

// Pixels of a thread: those of its class that follow one another down the picture.
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

// Casts the rays of a thread of a group; tells how many.
uint cast_for(uint group, uvec2 thread) {
    // All pixels of a group have the same class, and so the same VPLs, which keeps rays coherent. The groups of the n^2
    // classes of one block of the picture follow one another, which keeps the block in the caches. After a run of blocks the
    // next run lies `stride` farther on. Twin: `record` in src/passes/indirect_shadows.rs.
    uint pixel_class = group % (INTERLEAVE * INTERLEAVE);
    uint turn = group / (INTERLEAVE * INTERLEAVE);
    uint met = turn / RUN * push.stride % (push.columns * push.rows / RUN) * RUN + turn % RUN;
    uvec2 block = uvec2(met % push.columns, met / push.columns + push.first_row);
    uvec2 place = uvec2(pixel_class % INTERLEAVE, pixel_class / INTERLEAVE);
    uvec2 first = (block * 8u + thread) * uvec2(1u, PIXELS) * INTERLEAVE + place;
    uvec2 next = uvec2(0u, INTERLEAVE);

    VplClass of_pixels = vpl_class(push.first_texel, pixel_class);
    uint begin = of_pixels.first + push.first_vpl;
    uint end = min(begin + push.vpls, of_pixels.end);
    Surface surfaces[PIXELS];
    vec3 irradiance[PIXELS];
    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        surfaces[i] = surface_at(first + i * next);
        irradiance[i] = vec3(0.0);
    }
    uint rays = 0u;
    if (begin < end) {
        // One VPL after the other: rays that are on their way together lead to one place. Loops ask at their end whether to
        // go on: see tracer_find.
        uint v = begin;
        do {
            GpuVpl vpl = vpl_at(push.first_texel, v);
            // What faces away needs no ray, and what brings little gets one seldom.
            vec3 brought[PIXELS];
            uint waiting = 0u; // pixels, as bits
            [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
                float share;
                brought[i] = weighted_contribution(vpl, surfaces[i], share);
                bool casts = surfaces[i].exists && share > ray_chance(first + i * next, vpl.slot);
                waiting |= casts ? 1u << i : 0u;
            }
            rays += uint(bitCount(waiting));
            uint lit = waiting;
            if (waiting != 0u) {
                vec3 goal = vpl.position + vpl.normal * ray_offset(vpl.position);
                do {
                    uint i = uint(findLSB(waiting));
                    waiting &= waiting - 1u;
                    Surface surface = surfaces[0];
                    [[unroll]] for (uint other = 1u; other < PIXELS; other++) {
                        if (i == other) surface = surfaces[other];
                    }
                    vec3 start = surface.position + surface.geometric * ray_offset(surface.position);
                    lit ^= trace_occluded(start, goal - start, 0.0, 1.0) ? 1u << i : 0u;
                } while (waiting != 0u);
            }
            [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
                irradiance[i] += (lit & (1u << i)) != 0u ? brought[i] : vec3(0.0);
            }
        } while (++v < end);
    }

    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        uvec2 pixel = first + i * next;
        if (any(greaterThanEqual(pixel, frame.size))) continue;
        int at = texel_of(ivec2(pixel)) - int(push.first_pixel);
        // Later VPLs add to the earlier ones.
        vec3 sum = irradiance[i];
        if (push.first_vpl > 0u) sum += unpack_irradiance(class_irradiance.words[at]);
        class_irradiance.words[at] = pack_irradiance(sum);
    }
    return rays;
}

void main() {
    Share share = take_share(push.work);
    if (share.first >= share.end) return;
    uint rays = 0u;
    uint group = share.first;
    do {
        rays += cast_for(group, uvec2(share.thread % 8u, share.thread / 8u));
    } while (++group < share.end);
    // 64-bit sums, low word first, apart from one another so that workgroups seldom meet at one.
    uint counter = gl_WorkGroupID.x % COUNTERS * COUNTER_STRIDE;
    if (rays > 0u && atomicAdd(counters.rays[counter].x, rays) > 0xffffffffu - rays) atomicAdd(counters.rays[counter].y, 1u);
}
