#version 460
#extension GL_GOOGLE_include_directive : require
// Direct and indirect light together, exposure, filmic curve and sRGB transfer function.
#include "frame.glsl"
#include "radiance.glsl"
#include "tone_map.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

// Whether pixels that would not change are left alone: what CPU drivers write, they write lane by lane.
layout(constant_id = 0) const bool KEEPS = false;

// Pixels of a thread, one below the other.
layout(constant_id = 1) const uint ROWS = 1u;

layout(set = 0, binding = 4, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 5, rgba8) uniform image2D display;

// Half of the step between two values of the display, and a little less.
const float SAME = 0.499 / 255.0;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy * uvec2(1u, ROWS);
    float factor = exposure.factor;
    uint end = min(pixel.y + ROWS, frame.size.y);
    if (pixel.x >= frame.size.x || pixel.y >= end) return;
    do {
        vec4 now = vec4(shown(radiance_at(ivec2(pixel)).rgb * factor), 1.0);
        bool same = KEEPS && all(lessThan(abs(now - imageLoad(display, ivec2(pixel))), vec4(SAME)));
        if (!same) imageStore(display, ivec2(pixel), now);
    } while (++pixel.y < end);
}
