#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Radiance to what is shown: exposure, tone curve and sRGB transfer function.
#include "frame.glsl"
#include "tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D picture;
layout(set = 0, binding = 2, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D display;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    imageStore(display, pixel, vec4(shown(texelFetch(picture, pixel, 0).rgb * exposure.factor), 1.0));
}
