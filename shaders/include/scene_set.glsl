// Set 1, the scene: instances, geometry, materials, textures, lights, the environment, noise and the BVH, as every shader reads them
// that casts rays or shades what these hit. Twins: src/gpu_scene/structs.rs and the files named at each struct.

#ifndef SCENE_SET_GLSL
#define SCENE_SET_GLSL

struct InstanceData {
    vec4 object_to_world[3];          // rows
    vec4 world_to_object[3];          // rows
    vec4 previous_object_to_world[3]; // rows, one frame ago
    vec4 emission;                    // rgb: what its materials' emission is multiplied by
    uint flips_winding;                  // 1: its transform swaps left and right
    uint first_triangle;              // of its mesh, among those of all
    uint area_light;                  // index of the area light that it is, plus one; 0: none
    uint is_dynamic;                  // 1: it may move
};

// A vertex in buffers.
struct Vertex {
    vec3 position;  // object space
    uint normal;    // octahedral, two components of 16 bits
    vec2 uv;
    uint tangent;   // see unpack_tangent
    uint pad;
};

// How a material uses a texture.
struct TextureUse {
    vec4 matrix;    // of two columns, for the coordinates
    vec2 offset;    // added then
    uint image;     // index of the texture plus one, 0: none
    uint modes;     // how it is read: see wrap.glsl; SECOND_SET
};

// A texture is read by the second set of coordinates.
const uint SECOND_SET = 16u;

struct MaterialData {
    vec4 base;        // rgb: base colour, to be multiplied with its texture; w: metallic
    vec4 reflectance; // rgb: F0 of a dielectric; w: F90
    vec4 emission;    // rgb: radiance of the sides that emit, to be multiplied with its texture; w: roughness
    vec4 mean_emission; // rgb: the same, mean over its texture
    vec4 mean_albedo; // rgb: share of the light that it reflects, mean over textures and directions
    uint mask;        // index of the alpha mask plus one, 0: none
    float normal_scale; // what the slopes of its normal map are multiplied by
    uint flags;       // of those below
    uint pad1;
    TextureUse base_texture;
    TextureUse metallic_roughness_texture; // green: roughness, blue: metallic
    TextureUse emission_texture;
    TextureUse normal_texture;
};

// Some of its vertices have colours.
const uint COLOURED = 1u;
// Raster culls its back; all other rays meet both sides.
const uint SINGLE_SIDED = 2u;
// The back of the material emits as the front does.
const uint EMITS_ON_BOTH_SIDES = 4u;
// Vertex colours multiply the material's emission.
const uint UNLIT = 8u;

bool emits_on(MaterialData material, bool front) { return front || (material.flags & EMITS_ON_BOTH_SIDES) != 0u; }

struct LightData {
    vec4 position;  // xyz: world position; w: cosine of the spot's inner angle
    vec4 direction; // xyz: direction in which light travels; w: cosine of the spot's outer angle
    vec4 power;     // rgb: intensity in W/sr, or irradiance in W/m^2
    uint kind;
    float radius;     // of the sphere that shines (point, spot), world units; 0 for a point
    float half_angle; // of the disc that shines (directional), radians; 0 for parallel light
    uint pad2;
};

// Twin of this and the next: src/gpu_scene/area_lights.rs.
struct AreaLightData {
    vec4 centre; // xyz: of its bounds; w: their radius
    vec4 facing; // xyz: mean normal, shorter than 1 where the light is not flat
    vec4 power;  // rgb: radiance times area, the sum of its emitters, W/sr
    uint first;  // of its emitters
    uint count;
    uint is_visible; // to rays
    float area;  // of its emitters
};

// A triangle, in the world; its normal is that of the side that emits.
struct Emitter {
    vec4 corner;   // xyz; w: share of the light's flux of the emitters up to this one
    vec4 edge_u;   // xyz: to the second corner; w: density of points, 1/area
    vec4 edge_v;   // xyz: to the third; w: 1 if rays hit it, which pass thin surfaces
    vec4 radiance; // rgb; w: index of its alpha mask plus one, as bits
    vec4 uvs;      // of the mask: first and second corner
    vec4 uv;       // xy: third; zw: alphas of the corners, half floats as bits
};

// An image in the buffer.
struct TextureData {
    uint first;  // word of the first level
    uint size;   // of that, width in the lower 16 bits, height above
    uint levels;
    uint format; // of its texels: see bilinear.glsl
};

// The corners of a thin surface's triangle. Twins of this and the next: src/bvh/thin_surfaces.rs.
struct GpuThinTriangle {
    vec2 uvs[3];      // on the texture of the base colour
    uvec2 colours[3]; // linear, and alpha, half floats
};

// The material of a thin surface.
struct GpuThinSurface {
    vec4 passed;      // rgb: what it lets pass where its coat reflects nothing; w: opacity
    vec4 base;        // rgb: base colour, w: metallic, of its coat, mean over textures
    vec4 reflectance; // rgb: F0, w: F90
    float roughness;  // mean likewise
    uint first;       // word of its texture
    uint size;        // of that, width in the lower 16 bits, height above; 0: there is none
    uint modes;       // how it is read: see wrap.glsl; THIN_LINEAR, THIN_BLENDS, THIN_HALF
};

// The texture's colour is linear.
const uint THIN_LINEAR = 16u;
// Alpha is the share of the surface that is there; otherwise all is.
const uint THIN_BLENDS = 32u;
// The texture's texels are half floats.
const uint THIN_HALF = 128u;


#define SCENE_BUFFER(place) layout(set = 1, binding = place, std430) restrict readonly buffer

SCENE_BUFFER(0) InstanceBlock { InstanceData data[]; } instances;
SCENE_BUFFER(1) MaterialBlock { MaterialData data[]; } materials;
SCENE_BUFFER(2) VertexBlock { Vertex data[]; } vertices;
SCENE_BUFFER(3) SecondUvBlock { vec2 data[]; } second_uvs;
// Three vertices a triangle, in the order of the meshes' triangles.
SCENE_BUFFER(4) CornerBlock { uint data[]; } corners;
SCENE_BUFFER(5) TextureBlock { TextureData data[]; } textures;
// RGBA8, every mip level of every texture; of half floats two words a texel.
layout(set = 1, binding = 6) uniform textureBuffer texture_texels;
// Point, spot and directional lights.
SCENE_BUFFER(7) LightBlock { LightData data[]; } lights;
SCENE_BUFFER(8) AreaLightBlock { AreaLightData data[]; } area_lights;
SCENE_BUFFER(9) EmitterBlock { Emitter data[]; } emitters;
// Equirectangular, from the top left; its middle lies towards -z, its right half towards +x. One texel where there is no map.
layout(set = 1, binding = 10) uniform sampler2D environment_map;
// The cumulative distribution of the luminance of its sky: of the rows of cells, then of the cells of each row, and its integral (src/scene/environment.rs).
SCENE_BUFFER(11) EnvironmentBlock { float cumulative[]; } environment_distribution;
// Two channels of 8 bits, frame by frame, 64 x 64 texels each: two texels a word. See examples/blue_noise.rs.
SCENE_BUFFER(12) BlueNoiseBlock { uint words[]; } blue_noise;

// The BVH, as every ray reads it. Three words a triangle: corners with (id, masked, material).
layout(set = 1, binding = 13) uniform utextureBuffer bvh_triangles;
// Two words a triangle with an alpha mask: three pairs of texture coordinates, then the mask (16 bits) and three alphas (half floats).
SCENE_BUFFER(14) bvh_triangle_uvs_block { uvec4 words[]; } bvh_triangle_uvs;
// (first word of texels, width in the lower 16 bits and height above, how it is read, threshold as bits): see mask.glsl.
SCENE_BUFFER(15) bvh_masks_block { uvec4 masks[]; } bvh_masks;
SCENE_BUFFER(16) bvh_mask_texels_block { uint words[]; } bvh_mask_texels;
SCENE_BUFFER(17) bvh_thin_triangles_block { GpuThinTriangle data[]; } bvh_thin_triangles;
// One for each material.
SCENE_BUFFER(18) bvh_thin_surfaces_block { GpuThinSurface data[]; } bvh_thin_surfaces;
// RGBA of 8 bits or half floats, level 0 of the textures of thin surfaces.
SCENE_BUFFER(19) bvh_thin_texels_block { uint words[]; } bvh_thin_texels;
#ifdef TRACER_HARDWARE
layout(set = 1, binding = 20) uniform accelerationStructureEXT bvh_top_level;
// First triangle of run r (opaque, masked) of mesh m, at 2m + r.
SCENE_BUFFER(21) bvh_runs_block { uint first_triangles[]; } bvh_runs;
#else
// Five words a node.
layout(set = 1, binding = 22) uniform utextureBuffer bvh_nodes;
// Four words an instance: three rows of world to object, then (root, instance).
layout(set = 1, binding = 23) uniform utextureBuffer bvh_instances;
// Groups to begin with, of the static and the dynamic instances: see tracer_find.
SCENE_BUFFER(24) bvh_roots_block { uvec4 groups; } bvh_roots;
#endif
// Linear colour and alpha of all vertices, half floats; of none if all are white.
SCENE_BUFFER(25) VertexColourBlock { uvec2 data[]; } vertex_colours;
// environment_map without its suns, which are lights: see src/scene/suns.rs.
layout(set = 1, binding = 26) uniform sampler2D sky_map;

vec4 unpack_halves(uvec2 packed) { return vec4(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y)); }

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

#endif
