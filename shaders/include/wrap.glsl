// Where an image is read beyond its borders. Twin: src/scene/texture_use.rs.

#ifndef WRAP_GLSL
#define WRAP_GLSL

// Wrap modes of an image, u in bits 0 and 1, v in bits 2 and 3.
const uint WRAP_MIRROR = 1u;
const uint WRAP_CLAMP = 2u;
// Beside them: where the image is magnified, the nearest texel shows.
const uint NEAREST = 64u;
// Where it is minified: the nearest texel of a level, the nearest level, the first level alone.
const uint MINIFIED_NEAREST = 128u;
const uint NEAREST_LEVEL = 256u;
const uint FIRST_LEVEL = 512u;

float wrapped(float x, uint mode) {
    if (mode == WRAP_CLAMP) return clamp(x, 0.0, 1.0);
    if (mode == WRAP_MIRROR) return 1.0 - abs(2.0 * fract(0.5 * x) - 1.0);
    return x - floor(x);
}

// The place in [0, 1] that is read at `uv`.
vec2 wrapped(vec2 uv, uint modes) { return vec2(wrapped(uv.x, modes & 3u), wrapped(uv.y, modes >> 2 & 3u)); }

#endif
