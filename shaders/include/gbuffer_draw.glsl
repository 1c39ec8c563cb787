// A draw of the G-buffer. Twins: `Push` in src/passes/gbuffer.rs, `variant` in src/gpu_scene/scene_buffers.rs.

// Sum of what the materials need: see below.
layout(constant_id = 0) const uint VARIANT = 0u;
// An alpha mask. Triangles without one are compared by depth before they are shaded.
const bool MASKED = (VARIANT & 1u) != 0u;
// More than one set of plain texture coordinates: normal maps, vertex colours, transformed coordinates. Then the normal is handed
// over in object space, else in the world.
const bool DETAILED = (VARIANT & 2u) != 0u;

layout(push_constant) uniform Push {
    uint instance;
    uint material;
    uint flags;
} push;

// Bits of `flags`: the transform swaps left and right; the instance or the camera has moved since the last frame.
const uint FLIPS_WINDING = 1u;
const uint MOVED = 2u;
