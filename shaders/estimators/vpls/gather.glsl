// What a surface receives of a VPL. Needs vpls.glsl, surface.glsl and tracer.glsl.

// Irradiance of a surface, unoccluded.
vec3 unshadowed_irradiance(GpuVpl light, Surface surface) {
    if (light.at_infinity != 0u) return light.flux * received(surface, light.position);
    vec3 d = light.position - surface.position;
    float squared = dot(d, d);
    if (squared <= 0.0) return vec3(0.0);
    float inverse = 1.0 / squared;
    vec3 direction = d * inversesqrt(squared);
    float cosine = received(surface, direction);
    if (cosine <= 0.0) return vec3(0.0);
    float bound = bound_of(light);
    return light.flux * emission_density(light, -direction) * (cosine * (bound > 0.0 ? min(inverse, bound) : inverse));
}

// Irradiance of a surface from one VPL, by a ray to it:
//   E = phi e(-w) <n_x,w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term; e: emission_density; <n_x,w>+: received)
// and from one at infinity E = E_w <n_x,w>+ V, where V is what the thin surfaces between let pass, 0 behind anything opaque.
// Counts the ray; a VPL that faces away needs none.
vec3 gather(Surface surface, GpuVpl light, inout uint rays) {
    vec3 brought = unshadowed_irradiance(light, surface);
    if (brought == vec3(0.0)) return brought;
    rays++;
    vec3 origin = ray_origin(surface);
    vec4 ray = ray_to(light, origin);
    return brought * trace_transmittance(origin, ray.xyz, 0.0, ray.w);
}
