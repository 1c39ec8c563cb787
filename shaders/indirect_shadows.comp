#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One occlusion ray for each pixel and VPL of its class (interleaved sampling, Wald et al. 2002). Out: irradiance of the
// pixel from those that it sees,
//   E = sum phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term)
#include "frame.glsl"
#include "gbuffer.glsl"
#include "vpls.glsl"
#include "class_pixel.glsl"
#include "interleave.glsl"
#define VPL_SET_BINDING 3
#include "vpl_set.glsl"
#define TRACER_BINDING 8
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_position;
layout(set = 0, binding = 2) uniform texture2D gbuffer_normal;
// rgb: irradiance, as bits of floats; a: surface, see class_pixel.glsl.
layout(set = 0, binding = 5, rgba32ui) uniform uimage2D class_irradiance;
layout(set = 0, binding = 6, std430) buffer CounterBlock { uvec2 rays[]; } counters;

// Twins: COUNTERS and COUNTER_STRIDE in src/passes/indirect_shadows.rs.
const uint COUNTERS = 4u;
const uint COUNTER_STRIDE = 8u;

layout(push_constant) uniform Push { uint first_texel; uint first_word; uint word_count; } push;

void main() {
    // All pixels of a workgroup have the same class, and so the same VPLs, which keeps rays coherent. The
    // groups of the n^2 classes of one block of the picture follow one another, which keeps the block in
    // the caches. Twin: `class_grid` in src/passes/indirect_shadows.rs.
    uint pixel_class = gl_WorkGroupID.x % (INTERLEAVE * INTERLEAVE);
    uvec2 block = uvec2(gl_WorkGroupID.x / (INTERLEAVE * INTERLEAVE), gl_WorkGroupID.y);
    uvec2 place = uvec2(pixel_class % INTERLEAVE, pixel_class / INTERLEAVE);
    uvec2 pixel = (block * 8u + gl_LocalInvocationID.xy) * INTERLEAVE + place;
    bool inside = all(lessThan(pixel, frame.size));
    vec4 position = inside ? texelFetch(gbuffer_position, ivec2(pixel), 0) : vec4(0.0);
    vec4 normals = inside ? texelFetch(gbuffer_normal, ivec2(pixel), 0) : vec4(0.0);
    vec3 irradiance = vec3(0.0);
    uint rays = 0u;
    if (position.w > 0.0) {
        vec3 shading = octahedral_decode(normals.xy);
        vec3 geometric = octahedral_decode(normals.zw);
        vec3 start = position.xyz + geometric * ray_offset(position.xyz);
        VplClass of_pixel = vpl_class(push.first_texel, pixel_class);
        for (uint word = 0u; word < push.word_count; word++) {
            uint begin = of_pixel.first + (push.first_word + word) * 32u;
            uint end = min(begin + 32u, of_pixel.end);
            // What faces away needs no ray, and what brings little gets one seldom.
            uint chosen = 0u;
            for (uint i = begin; i < end; i++) {
                GpuVpl vpl = vpl_at(push.first_texel, i);
                float share = ray_share(contribution(vpl, position.xyz, shading));
                if (share > ray_chance(pixel, vpl.slot)) chosen |= 1u << (i - begin);
            }
            rays += uint(bitCount(chosen));
            for (; chosen != 0u; chosen &= chosen - 1u) {
                GpuVpl vpl = vpl_at(push.first_texel, begin + uint(findLSB(chosen)));
                vec3 to_vpl = vpl.position + vpl.normal * ray_offset(vpl.position) - start;
                if (trace_occluded(start, to_vpl, 0.0, 1.0)) continue;
                vec3 full = contribution(vpl, position.xyz, shading);
                irradiance += full / max(ray_share(full), 1e-8);
            }
        }
        // Later chunks of the set's VPLs add to the earlier ones.
        if (push.first_word > 0u) irradiance += uintBitsToFloat(imageLoad(class_irradiance, ivec2(pixel)).rgb);
    }
    if (inside) {
        uint surface = pack_surface(position.w, normals.xy);
        imageStore(class_irradiance, ivec2(pixel), uvec4(floatBitsToUint(irradiance), surface));
    }
    // 64-bit sums, low word first, apart from one another so that workgroups seldom meet at one.
    uint counter = gl_WorkGroupID.x % COUNTERS * COUNTER_STRIDE;
    if (rays > 0u && atomicAdd(counters.rays[counter].x, rays) > 0xffffffffu - rays) atomicAdd(counters.rays[counter].y, 1u);
}
