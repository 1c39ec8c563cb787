// How far a surface leaves its plane. Needs surface.glsl, gbuffer.glsl, same_surface.glsl and both images of the G-buffer.

// Most change of the geometric normal from a pixel to those beside it on its surface, over their distance, 1/m.
float slope_at(ivec2 pixel, Surface surface) {
    float slope = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 beside = pixel + (i < 2 ? ivec2(2 * i - 1, 0) : ivec2(0, 2 * i - 5));
        if (any(lessThan(beside, ivec2(0))) || any(greaterThanEqual(beside, ivec2(frame.size)))) continue;
        Surface other = surface_at(beside);
        vec3 d = other.position - surface.position;
        float change = length(cross(surface.geometric, other.geometric));
        bool same = other.depth > 0.0 && dot(surface.geometric, other.geometric) >= MIN_NORMAL_COSINE
            && same_surface(d, surface.geometric, other.geometric, surface.depth);
        if (same) slope = max(slope, change * inversesqrt(max(dot(d, d), 1e-20)));
    }
    return slope;
}
