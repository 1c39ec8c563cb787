// Irradiance of a surface from VPLs, one occlusion ray each:
//   E = sum phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term)
// Needs vpls.glsl, surface.glsl and tracer.glsl.

// Every `stride`-th VPL from `first` on, before `end`. Out: how many rays that took; what faces away needs none.
vec3 gather(Surface surface, uint first, uint end, uint stride, inout uint rays) {
    vec3 irradiance = vec3(0.0);
    vec3 origin = ray_origin(surface);
    for (uint i = first; i < end; i += stride) {
        GpuVpl light = vpls.data[i];
        vec3 brought = unshadowed_irradiance(light, surface.position, surface.shading);
        if (brought != vec3(0.0)) {
            rays++;
            if (!trace_occluded(origin, ray_goal(light) - origin, 0.0, 1.0)) irradiance += brought;
        }
    }
    return irradiance;
}
