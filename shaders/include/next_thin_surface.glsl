// Thin surfaces that the eye sees one behind the other. Needs frame.glsl, tracer.glsl and hit.glsl.

// The next one along a ray that is one long along the view, so that t is view depth. `start`: just behind the last one.
bool next_thin_surface(vec3 direction, inout float start, float end, float spread, out TracerHit hit, out HitSurface met) {
    while (trace_thin_surface(frame.eye.xyz, direction, start, end, hit)) {
        start = just_behind(hit.t);
        met = surface_of(hit, direction, RayCone(0.0, spread * frame.footprint));
        if (met.front || (materials.data[hit.material].flags & SINGLE_SIDED) == 0u) return true;
    }
    return false;
}
