// Uniforms of the frame, for every pass. Twin: FrameUniforms in src/gpu_scene/structs.rs.

struct FrameUniforms {
    mat4 view_projection;          // world to clip, reversed depth
    mat4 previous_view_projection; // the same, one frame ago, without jitter
    vec4 eye;                      // xyz: world position; w: radius of the scene's bounding sphere
    vec4 background;               // rgb: radiance where no surface is, times that of the environment's map; w: its rotation
    vec4 ray;                      // xyz: view direction
    vec4 ray_x;                    // xyz: right times the tangent of half the horizontal field of view
    vec4 ray_y;                    // xyz: down times the tangent of half the vertical field of view
    uvec2 size;                    // of the picture, pixels
    uint light_count;              // point, spot and directional lights
    uint noise_frame;              // number of the frame in the sequence of random numbers
    vec2 jitter;                   // from the middle of a pixel to where it is sampled, pixels
    uint seed;                     // of random numbers
    uint direct_lights;            // from the first one on, whose direct light is `direct`; estimators sample the others
    float reflection_limit;        // roughness around which rays cease to trace what surfaces mirror; 2: always, -1: never
    float footprint;               // what of a pixel's width textures are averaged over
    uint tone_map;                 // the tone curve
    uint area_light_count;         // of the scene; in the order of lights they follow the others
};

layout(set = 0, binding = 0, std140) uniform FrameBlock { FrameUniforms data; } frame_uniforms;
FrameUniforms frame = frame_uniforms.data;

#include "pi.glsl"

// From the eye through a pixel's centre; 1 long along the view direction.
vec3 pixel_ray(vec2 pixel) {
    vec2 at = (pixel + 0.5) * (2.0 / vec2(frame.size)) - 1.0;
    return frame.ray.xyz + at.x * frame.ray_x.xyz + at.y * frame.ray_y.xyz;
}

// World position of what a pixel sees at a view depth.
vec3 position_at(ivec2 pixel, float depth) { return frame.eye.xyz + depth * pixel_ray(vec2(pixel)); }

// Side of a pixel's footprint at a view depth of 1, on a surface that faces the eye.
float pixel_footprint() { return length(frame.ray_y.xyz) * 2.0 / float(frame.size.y); }

float greatest(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Rounding error of interpolation and intersection, relative to the coordinates of the triangle's corners. Twin: `ray_offset` in
// src/scene/world_surface.rs.
const float CORNER_ROUNDING = 4e-7;

// Distance by which ray ends lie off their surfaces at world position p. The rounding error of p grows with its coordinates, that of
// rasterized depth, about 1e-5, with the distance to the eye; a fifth of the scene's radius bounds that, for views from far away.
float ray_offset(vec3 p) {
    return 2e-5 * max(greatest(abs(p)), min(distance(p, frame.eye.xyz), 0.2 * frame.eye.w));
}

float luminance(vec3 rgb) { return dot(rgb, vec3(0.2126, 0.7152, 0.0722)); }
