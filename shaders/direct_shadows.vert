#version 460
#extension GL_GOOGLE_include_directive : require
// Shadow maps, vertices: object space to the clip space of one tile.
#include "scene.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;

layout(set = 0, binding = 0, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;

layout(push_constant) uniform Push { mat4 view_projection; uint instance; uint mask; uint pad0; uint pad1; } push;

layout(location = 0) out vec2 surface_uv;

void main() {
    surface_uv = uv;
    vec3 position_ws = transform_point(instances.data[push.instance].object_to_world, position);
    gl_Position = push.view_projection * vec4(position_ws, 1.0);
}
