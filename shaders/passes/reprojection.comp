#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Where each visible surface was in the last frame, and which texels there showed it. Light stays with the place and not with what moves
// through it: a turning ball has its history where it is now, if it was there. In: G-buffer; what the last frame saw. Out:
// what this one sees; `reprojected`: xy: motion in pixels; z: which of the four texels around the place show the surface, a bit each
// by rows; w: which of the 3x3 around the nearest one do (the fallback of Schied et al. 2017).
#include "frame.glsl"
#include "scene_set.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 5) uniform texture2D gbuffer_motion;
layout(set = 0, binding = 6, rgba16ui) uniform readonly uimage2D last_surface;
layout(set = 0, binding = 7, rgba16ui) uniform writeonly uimage2D surface;
layout(set = 0, binding = 8, rgba16f) uniform writeonly image2D reprojected;
layout(set = 0, binding = 9, r32ui) uniform readonly uimage2D last_instance;
layout(set = 0, binding = 10, r32ui) uniform writeonly uimage2D instance;
#include "surface.glsl"

layout(push_constant) uniform Push { uint has_history; } push;

VisibleSurface last_surface_at(ivec2 texel) { return unpack_surface(imageLoad(last_surface, texel)); }
uint last_instance_at(ivec2 texel) { return imageLoad(last_instance, texel).x; }
#define REPROJECTION_TESTS 0
#include "reprojected_surface.glsl"

// Share of the depth; rounding of motion and normals.
const float ROUNDING = 0.005;

// Least cosine between the normal of a surface and that which the last frame saw at its place.
const float SAME_NORMAL = 0.98;

// What the last frame should have seen, and at which pixel.
struct Place {
    ExpectedSurface expected;
    vec2 pixel;
};

Place place_of(Surface now, uint id, vec3 then, vec3 normal) {
    vec4 clip = frame.previous_view_projection * vec4(then, 1.0);
    float tolerance = clip.w * depth_tolerance(ROUNDING, now.geometric, now.position, pixel_footprint());
    return Place(ExpectedSurface(VisibleSurface(clip.w, normal), id, tolerance), (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.size) - 0.5 - frame.jitter);
}

// Whether the last frame saw a moving object's surface where it is now, with its normal: then the motion is that of the camera alone.
bool is_stationary(Surface now, ivec2 pixel, uint id, inout vec2 motion, out vec2 masks) {
    Place place = place_of(now, id, now.position, now.shading);
    masks = showing_texels(place.expected, place.pixel);
    ivec2 nearest = clamp(ivec2(floor(place.pixel + 0.5)), ivec2(0), ivec2(frame.size) - 1);
    if (masks.x == 0.0 || dot(last_surface_at(nearest).normal, now.shading) < SAME_NORMAL) return false;
    motion = vec2(pixel) - place.pixel;
    return true;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uint id = texelFetch(gbuffer_instance, pixel, 0).x;
    imageStore(instance, pixel, uvec4(id));
    if (id == 0u) {
        imageStore(surface, pixel, uvec4(0u));
        imageStore(reprojected, pixel, vec4(0.0));
        return;
    }
    Surface now = surface_at(pixel);
    imageStore(surface, pixel, pack_surface(VisibleSurface(now.depth, now.shading)));
    vec2 motion = texelFetch(gbuffer_motion, pixel, 0).xy;
    vec2 masks = vec2(0.0);
    if (push.has_history == 1u) {
        InstanceData placed = instances.data[id - 1u];
        bool moved = placed.object_to_world != placed.previous_object_to_world;
        if (!moved || !is_stationary(now, pixel, id, motion, masks)) {
            vec3 then = transform_point(placed.previous_object_to_world, transform_point(placed.world_to_object, now.position));
            // Motion is rigid, so normals turn as vectors do.
            vec3 local = transform_vector(placed.world_to_object, now.shading);
            vec3 normal = normalize(transform_vector(placed.previous_object_to_world, local));
            masks = showing_texels(place_of(now, id, then, normal).expected, vec2(pixel) - motion);
        }
    }
    imageStore(reprojected, pixel, vec4(motion, masks));
}
