// VPLs, and what one sends to a point. Needs frame.glsl. Twins: GpuVpl in src/vpl/mod.rs, src/vpl/inspect.rs.

struct GpuVpl {
    vec3 position; // on the surface
    uint slot;
    vec3 normal; // of the side that shines
    uint bounce;
    vec3 flux; // phi, W
    uint _pad;
};

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

// The share of rays that are cast for what a VPL brings at most: all, unless that is far below what is typical; then
// few rays stand for many (Russian roulette, Arvo and Kirk 1990).
float ray_share(vec3 irradiance) {
    return min(luminance(irradiance) * frame.roulette, 1.0);
}

// A number in (0, 1) for each pixel and VPL, always the same (PCG of Jarzynski and Olano 2020).
float ray_chance(uvec2 pixel, uint slot) {
    uvec3 v = uvec3(pixel, slot) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    return (float(v.x >> 9u) + 0.5) / 8388608.0;
}
