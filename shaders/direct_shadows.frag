#version 460
#extension GL_GOOGLE_include_directive : require
// Shadow maps, texels: depth only, with alpha masks.
#define MASK_BINDING 1
#include "mask.glsl"

layout(location = 0) in vec2 surface_uv;

// Whether the material has an alpha mask. What cannot be discarded needs no shading.
layout(constant_id = 0) const bool MASKED = false;

layout(push_constant) uniform Push { mat4 view_projection; uint instance; uint mask; uint pad0; uint pad1; } push;

void main() {
    if (MASKED && !mask_opaque(push.mask, surface_uv)) discard;
}
