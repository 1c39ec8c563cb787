// Images that the passes of SVGF share. Needs frame.glsl, gbuffer.glsl and visible_surface.glsl.
//
// Images of a signal, rgba16f. Light: rgb: the signal, without the albedo of the surface; a: its standard deviation, of luminance,
// which unlike the variance keeps its precision in half floats. Moments: r: mean luminance; g: standard deviation, frame by frame;
// b: how many frames they are of, the history length; a: mean luminance of the last few. Noisy: a: how wide a blur is of use, from 0, none, to
// 1, as wide as all levels of the filter reach.

layout(set = 0, binding = 1, rgba16ui) uniform readonly uimage2D surface;

VisibleSurface surface_of_pixel(ivec2 pixel) { return unpack_surface(imageLoad(surface, pixel)); }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(frame.size))); }

// How far off the surface of the centre another pixel's is: in footprints of a pixel from the plane through `centre`.
float plane_distance(vec3 centre, vec3 geometric, float depth, ivec2 pixel, float other_depth) {
    return abs(dot(geometric, position_at(pixel, other_depth) - centre)) / (depth * pixel_footprint());
}

float normal_weight(vec3 a, vec3 b, float exponent) { return pow(max(dot(a, b), 0.0), exponent); }

// The radius that a filter is of use in, pixels, given the share of the `widest` one; that 0: any is.
float filter_radius(float share, float widest) { return widest == 0.0 ? 1e6 : share * widest; }

// The weight of taps that are `ring` taps away, where the filter has a radius of `radius` taps.
float kernel_falloff(int ring, float radius) { return clamp(radius - float(ring) + 1.0, 0.0, 1.0); }

// Reinhard's curve (2002) and its inverse: bright samples count less in a mean, so fewer of them flicker, and the mean is darker.
vec3 compressed(vec3 light) { return light / (1.0 + luminance(light)); }

vec3 expanded(vec3 light) { return light / max(1.0 - luminance(light), 1.0 / 2048.0); }

#include "rounded.glsl"
