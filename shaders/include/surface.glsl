// The surface that a pixel sees. Needs frame.glsl, gbuffer.glsl, `gbuffer_depth` and `gbuffer_normal`.

struct Surface {
    vec3 position;
    vec3 shading;   // unit normals on the side that is seen
    vec3 geometric;
    float depth;    // along the view; 0 where no surface is
    float lift;     // share of the way to the eye by which rays begin before it
};

// Distance from a visible surface towards the eye at which its rays begin, pixels. Rasterizers snap the vertices of triangles (mostly to
// 1/256 of a pixel), so the point at a pixel may lie beyond the edge of its triangle, behind an adjacent wall; between it and the eye nothing
// lies. The more grazing the view of that wall, the farther behind it the point lies: this serves up to 85 degrees.
const float LIFT = 1.0 / 32.0;

Surface surface_at(ivec2 pixel) {
    Surface surface;
    surface.depth = imageLoad(gbuffer_depth, pixel).r;
    surface.position = position_at(pixel, surface.depth);
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    surface.shading = octahedral_decode(normals.xy);
    surface.geometric = octahedral_decode(normals.zw);
    surface.lift = LIFT * pixel_footprint();
    return surface;
}

// Irradiance on the surface per irradiance across the unit direction `to_light`: the cosine between that and the shading normal, plus the
// cosine of the direction below the triangle that the triangle mirrors to it. Twin: `WorldSurface::received` in src/scene/world_surface.rs.
float received(Surface surface, vec3 to_light) {
    float cosine = dot(surface.shading, to_light);
    float above = dot(surface.geometric, to_light);
    float mirrored = cosine - 2.0 * above * dot(surface.geometric, surface.shading);
    return above > 0.0 ? max(cosine, 0.0) + max(mirrored, 0.0) : 0.0;
}

// Where rays from the surface begin.
vec3 ray_origin(Surface surface) {
    return mix(surface.position, frame.eye.xyz, surface.lift) + surface.geometric * ray_offset(surface.position);
}
