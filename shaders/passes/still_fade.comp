#version 460
#extension GL_GOOGLE_include_directive : require
// The picture of a still frame: the denoised one, then with the filtered correction, then the mean of still frames, each as the standard
// deviation of the next falls. In: the filtered correction, but for its a, and its variance; the mean; the denoised picture. Out: the picture.
#include "frame.glsl"
#include "rounded.glsl"
#include "still.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D correction;
layout(set = 0, binding = 2, r32f) uniform readonly image2D variance;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2D mean;
layout(set = 0, binding = 5, rgba16f) uniform readonly image2D direct;
// The denoised picture before, unless that is `antialiased`; a: how much the pixel counts for automatic exposure.
layout(set = 0, binding = 4, rgba16f) uniform image2D picture;
layout(set = 0, binding = 6, rgba16f) uniform readonly image2D antialiased;
layout(set = 0, binding = 12, std430) readonly buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push {
    uint is_antialiased; // 1: the denoised picture is `antialiased`
    float least_weight;  // of the mean in the picture
} push;

// Relative standard deviations up to which the filtered correction counts, and from which on it does not; likewise for the mean, whose
// noise nothing blurs.
const vec2 OF_CORRECTION = vec2(0.05, 0.5);
const vec2 OF_MEAN = vec2(0.01, 0.1);

// Least share of a dark pixel's light that the correction leaves: the surface around may be too bright by more than all of it.
const float DARKEST = 0.25;

float weight_of(float deviation, vec2 range) { return 1.0 - smoothstep(range.x, range.y, deviation); }

// Deviation of the mean around a pixel: where rare bright samples have not come to a pixel yet, its own is too small.
float deviation_around(ivec2 pixel) {
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 25; i++) {
        ivec2 at = clamp(pixel + ivec2(i % 5, i / 5) - 2, ivec2(0), ivec2(frame.size) - 1);
        float deviation = imageLoad(correction, at).a;
        if (deviation > 0.0) sum += vec2(deviation * deviation, 1.0);
    }
    return sqrt(sum.x / sum.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    vec3 light = (push.is_antialiased == 1u ? imageLoad(antialiased, pixel) : imageLoad(picture, pixel)).rgb;
    vec4 filtered = imageLoad(correction, pixel);
    float weight = weight_of(sqrt(imageLoad(variance, pixel).r), OF_CORRECTION);
    light = max(light + weight * filtered.rgb * visible(light, exposure.factor), DARKEST * light);
    if (filtered.a > 0.0) {
        light = mix(light, imageLoad(mean, pixel).rgb, max(weight_of(deviation_around(pixel), OF_MEAN), push.least_weight));
    }
    imageStore(picture, pixel, storable(vec4(light, imageLoad(direct, pixel).a)));
}
