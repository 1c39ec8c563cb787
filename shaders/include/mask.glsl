// Alpha masks for raster passes: the same bits that rays test. Needs MASK_BINDING.

layout(set = 0, binding = MASK_BINDING, std430) readonly buffer MaskBlock { uvec4 table[]; } bvh_masks;
layout(set = 0, binding = MASK_BINDING + 1, std430) readonly buffer MaskBitBlock { uint words[]; } bvh_mask_bits;

// Whether the surface is there at uv (repeating, nearest texel). Twin: AlphaMask::opaque_at.
bool mask_opaque(uint mask, vec2 uv) {
    uvec4 entry = bvh_masks.table[mask - 1u]; // first word, width, height
    vec2 wrapped = uv - floor(uv);
    uint x = min(uint(wrapped.x * float(entry.y)), entry.y - 1u);
    uint y = min(uint(wrapped.y * float(entry.z)), entry.z - 1u);
    uint bit = y * entry.y + x;
    return (bvh_mask_bits.words[entry.x + bit / 32u] >> (bit % 32u) & 1u) == 1u;
}
