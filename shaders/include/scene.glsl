// Instances and materials. Twins: InstanceData, MaterialData in src/passes/structs.rs.

struct InstanceData {
    vec4 object_to_world[3];          // rows
    vec4 world_to_object[3];          // rows
    vec4 previous_object_to_world[3]; // rows, one frame ago
    vec4 emission;                    // rgb: what its materials' emission is multiplied by
    uint mirrored;                    // 1: its transform swaps left and right
    uint pad0;
    uint pad1;
    uint pad2;
};

struct MaterialData {
    vec4 base;        // rgb: base colour, to be multiplied with its texture; w: metallic
    vec4 reflectance; // rgb: F0 of a dielectric; w: F90
    vec4 emission;    // rgb: radiance of the front side, to be multiplied with its texture; w: roughness
    vec4 mean_emission; // rgb: the same, mean over its texture
    vec4 mean_albedo; // rgb: share of the light that it reflects, mean over textures and directions
    uint mask;        // index of the alpha mask plus one, 0: none
    uint maps;        // which textures it has: see MAP_...
    uint pad1;
    uint pad2;
};

// Bits of `maps`, besides the texture of the base colour. Twin: the constants in src/passes/scene_buffers.rs.
const uint MAP_METALLIC_ROUGHNESS = 1u; // green: roughness, blue: metallic
const uint MAP_EMISSION = 2u;

vec3 transform_point(vec4 rows[3], vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(dot(rows[0], h), dot(rows[1], h), dot(rows[2], h));
}

// Transforms a normal by the inverse transpose, given the inverse.
vec3 transform_normal(vec4 inverse_rows[3], vec3 n) {
    return inverse_rows[0].xyz * n.x + inverse_rows[1].xyz * n.y + inverse_rows[2].xyz * n.z;
}
