// The surface that a pixel sees. Needs frame.glsl, gbuffer.glsl, `gbuffer_depth` and `gbuffer_normal`.

struct Surface {
    vec3 position;
    vec3 shading;   // unit normals on the side that is seen
    vec3 geometric;
    float depth;    // along the view; 0 where no surface is
};

Surface surface_at(ivec2 pixel) {
    Surface surface;
    surface.depth = imageLoad(gbuffer_depth, pixel).r;
    surface.position = position_at(pixel, surface.depth);
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    surface.shading = octahedral_decode(normals.xy);
    surface.geometric = octahedral_decode(normals.zw);
    return surface;
}

// Where rays from the surface begin.
vec3 ray_origin(Surface surface) { return surface.position + surface.geometric * ray_offset(surface.position); }
