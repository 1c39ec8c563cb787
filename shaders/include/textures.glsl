// The textures of all materials for shaders that cannot know beforehand which they need: every mip level of each, one after the
// other in one texel buffer, filtered here. Needs scene.glsl. Define TEXTURES_BINDING before including: it and the next are
// taken. Twin: `Texels` in src/passes/hit_buffers.rs.
#include "wrap.glsl"

// An image in the buffer.
struct TextureData {
    uint first;  // texel of the first level
    uint size;   // of that, width in the lower 16 bits, height above
    uint levels;
    uint linear; // 1: its colour is; otherwise sRGB-encoded
};

layout(set = 0, binding = TEXTURES_BINDING, std430) readonly buffer TextureBlock { TextureData data[]; } textures;
layout(set = 0, binding = TEXTURES_BINDING + 1) uniform textureBuffer texture_texels;

// IEC 61966-2-1.
vec3 srgb_decoded(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

vec4 texel_at(uint place, bool linear) {
    vec4 texel = texelFetch(texture_texels, int(place));
    return linear ? texel : vec4(srgb_decoded(texel.rgb), texel.a);
}

// The texels `next - 1` and `next`, wrapped around, or those of the border.
uvec2 neighbours(uint next, uint size, bool repeats) {
    if (!repeats) return min(uvec2(max(next, 1u) - 1u, next), uvec2(size - 1u));
    uint first = next == 0u ? size - 1u : min(next - 1u, size - 1u);
    return uvec2(first, first + 1u == size ? 0u : first + 1u);
}

// Interpolates four texels of a level bilinearly, in linear light; `place` is in [0, 1].
vec4 bilinear(uint first, uvec2 size, vec2 place, uint modes, bool linear) {
    vec2 at = place * vec2(size) + 0.5;
    uvec2 next = uvec2(at);
    vec2 part = at - vec2(next);
    uvec2 x = neighbours(next.x, size.x, (modes & 3u) == 0u);
    uvec2 y = neighbours(next.y, size.y, (modes & 12u) == 0u) * size.x + first;
    vec4 top = mix(texel_at(y.x + x.x, linear), texel_at(y.x + x.y, linear), part.x);
    vec4 bottom = mix(texel_at(y.y + x.x, linear), texel_at(y.y + x.y, linear), part.x);
    return mix(top, bottom, part.y);
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
