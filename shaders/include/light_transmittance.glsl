// Rays from surfaces to point, spot and directional lights. Needs lights.glsl and tracer.glsl.

// Share of a light that reaches the surface, 0 to 1; `to_light`: its direction from the surface.
vec3 light_transmittance(LightData light, Surface surface, vec3 to_light) {
    vec3 origin = ray_origin(surface);
    bool directional = light.kind == LIGHT_DIRECTIONAL;
    vec3 direction = directional ? to_light : light.position.xyz - origin;
    return trace_transmittance(origin, direction, 0.0, directional ? FAR : 1.0);
}
