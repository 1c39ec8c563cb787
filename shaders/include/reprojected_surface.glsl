// Which texels of the last frame show a surface that was expected there, for all that follows surfaces from frame to frame. Needs
// frame.glsl, visible_surface.glsl, `VisibleSurface last_surface_at(ivec2 texel)`, `uint last_instance_at(ivec2 texel)`, and
// REPROJECTION_TESTS, the number of a specialisation constant.

// Tests that a texel must pass, a bit each; studies leave one out (Granja 2021, figure 3.9).
layout(constant_id = REPROJECTION_TESTS) const uint TESTS = 7u;
const uint INSTANCE_TEST = 1u, NORMAL_TEST = 2u, DEPTH_TEST = 4u;

// A surface as the last frame should have seen it, and by how much the depth of a texel may differ.
struct ExpectedSurface {
    VisibleSurface surface;
    uint instance; // plus one, as in the G-buffer
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
    uint failed = (last_instance_at(texel) == expected.instance ? 0u : INSTANCE_TEST)
        | (dot(there.normal, expected.surface.normal) > MIN_COSINE ? 0u : NORMAL_TEST)
        | (abs(there.depth - expected.surface.depth) < expected.tolerance ? 0u : DEPTH_TEST);
    return there.depth > 0.0 && (failed & TESTS) == 0u;
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
