// What is known of each set that was drawn.

const uint MAX_SETS = 64u;

// Camera and light of the frame that drew a set. Twin: SetParameters in src/passes/structs.rs.
struct SetParameters {
    vec4 eye;   // xyz: world position; w: 1 / irradiance scale
    vec4 ray;   // xyz: what the middle of the picture sees, 1 along the view axis; w: luminous flux of the set
    vec4 ray_x; // xyz: how that changes to the right edge; w: one over its squared length
    vec4 ray_y; // xyz: how it changes to the bottom edge; w: one over its squared length
    uint layer; // of the set buffers
    uint pad0;
    uint pad1;
    uint pad2;
};
