#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shows one of the images that an effect goes through in place of the picture. In: that image and how to show it. Out: display.
#include "frame.glsl"
#include "tone_map.glsl"
#include "pi.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D shown_image;
layout(set = 0, binding = 2, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D display;

layout(push_constant) uniform Push {
    uint kind; // one of those below
} push;

// Twin: Visualization in src/passes/effect_view.rs.
const uint SHARE = 0u;     // rgb, from 0 to 1
const uint LIGHT = 1u;     // rgb, with the picture's exposure
const uint DEVIATION = 2u; // a, in grey
const uint HISTORY = 3u;   // b: frames; 32 are white
const uint IRRADIANCE = 4u; // rgb, as on white surfaces, with the picture's exposure

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec4 texel = texelFetch(shown_image, pixel, 0);
    vec3 colour = texel.rgb;
    if (push.kind == LIGHT) colour = shown(texel.rgb * exposure.factor);
    if (push.kind == IRRADIANCE) colour = shown(texel.rgb / PI * exposure.factor);
    if (push.kind == DEVIATION) colour = vec3(texel.a);
    if (push.kind == HISTORY) colour = vec3(texel.b / 32.0);
    imageStore(display, pixel, vec4(clamp(colour, 0.0, 1.0), 1.0));
}
