// Texels that a pixel or a ray's cone averages: the same for raster and rays. The shorter axis of the footprint chooses the mip level,
// and texels are averaged along the longer one (anisotropic filtering). Samplers could, too, but each driver's blur is another, and rays
// have none. Needs scene_set.glsl.

#ifndef FOOTPRINT_GLSL
#define FOOTPRINT_GLSL

#include "wrap.glsl"

// How both sets of texture coordinates change along the two axes of what is seen: a pixel, or a ray's cone.
struct Gradients {
    vec4 right;
    vec4 down;
};

// How the coordinates on the image change where both sets do by `change`.
vec2 change_of(TextureUse use, vec4 change) { return coordinates_of(use, change) - use.offset; }

// Reads at coordinates + axis * (i + 0.5 - count / 2), of the level `lod`, negative where the image is magnified.
struct Taps {
    vec2 axis;
    float count;
    float lod;
};

const float MOST_TAPS = 16.0;

// `right`, `down`: how the coordinates on the image change along the axes; `size`: of the image, texels. Of texels that are not
// interpolated one is read: those of blocks would be read beyond the block's part of the image.
Taps taps_of(TextureUse use, vec2 right, vec2 down, vec2 size) {
    float most = length(right * size);
    float least = length(down * size);
    vec2 axis = right;
    if (most < least) {
        axis = down;
        float other = most;
        most = least;
        least = other;
    }
    if ((use.modes & MINIFIED_NEAREST) != 0u) return Taps(vec2(0.0), 1.0, log2(max(least, 1e-6)));
    float count = clamp(round(most / max(least, 1e-6)), 1.0, min(MOST_TAPS, max(ceil(most), 1.0)));
    return Taps(axis / count, count, log2(max(most / count, 1e-6)));
}

#endif
