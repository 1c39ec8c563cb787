// VPLs, and what one sends to a point. Needs frame.glsl. Twins: GpuVpl in src/vpl/mod.rs, src/vpl/inspect.rs.

struct GpuVpl {
    vec3 position; // on the surface
    uint slot;
    vec3 normal; // of the side that shines
    uint bounce;
    vec3 flux; // phi, W
    uint _pad;
};

// Whether a VPL and a point p with normal n face each other; if not, `contribution` is zero.
bool faces(GpuVpl vpl, vec3 p, vec3 n) {
    vec3 d = vpl.position - p;
    return dot(n, d) > 0.0 && dot(vpl.normal, d) < 0.0;
}

// Irradiance at p with normal n, were nothing between.
vec3 contribution(GpuVpl vpl, vec3 p, vec3 n) {
    vec3 d = vpl.position - p;
    float squared = dot(d, d);
    if (squared <= 0.0) return vec3(0.0);
    float inverse = 1.0 / squared;
    float cosines = max(dot(n, d), 0.0) * max(-dot(vpl.normal, d), 0.0) * inverse;
    float c = frame.background.w;
    return vpl.flux / PI * cosines * (c > 0.0 ? min(inverse, c) : inverse);
}
