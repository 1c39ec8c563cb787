#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Exposure, a filmic curve (the ACES fit of Narkowicz 2015) and the sRGB transfer function.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D colour;
layout(set = 0, binding = 2, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D display;

// Brings the curve's middle grey to where it was before the curve.
const float CURVE_EXPOSURE = 0.6;

vec3 filmic(vec3 x) {
    x *= CURVE_EXPOSURE;
    return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    // Bounded first: the curve's square overflows on very bright lights.
    vec3 exposed = min(texelFetch(colour, pixel, 0).rgb * exposure.factor, vec3(1e4));
    imageStore(display, pixel, vec4(srgb(filmic(exposed)), 1.0));
}
