// Bilinear filters over images that lie in buffers, in linear light. Twin: `Footprint` in src/scene/texture.rs.

#ifndef BILINEAR_GLSL
#define BILINEAR_GLSL

#include "wrap.glsl"

struct Footprint {
    uvec4 texels; // top left, top right, bottom left, bottom right, counted from the image's first
    vec2 part;    // from left to right, from top to bottom
};

// IEC 61966-2-1.
vec3 srgb_decoded(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// Formats of texels: bytes whose colour is sRGB-encoded or linear, and half floats in two words.
const uint FORMAT_SRGB = 0u;
const uint FORMAT_LINEAR = 1u;
const uint FORMAT_HALF = 2u;

vec4 decoded(vec4 texel, uint format) {
    return format == FORMAT_SRGB ? vec4(srgb_decoded(texel.rgb), texel.a) : texel;
}

// The texels `next - 1` and `next`, wrapped around, or those of the border.
uvec2 neighbours(uint next, uint size, bool repeats) {
    if (!repeats) return min(uvec2(max(next, 1u) - 1u, next), uvec2(size - 1u));
    uint first = next == 0u ? size - 1u : min(next - 1u, size - 1u);
    return uvec2(first, first + 1u == size ? 0u : first + 1u);
}

// The filter at a place in [0, 1].
Footprint footprint_at(vec2 place, uvec2 size, uint modes) {
    vec2 at = place * vec2(size);
    at = (modes & NEAREST) != 0u ? min(floor(at), vec2(size) - 1.0) + 1.0 : at + 0.5;
    uvec2 next = uvec2(at);
    uvec2 x = neighbours(next.x, size.x, (modes & 3u) == 0u);
    uvec2 y = neighbours(next.y, size.y, (modes & 12u) == 0u) * size.x;
    return Footprint(uvec4(y.x + x, y.y + x), at - vec2(next));
}

vec4 interpolated(vec4 texels[4], vec2 part) {
    return mix(mix(texels[0], texels[1], part.x), mix(texels[2], texels[3], part.x), part.y);
}

#endif
