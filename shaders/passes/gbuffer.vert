#version 460
#extension GL_GOOGLE_include_directive : require
// G-buffer, vertices: object space to world and clip space, now and one frame ago.
#include "frame.glsl"
#include "scene_set.glsl"
#include "gbuffer.glsl"
#include "gbuffer_draw.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 packed_normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in uint packed_tangent;

layout(location = 0) out vec3 position_ws;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 uvs;
layout(location = 3) out vec3 clip_then;
layout(location = 4) out vec4 tangent;
layout(location = 5) out vec4 colour;
layout(location = 6) out float extent; // greatest world coordinate of the triangle's corners, interpolated: its points are rounded relative to it

void main() {
    InstanceData instance = instances.data[push.instance];
    position_ws = transform_point(instance.object_to_world, position);
    extent = greatest(abs(position_ws));
    normal = octahedral_decode(packed_normal);
    uvs = uv.xyxy;
    tangent = vec4(0.0);
    colour = vec4(1.0);
    if (DETAILED) {
        tangent = unpack_tangent(packed_tangent);
        if ((materials.data[push.material].flags & COLOURED) != 0u) {
            colour = unpack_halves(vertex_colours.data[gl_VertexIndex]);
        }
        if (gl_VertexIndex < second_uvs.data.length()) uvs.zw = second_uvs.data[gl_VertexIndex];
    } else {
        normal = transform_normal(instance.world_to_object, normal);
    }
    vec3 position_then = transform_point(instance.previous_object_to_world, position);
    clip_then = (frame.previous_view_projection * vec4(position_then, 1.0)).xyw;
    gl_Position = frame.view_projection * vec4(position_ws, 1.0);
}
