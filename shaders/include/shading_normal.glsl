// Shading normals by normal maps. Twins: `map_normal` in src/scene/material.rs, `place` in src/scene/world_surface.rs.

// Least cosine between the normal of a normal map and the flat triangle's: normals beyond are bent up, since light from
// below the triangle would leak.
const float LEAST_COSINE = 0.01;

// The normal of a texel, object space. `normal` has unit length; w of the tangent is the side of the bitangent, 0: there is none.
vec3 mapped_normal(vec3 normal, vec4 tangent, vec3 texel, float scale) {
    if (tangent.w == 0.0) return normal;
    vec3 mapped = texel * 2.0 - 1.0;
    vec3 along = normalize(tangent.xyz);
    vec3 up = cross(normal, along) * sign(tangent.w);
    return normalize((along * mapped.x + up * mapped.y) * scale + normal * mapped.z);
}

// Turns a normal by a normal map to the side that is seen, which `geometric` is on. The vertices' normal decides, since steep
// slopes may face away. All have unit length.
vec3 seen_normal(vec3 vertex_normal, vec3 mapped, vec3 geometric) {
    vec3 normal = dot(vertex_normal, geometric) < 0.0 ? -mapped : mapped;
    float below = LEAST_COSINE - dot(normal, geometric);
    return below > 0.0 ? normalize(normal + geometric * below) : normal;
}
