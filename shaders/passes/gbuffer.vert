#version 460
#extension GL_GOOGLE_include_directive : require
// G-buffer, vertices: object space to world and clip space.
#include "frame.glsl"
#include "scene.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

layout(set = 0, binding = 1, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;

layout(push_constant) uniform Push { uint instance; uint material; } push;

layout(location = 0) out vec3 position_ws;
layout(location = 1) out vec3 normal_ws;
layout(location = 2) out vec2 surface_uv;

void main() {
    InstanceData instance = instances.data[push.instance];
    position_ws = transform_point(instance.object_to_world, position);
    normal_ws = transform_normal(instance.world_to_object, normal);
    surface_uv = uv;
    gl_Position = frame.view_projection * vec4(position_ws, 1.0);
}
