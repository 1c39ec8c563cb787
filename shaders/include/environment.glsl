// Light from everywhere around the scene. Needs frame.glsl and scene_set.glsl.

// The place in the map of a unit vector, from the top left.
vec2 environment_place(vec3 direction) {
    float turn = frame.background.w;
    vec2 xz = vec2(cos(turn) * direction.x - sin(turn) * direction.z, sin(turn) * direction.x + cos(turn) * direction.z);
    // Towards a pole any azimuth will do.
    float azimuth = dot(xz, xz) > 0.0 ? atan(xz.x, -xz.y) : 0.0;
    return vec2(azimuth / (2.0 * PI) + 0.5, atan(length(xz), direction.y) / PI);
}

// Radiance from a direction of any length, bilinear; it repeats to the sides; with the suns or without, which are lights, too (who sees
// what: src/scene/suns.rs). Twin: Environment::radiance in src/scene/environment.rs.
vec3 environment_radiance(vec3 direction, bool with_suns) {
    vec2 uv = environment_place(normalize(direction));
    return frame.background.rgb * (with_suns ? textureLod(environment_map, uv, 0.0) : textureLod(sky_map, uv, 0.0)).rgb;
}
