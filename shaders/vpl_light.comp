#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// What one VPL alone sends to every pixel. Out: rgb: irradiance, weighted; a: 1 where the VPL sees the pixel.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "vpls.glsl"
#define TRACER_BINDING 5
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, std430) readonly buffer VplBlock { GpuVpl data[]; } vpls;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D vpl_light;

// weight: what the irradiance is multiplied by; 0: there is no such VPL.
layout(push_constant) uniform Push { float weight; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    float depth = imageLoad(gbuffer_depth, pixel).r;
    vec4 light = vec4(0.0);
    if (depth > 0.0 && push.weight > 0.0) {
        vec3 position = position_at(pixel, depth);
        vec4 normals = imageLoad(gbuffer_normal, pixel);
        GpuVpl vpl = vpls.data[0];
        vec3 start = position + octahedral_decode(normals.zw) * ray_offset(position);
        vec3 to_vpl = vpl.position + vpl.normal * ray_offset(vpl.position) - start;
        if (!trace_occluded(start, to_vpl, 0.0, 1.0)) {
            light = vec4(contribution(vpl, position, octahedral_decode(normals.xy)) * push.weight, 1.0);
        }
    }
    imageStore(vpl_light, pixel, light);
}
