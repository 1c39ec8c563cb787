// What the passes of SVGF share. Needs frame.glsl, gbuffer.glsl and visible_surface.glsl.
//
// Images of a signal, rgba16f. Light: rgb: the signal, without the albedo of the surface; a: its standard deviation, of luminance,
// which unlike the variance keeps its precision in half floats. Moments: r: mean luminance; g: standard deviation; b: how many
// frames they are of, the history length.

layout(set = 0, binding = 1, rgba16ui) uniform readonly uimage2D surface;

VisibleSurface surface_of_pixel(ivec2 pixel) { return unpack_surface(imageLoad(surface, pixel)); }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(frame.size))); }

// How far off the surface of the centre another pixel's is: in footprints of a pixel from the plane through `centre`.
float plane_distance(vec3 centre, vec3 geometric, float depth, ivec2 pixel, float other_depth) {
    float footprint = depth * length(frame.ray_y.xyz) * 2.0 / float(frame.size.y);
    return abs(dot(geometric, position_at(pixel, other_depth) - centre)) / footprint;
}

float normal_weight(vec3 a, vec3 b, float exponent) { return pow(max(dot(a, b), 0.0), exponent); }

#include "rounded.glsl"
