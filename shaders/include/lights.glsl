// Lights with shadow maps and the tiles of the shadow atlas. Twins: LightData, ShadowTile in
// src/passes/structs.rs.

const uint LIGHT_POINT = 0u;
const uint LIGHT_SPOT = 1u;
const uint LIGHT_DIRECTIONAL = 2u;

struct LightData {
    vec4 position;  // xyz: world position; w: cosine of the spot's inner angle
    vec4 direction; // xyz: direction in which light travels; w: cosine of the spot's outer angle
    vec4 power;     // rgb: intensity in W/sr, or irradiance in W/m^2
    uint kind;
    uint first_tile;
    uint tile_count; // 6: cube faces +x -x +y -y +z -z; otherwise cascades, nearest first
    uint pad0;
};

struct ShadowTile {
    mat4 view_projection; // world to the tile's clip space, reversed depth
    vec4 rectangle;       // xy: first texel in the atlas; z: texels across; w: unused
    vec4 texel;           // x: world size of a texel (orthographic), or per unit of depth (perspective); y: 1 if perspective;
                          // z: texels around the middle that can be lit, 0: all
};
