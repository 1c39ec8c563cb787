#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shows one of the images that a frame goes through instead of the picture. In: those images and which one.
// Out: display. Light is shown as the picture is, with its exposure; everything else as plain display values.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "tone_map.glsl"
#include "false_colour.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 6) uniform texture2D gbuffer_motion;
layout(set = 0, binding = 7, r32ui) uniform readonly uimage2DArray direct_shadows;
layout(set = 0, binding = 8, rgba16f) uniform readonly image2D direct;
layout(set = 0, binding = 9, rgba16f) uniform readonly image2D irradiance;
layout(set = 0, binding = 10, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 12) uniform utexture2D gbuffer_surface;
layout(set = 0, binding = 11, rgba8) uniform writeonly image2D display;

// Twin: Push in src/passes/buffer_view.rs.
layout(push_constant) uniform Push {
    vec4 low;    // xyz: lower corner of the scene's bounds; w: nearest depth of anything
    vec4 extent; // xyz: upper corner less the lower; w: farthest depth of anything
    uint view;   // one of those below
    uint pad0;
    uint pad1;
    uint pad2;
} push;

// Twin: VIEWS in src/passes/buffer_view.rs.
const uint COMBINED = 0u;
const uint DIRECT = 1u;
const uint INDIRECT = 2u;
const uint IRRADIANCE = 3u;
const uint DIRECT_SHADOWS = 4u;
const uint POSITION = 5u;
const uint DEPTH = 6u;
const uint NORMAL = 7u;
const uint GEOMETRIC_NORMAL = 8u;
const uint ALBEDO = 9u;
const uint REFLECTANCE = 10u;
const uint ROUGHNESS = 11u;
const uint BASE_COLOUR = 12u;
const uint METALLIC = 13u;
const uint EMISSION = 14u;
const uint INSTANCE = 15u;
const uint MATERIAL_ID = 16u;
const uint MOTION = 17u;

// Movement in pixels that is shown at full strength.
const float FULL_MOTION = 16.0;

// Share of the lights that reaches a pixel, on average.
vec3 visibility(ivec2 pixel) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < frame.light_count; i++) {
        sum += unpack_transmittance(imageLoad(direct_shadows, ivec3(pixel, i / LIGHTS_PER_LAYER)).r, i);
    }
    return sum / float(max(frame.light_count, 1u));
}

vec3 surface_view(ivec2 pixel, uvec2 id) {
    Surface surface = surface_at(pixel);
    MaterialData material = materials.data[id.y & MATERIAL];
    vec4 albedo_roughness = imageLoad(gbuffer_albedo, pixel);
    vec3 albedo = albedo_roughness.rgb;
    uvec2 packed = texelFetch(gbuffer_surface, pixel, 0).xy;
    vec4 base = unpack_base(packed.x);
    vec3 e = imageLoad(irradiance, pixel).rgb;
    switch (push.view) {
        case IRRADIANCE: return shown(e / PI * exposure.factor);
        case DIRECT_SHADOWS: return visibility(pixel);
        case POSITION: return (surface.position - push.low.xyz) / push.extent.xyz;
        case DEPTH: return vec3((push.extent.w - surface.depth) / (push.extent.w - push.low.w));
        case NORMAL: return surface.shading * 0.5 + 0.5;
        case GEOMETRIC_NORMAL: return surface.geometric * 0.5 + 0.5;
        case ALBEDO: return srgb(albedo);
        case REFLECTANCE: return srgb(mix(material.reflectance.rgb, base.rgb, base.a));
        case ROUGHNESS: return vec3(albedo_roughness.a);
        case BASE_COLOUR: return srgb(base.rgb);
        case METALLIC: return vec3(base.a);
        case EMISSION: return shown(unpack_emission(packed.y) * exposure.factor);
        case INSTANCE: return number_colour(id.x - 1u);
        case MATERIAL_ID: return number_colour(id.y & MATERIAL);
        case MOTION:
            vec2 pixels = texelFetch(gbuffer_motion, pixel, 0).xy;
            // The root shows slow movement, too.
            return vec3(0.5 + 0.5 * sign(pixels) * sqrt(abs(pixels) / FULL_MOTION), 0.5);
        default: return shown(albedo / PI * e * exposure.factor);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    vec3 colour = vec3(0.0);
    if (push.view == DIRECT) {
        colour = shown(imageLoad(direct, pixel).rgb * exposure.factor);
    } else if (id.x > 0u) {
        colour = surface_view(pixel, id);
    }
    imageStore(display, pixel, vec4(clamp(colour, 0.0, 1.0), 1.0));
}
