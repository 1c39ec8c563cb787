#version 460
#extension GL_GOOGLE_include_directive : require
// Direct and indirect light together, exposure, filmic curve and sRGB transfer function.
#include "frame.glsl"
#include "radiance.glsl"
#include "tone_map.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

// Whether pixels that would not change are left alone: what CPU drivers write, they write lane by lane.
layout(constant_id = 0) const bool KEEPS = false;

layout(set = 0, binding = 4, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 5, rgba8) uniform image2D display;

// Half of the step between two values of the display, and a little less.
const float SAME = 0.499 / 255.0;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec4 now = vec4(shown(radiance_at(pixel).rgb * exposure.factor), 1.0);
    if (KEEPS && all(lessThan(abs(now - imageLoad(display, pixel)), vec4(SAME)))) return;
    imageStore(display, pixel, now);
}
