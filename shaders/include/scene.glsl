// Instances, vertices and materials. Twins: src/passes/structs.rs, Vertex in src/passes/geometry.rs.

struct InstanceData {
    vec4 object_to_world[3];          // rows
    vec4 world_to_object[3];          // rows
    vec4 previous_object_to_world[3]; // rows, one frame ago
    vec4 emission;                    // rgb: what its materials' emission is multiplied by
    uint mirrored;                    // 1: its transform swaps left and right
    uint first_triangle;              // of its mesh, among those of all
    uint pad1;
    uint pad2;
};

// A vertex in buffers.
struct Vertex {
    vec3 position;  // object space
    uint normal;    // octahedral, two components of 16 bits
    vec2 uv;
    uint tangent;   // see unpack_tangent
    uint colour;    // linear, and alpha, 8 bits each
};

// How a material uses a texture.
struct TextureUse {
    vec4 matrix;    // of two columns, for the coordinates
    vec2 offset;    // added then
    uint image;     // index of the texture plus one, 0: none
    uint modes;     // wrap modes: see wrap.glsl; SECOND_SET
};

// A texture is read by the second set of coordinates.
const uint SECOND_SET = 16u;

struct MaterialData {
    vec4 base;        // rgb: base colour, to be multiplied with its texture; w: metallic
    vec4 reflectance; // rgb: F0 of a dielectric; w: F90
    vec4 emission;    // rgb: radiance of the front side, to be multiplied with its texture; w: roughness
    vec4 mean_emission; // rgb: the same, mean over its texture
    vec4 mean_albedo; // rgb: share of the light that it reflects, mean over textures and directions
    uint mask;        // index of the alpha mask plus one, 0: none
    float normal_scale; // what the slopes of its normal map are multiplied by
    uint pad0;
    uint pad1;
    TextureUse base_texture;
    TextureUse metallic_roughness_texture; // green: roughness, blue: metallic
    TextureUse emission_texture;
    TextureUse normal_texture;
};

// The coordinates on the image, before wrapping; `uvs` are both sets.
vec2 coordinates_of(TextureUse use, vec4 uvs) {
    vec2 uv = (use.modes & SECOND_SET) != 0u ? uvs.zw : uvs.xy;
    return use.matrix.xy * uv.x + use.matrix.zw * uv.y + use.offset;
}

bool uses_second_uvs(MaterialData material) {
    return ((material.base_texture.modes | material.metallic_roughness_texture.modes | material.emission_texture.modes
        | material.normal_texture.modes) & SECOND_SET) != 0u;
}

vec3 transform_point(vec4 rows[3], vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(dot(rows[0], h), dot(rows[1], h), dot(rows[2], h));
}

// Transforms a normal by the inverse transpose, given the inverse.
vec3 transform_normal(vec4 inverse_rows[3], vec3 n) {
    return inverse_rows[0].xyz * n.x + inverse_rows[1].xyz * n.y + inverse_rows[2].xyz * n.z;
}

vec3 transform_vector(vec4 rows[3], vec3 v) {
    return vec3(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}
