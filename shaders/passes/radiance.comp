#version 460
#extension GL_GOOGLE_include_directive : require
// Direct and indirect light together. Out: radiance towards the eye; a: how much the pixel counts for automatic exposure.
#include "frame.glsl"
#include "radiance.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, rgba16f) uniform readonly image2D irradiance;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D radiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    imageStore(radiance, pixel, storable(radiance_at(pixel, imageLoad(irradiance, pixel).rgb)));
}
