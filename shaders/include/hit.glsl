// The surface that a ray has hit. Needs frame.glsl, gbuffer.glsl and tracer.glsl.
#include "shading_normal.glsl"
#include "textures.glsl"

// What of a surface diffuse light needs.
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

// What of the scene a ray sees: a cone about it (Akenine-Moller et al. 2019).
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

// The mip level for `sample_texture`: how much of an image the cone covers, where it is so wide and meets the surface at this
// cosine. `edges`: two of a triangle's, on the image; `area`: of the parallelogram that they span in the world.
float lod_of(vec4 edges, float area, float width, float cosine) {
    float on_image = abs(edges.x * edges.w - edges.y * edges.z);
    return 0.5 * log2(max(on_image, 1e-30) / area) + log2(max(width, 1e-30) / max(cosine, 1e-3));
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
    vec3 area = cross(transform_vector(instance.object_to_world, b.position - a.position),
        transform_vector(instance.object_to_world, c.position - a.position));
    area = instance.flips_winding == 1u ? -area : area;
    surface.front = dot(area, direction) < 0.0;
    float doubled_area = max(length(area), 1e-30);
    surface.geometric = (surface.front ? area : -area) / doubled_area;

    // Texture coordinates, and how large the cone is on the image.
    mat3x2 first_set = mat3x2(a.uv, b.uv, c.uv);
    vec4 uvs = (first_set * weights).xyxy;
    float length_of_ray = length(direction);
    float width = cone.width + cone.spread * hit.t * length_of_ray;
    float cosine = -dot(surface.geometric, direction) / length_of_ray;
    float lod = lod_of(vec4(b.uv - a.uv, c.uv - a.uv), doubled_area, width, cosine);
    if (uses_second_uvs(material)) {
        uvs.zw = mat3x2(second_uvs.data[places.x], second_uvs.data[places.y], second_uvs.data[places.z]) * weights;
    }

    // Reflection and emission.
    surface.colour = vec4(1.0);
    if ((material.flags & COLOURED) != 0u) {
        surface.colour = mat3x4(unpack_halves(vertex_colours.data[places.x]), unpack_halves(vertex_colours.data[places.y]),
            unpack_halves(vertex_colours.data[places.z])) * weights;
    }
    vec3 vertex_colour = surface.colour.rgb;
    if (material.base_texture.image > 0u) surface.colour *= sample_texture(material.base_texture, uvs, lod);
    surface.bsdf = Bsdf(material.base.rgb * surface.colour.rgb, material.base.w, material.reflectance.rgb,
        material.reflectance.w, material.emission.w);
    if (material.metallic_roughness_texture.image > 0u) {
        vec2 data = sample_texture(material.metallic_roughness_texture, uvs, lod).gb;
        surface.bsdf.roughness *= data.x;
        surface.bsdf.metallic *= data.y;
    }
    surface.emission =
        emits_on(material, surface.front) ? material.emission.rgb * instance.emission.rgb : vec3(0.0);
    if ((material.flags & UNLIT) != 0u) surface.emission *= vertex_colour;
    if (material.emission_texture.image > 0u && surface.emission != vec3(0.0)) {
        surface.emission *= sample_texture(material.emission_texture, uvs, lod).rgb;
    }

    // The shading normal.
    vec3 normal = normalize(mat3(octahedral_decode(unpackSnorm2x16(a.normal)), octahedral_decode(unpackSnorm2x16(b.normal)),
        octahedral_decode(unpackSnorm2x16(c.normal))) * weights);
    vec3 vertex_normal = normalize(transform_normal(instance.world_to_object, normal));
    surface.shading = dot(vertex_normal, surface.geometric) < 0.0 ? -vertex_normal : vertex_normal;
    if (material.normal_texture.image > 0u) {
        vec4 tangent = mat3x4(unpack_tangent(a.tangent), unpack_tangent(b.tangent), unpack_tangent(c.tangent)) * weights;
        vec3 texel = sample_texture(material.normal_texture, uvs, lod).rgb;
        vec3 mapped = mapped_normal(normal, tangent, texel, material.normal_scale);
        mapped = normalize(transform_normal(instance.world_to_object, mapped));
        if (tangent.w != 0.0) surface.shading = seen_normal(vertex_normal, mapped, surface.geometric);
    }
    return surface;
}
