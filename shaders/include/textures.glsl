// The textures of all materials for shaders that cannot know beforehand which they need: every mip level of each, one after the
// other in one texel buffer, filtered here. Needs scene_set.glsl. Twin: `Texels` in
// src/gpu_scene/hit_buffers.rs.
#include "bilinear.glsl"
#include "footprint.glsl"
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

// A texture, filtered as by a sampler. `uvs`: both sets of coordinates.
vec4 sample_texture(TextureUse use, vec4 uvs, Gradients gradients) {
    TextureData image = textures.data[use.image - 1u];
    uvec2 size = uvec2(image.size & 0xffffu, image.size >> 16);
    uint words = image.format == FORMAT_HALF ? 2u : 1u;
    Taps taps = taps_of(use, change_of(use, gradients.right), change_of(use, gradients.down), vec2(size));

    // The levels, and how far it is from one to the next.
    uint modes = use.modes;
    if (taps.lod > 0.0) modes = (modes & MINIFIED_NEAREST) != 0u ? modes | NEAREST : modes & ~NEAREST;
    float lod = (modes & FIRST_LEVEL) != 0u ? 0.0 : clamp(taps.lod, 0.0, float(image.levels - 1u));
    if ((modes & NEAREST_LEVEL) != 0u) lod = ceil(lod - 0.5);
    uint first = image.first;
    for (uint level = 0u; level < uint(lod); level++) {
        first += words * size.x * size.y;
        size = max(size >> 1, uvec2(1u));
    }
    uint next = first + words * size.x * size.y;
    float part = fract(lod);

    vec2 start = coordinates_of(use, uvs) - taps.axis * (0.5 * taps.count);
    vec4 sum = vec4(0.0);
    for (float tap = 0.5; tap < taps.count; tap++) {
        vec2 place = wrapped(start + taps.axis * tap, use.modes);
        vec4 texel = bilinear(first, size, place, modes, image.format);
        if (part > 0.0) texel = mix(texel, bilinear(next, max(size >> 1, uvec2(1u)), place, modes, image.format), part);
        sum += texel;
    }
    return sum / taps.count;
}
