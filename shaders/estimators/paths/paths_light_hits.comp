#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lights what reflection rays have hit: each hit goes on as a path. In: the hits. Out: their light is added to the reflection.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "rounded.glsl"
#include "tracer.glsl"
#include "hit.glsl"
#include "noise.glsl"
#define RAY_COUNTER_BINDING 8
#include "ray_counter.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
#include "unshadowed.glsl"
#include "light_sampling.glsl"
#include "environment.glsl"
#include "environment_sampling.glsl"
#include "hit_record.glsl"
layout(set = 0, binding = 6, rgba32ui) uniform readonly uimage2D hit_place;
layout(set = 0, binding = 7, rgba16f) uniform readonly image2D hit_weight;
layout(set = 0, binding = 20, rgba16f) uniform image2D reflection;
#include "path_push.glsl"
#include "no_vertices.glsl"
#include "path.glsl"

// The first ones are those of the paths of visible surfaces.
const uint FIRST_DIMENSION = 80u;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool in_picture = all(lessThan(gl_GlobalInvocationID.xy, frame.size));
    uint rays = 0u;
    vec4 weight = in_picture ? imageLoad(hit_weight, pixel) : vec4(0.0);
    if (weight.rgb != vec3(0.0)) {
        HitRecord hit = unpack_hit(imageLoad(hit_place, pixel), weight);
        Surface surface = Surface(hit.position, hit.shading, hit.geometric, 1.0, 0.0);
        RayCone cone = RayCone(0.0, push.spread);
        vec3 light = path_irradiance(surface, cone, frame.direct_lights, pixel, frame.noise_frame, FIRST_DIMENSION, rays);
        vec4 before = imageLoad(reflection, pixel);
        imageStore(reflection, pixel, storable(vec4(before.rgb + hit.weight * light, before.a)));
    }
    count_rays(rays);
}
