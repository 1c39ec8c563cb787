#version 460
#extension GL_GOOGLE_include_directive : require
// Shadow maps, texels: depth only, with alpha masks.
#define MASK_BINDING 1
#include "mask.glsl"

layout(location = 0) in vec2 surface_uv;

layout(push_constant) uniform Push { mat4 view_projection; uint instance; uint mask; uint pad0; uint pad1; } push;

void main() {
    if (push.mask != 0u && !mask_opaque(push.mask, surface_uv)) discard;
}
