// The textures of all materials for shaders that cannot know beforehand which they need: every mip level of each, one after the
// other in one texel buffer, filtered here. Needs scene_set.glsl. Twin: `Texels` in
// src/gpu_scene/hit_buffers.rs.
#include "bilinear.glsl"
#include "wrap.glsl"

// A texel of the level whose first word is `first`.
vec4 texel_at(uint first, uint place, uint format) {
    if (format == FORMAT_HALF) {
        int word = int(first + 2u * place);
        return unpack_halves(uvec2(packUnorm4x8(texelFetch(texture_texels, word)),
            packUnorm4x8(texelFetch(texture_texels, word + 1))));
    }
    return decoded(texelFetch(texture_texels, int(first + place)), format);
}

// Interpolates four texels of a level; `place` is in [0, 1].
vec4 bilinear(uint first, uvec2 size, vec2 place, uint modes, uint format) {
    Footprint at = footprint_at(place, size, modes);
    return interpolated(vec4[4](texel_at(first, at.texels.x, format), texel_at(first, at.texels.y, format),
        texel_at(first, at.texels.z, format), texel_at(first, at.texels.w, format)), at.part);
}

// A texture, trilinear. `uvs`: both sets of coordinates; `lod`: the mip level of an image of one texel that repeats once, which is
// negative where the texture is magnified.
vec4 sample_texture(TextureUse use, vec4 uvs, float lod) {
    TextureData image = textures.data[use.image - 1u];
    uvec2 size = uvec2(image.size & 0xffffu, image.size >> 16);
    uint words = image.format == FORMAT_HALF ? 2u : 1u;
    vec2 place = wrapped(coordinates_of(use, uvs), use.modes);
    float scaling = abs(use.matrix.x * use.matrix.w - use.matrix.y * use.matrix.z);
    lod = clamp(lod + 0.5 * log2(float(size.x) * float(size.y) * scaling), 0.0, float(image.levels - 1u));
    uint first = image.first;
    for (uint level = 0u; level < uint(lod); level++) {
        first += words * size.x * size.y;
        size = max(size >> 1, uvec2(1u));
    }
    // As samplers do: the filter of magnification at level 0, else the linear one.
    uint modes = lod > 0.0 ? use.modes & ~NEAREST : use.modes;
    vec4 fine = bilinear(first, size, place, modes, image.format);
    float part = fract(lod);
    if (part == 0.0) return fine;
    first += words * size.x * size.y;
    return mix(fine, bilinear(first, max(size >> 1, uvec2(1u)), place, modes, image.format), part);
}
