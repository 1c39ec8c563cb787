// The surface that a ray has hit. Needs frame.glsl, gbuffer.glsl and tracer.glsl.
#include "shading_normal.glsl"
#include "textures.glsl"

// A surface as diffuse light needs it.
struct MeanSurface {
    vec3 position;
    vec3 normal;   // geometric, on the side that was hit
    vec3 albedo;   // mean of the material's textures
    vec3 emission; // towards the ray's origin, W/m^2/sr, mean likewise
};

MeanSurface mean_surface_of(TracerHit hit, vec3 origin, vec3 direction) {
    vec3 a = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u)).xyz);
    vec3 b = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u + 1u)).xyz);
    vec3 c = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u + 2u)).xyz);
    InstanceData instance = instances.data[hit.instance];
    vec3 normal = normalize(transform_normal(instance.world_to_object, cross(b - a, c - a)));
    bool front = dot(normal, direction) < 0.0;
    MaterialData material = materials.data[hit.material];
    vec3 emission = emits_on(material, front) ? material.mean_emission.rgb * instance.emission.rgb : vec3(0.0);
    return MeanSurface(origin + hit.t * direction, front ? normal : -normal, material.mean_albedo.rgb, emission);
}

// The cone of directions about a ray that a pixel covers (Akenine-Moller et al. 2019).
struct RayCone {
    float width;  // at the origin, world units
    float spread; // what it grows by over a distance of 1
};

// Everything of a surface; twin: `SidedSurface` in src/scene/world_surface.rs, and the material there.
struct HitSurface {
    vec3 position;  // world, on the flat triangle
    vec3 geometric; // unit normals on the side that was hit
    vec3 shading;   // by vertices and normal map
    Bsdf bsdf;
    vec3 emission;  // towards the ray's origin, W/m^2/sr
    vec4 colour;    // of the base colour's texture and the vertices, with alpha
    bool front;     // whether the front side was hit
};

// Two edges of a triangle in the world and on its images, both sets of coordinates, from the first corner.
struct Edges {
    vec3 u;
    vec3 v;
    vec4 uvs_u;
    vec4 uvs_v;
};

// How texture coordinates change along a vector in the triangle's plane, by the share of each edge in it. `area`: cross(u, v).
vec4 along(Edges edges, vec3 area, vec3 vector) {
    vec2 shares = vec2(dot(cross(vector, edges.v), area), dot(cross(edges.u, vector), area)) / max(dot(area, area), 1e-30);
    return shares.x * edges.uvs_u + shares.y * edges.uvs_v;
}

// The footprint of a cone on a triangle, where the cone is `width` wide: as wide across, longer along the ray the flatter it meets the surface.
// `direction`: unit.
Gradients footprint_of(Edges edges, vec3 area, vec3 normal, vec3 direction, float width) {
    float cosine = abs(dot(normal, direction));
    vec3 across = cosine < 0.9999 ? normalize(cross(normal, direction)) : normalize(edges.u);
    return Gradients(along(edges, area, cross(across, normal) * (width / max(cosine, 1e-3))), along(edges, area, across * width));
}

// Everything of the surface at a hit of a ray, whose direction may have any length.
HitSurface surface_of(TracerHit hit, vec3 direction, RayCone cone) {
    InstanceData instance = instances.data[hit.instance];
    MaterialData material = materials.data[hit.material];
    uint first = 3u * (instance.first_triangle + hit.triangle);
    uvec3 places = uvec3(corners.data[first], corners.data[first + 1u], corners.data[first + 2u]);
    Vertex a = vertices.data[places.x];
    Vertex b = vertices.data[places.y];
    Vertex c = vertices.data[places.z];
    vec3 weights = vec3(1.0 - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics);

    // Position and the normal of the flat triangle, on the side that was hit.
    HitSurface surface;
    vec3 local = a.position * weights.x + b.position * weights.y + c.position * weights.z;
    surface.position = transform_point(instance.object_to_world, local);
    Edges edges = Edges(transform_vector(instance.object_to_world, b.position - a.position),
        transform_vector(instance.object_to_world, c.position - a.position), (b.uv - a.uv).xyxy, (c.uv - a.uv).xyxy);
    vec3 plane = cross(edges.u, edges.v);
    vec3 area = instance.flips_winding == 1u ? -plane : plane;
    surface.front = dot(area, direction) < 0.0;
    float doubled_area = max(length(area), 1e-30);
    surface.geometric = (surface.front ? area : -area) / doubled_area;
    surface.position += surface.geometric * (CORNER_ROUNDING * greatest(max(abs(edges.u), abs(edges.v))));

    // Texture coordinates, and what of them the cone covers.
    mat3x2 first_set = mat3x2(a.uv, b.uv, c.uv);
    vec4 uvs = (first_set * weights).xyxy;
    float length_of_ray = length(direction);
    if (uses_second_uvs(material)) {
        mat3x2 second = mat3x2(second_uvs.data[places.x], second_uvs.data[places.y], second_uvs.data[places.z]);
        uvs.zw = second * weights;
        edges.uvs_u.zw = second[1] - second[0];
        edges.uvs_v.zw = second[2] - second[0];
    }
    float width = cone.width + cone.spread * hit.t * length_of_ray;
    Gradients footprint = footprint_of(edges, plane, surface.geometric, direction / length_of_ray, width);

    // Reflection and emission.
    surface.colour = vec4(1.0);
    if ((material.flags & COLOURED) != 0u) {
        surface.colour = mat3x4(unpack_halves(vertex_colours.data[places.x]), unpack_halves(vertex_colours.data[places.y]),
            unpack_halves(vertex_colours.data[places.z])) * weights;
    }
    vec3 vertex_colour = surface.colour.rgb;
    if (material.base_texture.image > 0u) surface.colour *= sample_texture(material.base_texture, uvs, footprint);
    surface.bsdf = Bsdf(material.base.rgb * surface.colour.rgb, material.base.w, material.reflectance.rgb,
        material.reflectance.w, material.emission.w);
    if (material.metallic_roughness_texture.image > 0u) {
        vec2 data = sample_texture(material.metallic_roughness_texture, uvs, footprint).gb;
        surface.bsdf.roughness *= data.x;
        surface.bsdf.metallic *= data.y;
    }
    surface.emission =
        emits_on(material, surface.front) ? material.emission.rgb * instance.emission.rgb : vec3(0.0);
    if ((material.flags & UNLIT) != 0u) surface.emission *= vertex_colour;
    if (material.emission_texture.image > 0u && surface.emission != vec3(0.0)) {
        surface.emission *= sample_texture(material.emission_texture, uvs, footprint).rgb;
    }

    // The shading normal.
    vec3 normal = normalize(mat3(octahedral_decode(unpackSnorm2x16(a.normal)), octahedral_decode(unpackSnorm2x16(b.normal)),
        octahedral_decode(unpackSnorm2x16(c.normal))) * weights);
    vec3 vertex_normal = normalize(transform_normal(instance.world_to_object, normal));
    surface.shading = dot(vertex_normal, surface.geometric) < 0.0 ? -vertex_normal : vertex_normal;
    if (material.normal_texture.image > 0u) {
        vec4 tangent = mat3x4(unpack_tangent(a.tangent), unpack_tangent(b.tangent), unpack_tangent(c.tangent)) * weights;
        vec3 texel = sample_texture(material.normal_texture, uvs, footprint).rgb;
        vec3 mapped = mapped_normal(normal, tangent, texel, material.normal_scale);
        mapped = normalize(transform_normal(instance.world_to_object, mapped));
        if (tangent.w != 0.0) surface.shading = seen_normal(vertex_normal, mapped, surface.geometric);
    }
    return surface;
}
