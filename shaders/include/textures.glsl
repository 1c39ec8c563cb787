// The textures of all materials for shaders that cannot know beforehand which they need: every mip level of each, one after the
// other in one texel buffer, filtered here. Needs scene_set.glsl. Twin: `Texels` in
// src/gpu_scene/hit_buffers.rs.
#include "bilinear.glsl"
#include "wrap.glsl"

vec4 texel_at(uint place, bool linear) { return decoded(texelFetch(texture_texels, int(place)), linear); }

// Interpolates four texels of a level; `place` is in [0, 1].
vec4 bilinear(uint first, uvec2 size, vec2 place, uint modes, bool linear) {
    Footprint at = footprint_at(place, size, modes);
    uvec4 texels = at.texels + first;
    return interpolated(vec4[4](texel_at(texels.x, linear), texel_at(texels.y, linear), texel_at(texels.z, linear),
        texel_at(texels.w, linear)), at.part);
}

// A texture, trilinear. `uvs`: both sets of coordinates; `lod`: the mip level of an image of one texel that repeats once, which is
// negative where the texture is magnified.
vec4 sample_texture(TextureUse use, vec4 uvs, float lod) {
    TextureData image = textures.data[use.image - 1u];
    uvec2 size = uvec2(image.size & 0xffffu, image.size >> 16);
    bool linear = image.linear == 1u;
    vec2 place = wrapped(coordinates_of(use, uvs), use.modes);
    float scaling = abs(use.matrix.x * use.matrix.w - use.matrix.y * use.matrix.z);
    lod = clamp(lod + 0.5 * log2(float(size.x) * float(size.y) * scaling), 0.0, float(image.levels - 1u));
    uint first = image.first;
    for (uint level = 0u; level < uint(lod); level++) {
        first += size.x * size.y;
        size = max(size >> 1, uvec2(1u));
    }
    vec4 fine = bilinear(first, size, place, use.modes, linear);
    float part = fract(lod);
    if (part == 0.0) return fine;
    first += size.x * size.y;
    return mix(fine, bilinear(first, max(size >> 1, uvec2(1u)), place, use.modes, linear), part);
}
