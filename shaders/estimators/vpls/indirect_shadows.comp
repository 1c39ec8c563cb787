#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// One occlusion ray for each pixel and VPL of its class (interleaved sampling, Wald et al. 2002). Out: scaled irradiance of
// the pixel from the VPLs of its class.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "interleave.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#define VPL_CLASSES_BINDING 5
#include "vpl_classes.glsl"
#define RAY_COUNTER_BINDING 7
#include "ray_counter.glsl"
#define TRACER_BINDING 8
#include "tracer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 6, rgba32f) uniform image2D class_irradiance;
#include "surface.glsl"
#include "gather.glsl"

layout(push_constant) uniform Push {
    uint first; // VPL of each class
    uint count; // at most, from there on
} push;

void main() {
    // All pixels of a workgroup have the same class, so they gather the same VPLs: rays stay coherent. The n^2 workgroups of
    // one block of the picture follow one another: the block stays in the caches.
    uint pixel_class = gl_WorkGroupID.x % CLASSES;
    uvec2 block = uvec2(gl_WorkGroupID.x / CLASSES, gl_WorkGroupID.y);
    uvec2 place = uvec2(pixel_class % INTERLEAVE, pixel_class / INTERLEAVE);
    ivec2 pixel = ivec2((block * gl_WorkGroupSize.xy + gl_LocalInvocationID.xy) * INTERLEAVE + place);
    bool inside = all(lessThan(pixel, ivec2(frame.size)));
    uint rays = 0u;
    if (inside) {
        Surface surface = surface_at(pixel);
        VplClass gathered = vpl_classes.data[vpl.first_class + pixel_class];
        uint first = vpl.first_vpl + gathered.first + push.first;
        uint end = vpl.first_vpl + gathered.first + min(push.first + push.count, gathered.count);
        vec3 irradiance = vec3(0.0);
        if (surface.depth > 0.0) irradiance = gather(surface, first, end, 1u, rays) * vpl.irradiance_scale;
        if (push.first > 0u) irradiance += imageLoad(class_irradiance, pixel).rgb;
        imageStore(class_irradiance, pixel, vec4(irradiance, 0.0));
    }
    count_rays(rays);
}
