// Irradiance of a surface from one VPL, by an occlusion ray:
//   E = phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term)
// Needs vpls.glsl, surface.glsl and tracer.glsl. Counts the ray; a VPL that faces away needs none.
vec3 gather(Surface surface, GpuVpl light, inout uint rays) {
    vec3 brought = unshadowed_irradiance(light, surface.position, surface.shading);
    if (brought == vec3(0.0)) return brought;
    rays++;
    vec3 origin = ray_origin(surface);
    return trace_occluded(origin, ray_goal(light) - origin, 0.0, 1.0) ? vec3(0.0) : brought;
}
