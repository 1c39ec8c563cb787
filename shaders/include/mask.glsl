// Alpha masks for raster passes: the same bits that rays test. Needs scene_set.glsl.
#include "wrap.glsl"

// Whether the surface is there at uv (nearest texel). Twin: AlphaMask::opaque_at.
bool mask_opaque(uint mask, vec2 uv) {
    uvec4 entry = bvh_masks.masks[mask - 1u]; // first word, width, height, wrap modes
    vec2 place = wrapped(uv, entry.w);
    uint x = min(uint(place.x * float(entry.y)), entry.y - 1u);
    uint y = min(uint(place.y * float(entry.z)), entry.z - 1u);
    uint bit = y * entry.y + x;
    return (bvh_mask_bits.words[entry.x + bit / 32u] >> (bit % 32u) & 1u) == 1u;
}
