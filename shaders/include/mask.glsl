// Alpha masks, the same for raster and rays. Needs scene_set.glsl. Twin: src/scene/alpha_mask.rs.

#ifndef MASK_GLSL
#define MASK_GLSL

#include "bilinear.glsl"
#include "wrap.glsl"

// In the modes of a mask: its texels have 16 bits, otherwise 8.
const uint WIDE_MASK = 128u;

float mask_texel(uvec4 mask, uint texel) {
    if ((mask.z & WIDE_MASK) != 0u) {
        uint word = bvh_mask_texels.words[mask.x + texel / 2u];
        return float(word >> (texel % 2u * 16u) & 0xffffu) / 65535.0;
    }
    uint word = bvh_mask_texels.words[mask.x + texel / 4u];
    return float(word >> (texel % 4u * 8u) & 0xffu) / 255.0;
}

// Whether the surface is there at uv, where the alpha of its vertices is `alpha`.
bool mask_opaque(uint index, vec2 uv, float alpha) {
    uvec4 mask = bvh_masks.masks[index];
    Footprint at = footprint_at(wrapped(uv, mask.z), uvec2(mask.y & 0xffffu, mask.y >> 16), mask.z);
    vec2 left = vec2(mask_texel(mask, at.texels.x), mask_texel(mask, at.texels.z));
    vec2 right = vec2(mask_texel(mask, at.texels.y), mask_texel(mask, at.texels.w));
    // Equal texels give their value, bit for bit.
    precise vec2 rows = left + (right - left) * at.part.x;
    precise float texel = rows.x + (rows.y - rows.x) * at.part.y;
    return texel * alpha >= uintBitsToFloat(mask.w);
}

#endif
