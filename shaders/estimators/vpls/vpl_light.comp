#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of every pixel by one VPL alone. Out: rgb: irradiance, weighted, W/m^2; a: 1 where the VPL sees the pixel.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D vpl_light;
#include "surface.glsl"
#include "gather.glsl"

// weight: factor on the irradiance; 0: there is no such VPL.
layout(push_constant) uniform Push { float weight; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    vec4 light = vec4(0.0);
    if (surface.depth > 0.0 && push.weight > 0.0) {
        GpuVpl one = vpls.data[0];
        vec3 origin = ray_origin(surface);
        vec4 ray = ray_to(one, origin);
        vec3 transmittance = trace_transmittance(origin, ray.xyz, 0.0, ray.w);
        if (transmittance != vec3(0.0)) {
            vec3 irradiance = unshadowed_irradiance(one, surface);
            light = vec4(irradiance * transmittance * push.weight, 1.0);
        }
    }
    imageStore(vpl_light, pixel, storable(light));
}
