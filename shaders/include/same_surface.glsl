// Whether pixels lie on one surface. Needs frame.glsl, gbuffer.glsl, packed_surface.glsl, `gbuffer_normal` and
// `packed_surfaces`.

const float MIN_NORMAL_COSINE = 0.9;

// What a pixel must agree with to count, in scaled depths: plane distance is depth * dot(slope, (x, y, 1)) - offset, since
// positions are linear in pixel coordinates and depth.
struct Surface {
    vec3 shading;
    vec3 slope;
    float offset;
    float tolerance;
};

Surface surface_at(ivec2 pixel, float depth) {
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    vec3 geometric = octahedral_decode(normals.zw);
    vec2 step = 2.0 / vec2(frame.size);
    vec3 slope = vec3(dot(geometric, frame.ray_x.xyz) * step.x, dot(geometric, frame.ray_y.xyz) * step.y, 0.0);
    slope.z = dot(geometric, frame.ray.xyz - frame.ray_x.xyz - frame.ray_y.xyz) + 0.5 * (slope.x + slope.y);
    float offset = depth * dot(slope, vec3(pixel, 1.0));
    return Surface(octahedral_decode(normals.xy), slope, offset, 0.25 * frame.position_cutoff * depth);
}

// Twin: `same_surfaces` in discontinuities.comp, for four centres at once.
bool same_surface(Surface surface, uint packed, ivec2 at) {
    vec3 normal = unpack_normal(packed);
    float distance = unpack_depth(packed) * dot(surface.slope, vec3(at, 1.0)) - surface.offset;
    bool alike = dot(normal, surface.shading) >= MIN_NORMAL_COSINE * length(normal);
    return is_surface(packed) && alike && abs(distance) <= surface.tolerance;
}

// Pixels outside of the picture, which one that is smaller than the window has, lie on no surface.
uint packed_at(ivec2 at) {
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(frame.size)));
    return inside ? texelFetch(packed_surfaces, texel_of(at)).r : 0u;
}
