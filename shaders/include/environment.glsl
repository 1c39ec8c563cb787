// Light from everywhere around the scene. Needs frame.glsl and scene_set.glsl.

// The place in the map, from the top left, of a unit vector as the map is turned.
vec2 map_place(vec3 direction) {
    // Towards a pole any azimuth will do.
    float azimuth = dot(direction.xz, direction.xz) > 0.0 ? atan(direction.x, -direction.z) : 0.0;
    return vec2(azimuth / (2.0 * PI) + 0.5, atan(length(direction.xz), direction.y) / PI);
}

// The unit vector of such a place.
vec3 map_direction(vec2 place) {
    float azimuth = (place.x - 0.5) * 2.0 * PI;
    float sine = sin(place.y * PI);
    return vec3(sine * sin(azimuth), cos(place.y * PI), -sine * cos(azimuth));
}

// The place in the map of a unit vector of the world.
vec2 environment_place(vec3 direction) {
    float turn = frame.background.w;
    vec2 xz = vec2(cos(turn) * direction.x - sin(turn) * direction.z, sin(turn) * direction.x + cos(turn) * direction.z);
    return map_place(vec3(xz.x, direction.y, xz.y));
}

// Radiance from a direction of any length, bilinear; it repeats to the sides; with the suns or without, which are lights, too (who sees
// what: src/scene/suns.rs). Twin: Environment::radiance in src/scene/environment.rs.
vec3 environment_radiance(vec3 direction, bool with_suns) {
    vec2 uv = environment_place(normalize(direction));
    return frame.background.rgb * (with_suns ? textureLod(environment_map, uv, 0.0) : textureLod(sky_map, uv, 0.0)).rgb;
}
