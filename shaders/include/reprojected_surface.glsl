// Which texels of the last frame show a surface that was expected there, for all that follows surfaces from frame to frame. Needs
// frame.glsl, visible_surface.glsl and `VisibleSurface last_surface_at(ivec2 texel)`.

// A surface as the last frame should have seen it, and by how much the depth of a texel may differ.
struct ExpectedSurface {
    VisibleSurface surface;
    float tolerance;
};

// Normals on one surface differ by less than 45 degrees.
const float MIN_COSINE = 0.7071;
// How many pixels the depth may be off by along the slope of the surface.
const float SLOPE_PIXELS = 2.0;
// Slopes are no steeper than this cosine.
const float MIN_SLOPE_COSINE = 0.05;

// By how much depth may differ over a distance of 1: by `rounding`, and along the slope of a surface with this normal at `position`, of
// which a pixel covers `pixel`.
float depth_tolerance(float rounding, vec3 geometric, vec3 position, float pixel) {
    float cosine = max(abs(dot(geometric, normalize(position - frame.eye.xyz))), MIN_SLOPE_COSINE);
    return rounding + SLOPE_PIXELS * sqrt(1.0 - cosine * cosine) / cosine * pixel;
}

bool shows(ExpectedSurface expected, ivec2 texel) {
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(frame.size)))) return false;
    VisibleSurface there = last_surface_at(texel);
    return there.depth > 0.0 && there.instance == expected.surface.instance && dot(there.normal, expected.surface.normal) > MIN_COSINE
        && abs(there.depth - expected.surface.depth) < expected.tolerance;
}

// Which of the four texels around a place show the surface, a bit each by rows; where none does, which of the 3x3 around the nearest
// one do (the fallback of Schied et al. 2017).
vec2 showing_texels(ExpectedSurface expected, vec2 place) {
    vec2 masks = vec2(0.0);
    ivec2 corner = ivec2(floor(place));
    for (int tap = 0; tap < 4; tap++) {
        if (shows(expected, corner + ivec2(tap % 2, tap / 2))) masks.x += float(1 << tap);
    }
    ivec2 nearest = ivec2(floor(place + 0.5));
    for (int tap = 0; tap < 9; tap++) {
        if (masks.x == 0.0 && shows(expected, nearest + ivec2(tap % 3, tap / 3) - 1)) masks.y += float(1 << tap);
    }
    return masks;
}
