// The tracer that shaders use: trace_occluded and trace_closest, at the end. Whichever it is, it offers
//   bool tracer_find(vec3 origin, vec3 direction, float t_min, float t_max, bool any_hit, out TracerHit hit)
// which finds the closest hit or, with any_hit, any, on the segment t_min < t < t_max, t in units of the direction, which
// may have any length.
//
// Define TRACER_BINDING, the first of seven bindings in set TRACER_SET (0 by default), before including. The build
// compiles what includes this file twice, once with TRACER_HARDWARE.

#ifndef TRACER_GLSL
#define TRACER_GLSL

#include "wrap.glsl"

#ifndef TRACER_SET
#define TRACER_SET 0
#endif

#define TRACER_BUFFER(offset) \
    layout(set = TRACER_SET, binding = TRACER_BINDING + offset, std430) restrict readonly buffer
// What every ray reads, in texels of four words.
#define TRACER_TEXELS(offset) layout(set = TRACER_SET, binding = TRACER_BINDING + offset) uniform utextureBuffer

// Three words a triangle: corners with (id, masked, material).
TRACER_TEXELS(0) bvh_triangles;
// Two words a masked triangle: three pairs of texture coordinates, then the mask.
TRACER_BUFFER(1) bvh_triangle_uvs_block { uvec4 words[]; } bvh_triangle_uvs;
// (first word of bits, width, height, wrap modes).
TRACER_BUFFER(2) bvh_masks_block { uvec4 masks[]; } bvh_masks;
TRACER_BUFFER(3) bvh_mask_bits_block { uint words[]; } bvh_mask_bits;

const uint TRACER_NONE = 0xffffffffu;

// The closest surface along a ray.
struct TracerHit {
    float t;
    // Index into the scene's instances.
    uint instance;
    // Index into the mesh's triangles.
    uint triangle;
    uint material;
    // Index into bvh_triangles.
    uint place;
    // Weights of the triangle's second and third corner.
    vec2 barycentrics;
};

// Whether the alpha mask leaves the surface there; masked is 1 + index of the triangle's coordinates.
bool tracer_is_opaque(uint masked, vec2 barycentrics) {
    uvec4 first_two = bvh_triangle_uvs.words[(masked - 1u) * 2u];
    uvec4 third = bvh_triangle_uvs.words[(masked - 1u) * 2u + 1u];
    float first = 1.0 - barycentrics.x - barycentrics.y;
    precise vec2 uv = uintBitsToFloat(first_two.xy) * first + uintBitsToFloat(first_two.zw) * barycentrics.x
        + uintBitsToFloat(third.xy) * barycentrics.y;
    uvec4 mask = bvh_masks.masks[third.z];
    uvec2 texel = min(uvec2(wrapped(uv, mask.w) * vec2(mask.yz)), mask.yz - 1u);
    uint bit = texel.y * mask.y + texel.x;
    return ((bvh_mask_bits.words[mask.x + bit / 32u] >> (bit % 32u)) & 1u) == 1u;
}

#ifdef TRACER_HARDWARE
#include "tracer_hardware.glsl"
#else
#include "tracer_software.glsl"
#endif

// Whether anything lies on the segment.
bool trace_occluded(vec3 origin, vec3 direction, float t_min, float t_max) {
    TracerHit hit;
    return tracer_find(origin, direction, t_min, t_max, true, hit);
}

// The closest hit on the segment.
bool trace_closest(vec3 origin, vec3 direction, float t_min, float t_max, out TracerHit hit) {
    return tracer_find(origin, direction, t_min, t_max, false, hit);
}

#endif
