#version 460
#extension GL_GOOGLE_include_directive : require
// Direct and indirect light together, exposure, filmic curve and sRGB transfer function.
#include "frame.glsl"
#include "radiance.glsl"
#include "tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 4, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 5, rgba8) uniform writeonly image2D display;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    imageStore(display, pixel, vec4(shown(radiance_at(pixel).rgb * exposure.factor), 1.0));
}
