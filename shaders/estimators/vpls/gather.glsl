// Irradiance of a surface from one VPL, by a ray to it:
//   E = phi e(-w) <n_x,w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term; e: emission_density)
// and from one at infinity E = E_w <n_x,w>+ V, where V is what the thin surfaces between let pass, 0 behind anything opaque.
// Needs vpls.glsl, surface.glsl and tracer.glsl. Counts the ray; a VPL that faces away needs none.
vec3 gather(Surface surface, GpuVpl light, inout uint rays) {
    vec3 brought = unshadowed_irradiance(light, surface.position, surface.shading);
    if (brought == vec3(0.0)) return brought;
    rays++;
    vec3 origin = ray_origin(surface);
    vec4 ray = ray_to(light, origin);
    return brought * trace_transmittance(origin, ray.xyz, 0.0, ray.w);
}
