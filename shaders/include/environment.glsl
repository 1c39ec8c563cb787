// Light from everywhere around the scene. Needs frame.glsl and scene_set.glsl.

// Radiance from a direction of any length, bilinear; it repeats to the sides; with the suns or without, which are lights, too (who sees
// what: src/scene/suns.rs). Twin: Environment::radiance in src/scene/environment.rs.
vec3 environment_radiance(vec3 direction, bool with_suns) {
    vec3 d = normalize(direction);
    float turn = frame.background.w;
    vec2 xz = vec2(cos(turn) * d.x - sin(turn) * d.z, sin(turn) * d.x + cos(turn) * d.z);
    // Towards a pole any azimuth will do.
    float azimuth = dot(xz, xz) > 0.0 ? atan(xz.x, -xz.y) : 0.0;
    vec2 uv = vec2(azimuth / (2.0 * PI) + 0.5, atan(length(xz), d.y) / PI);
    return frame.background.rgb * (with_suns ? textureLod(environment_map, uv, 0.0) : textureLod(sky_map, uv, 0.0)).rgb;
}
