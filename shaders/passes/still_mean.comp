#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Progressive accumulation: the mean of raw radiance, before all denoisers, over the frames in which nothing changes. In: everything that
// radiance is made of, as sampled; the denoised picture. Out: the mean; the correction of the denoised picture, and the
// variance of that.
#include "frame.glsl"
#include "radiance.glsl"
#include "rounded.glsl"
#include "still.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2) uniform texture2D sampled_irradiance;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D denoised;
// a: sum of the squared differences of luminance from its mean (Welford 1962).
layout(set = 0, binding = 11, rgba32f) uniform image2D mean;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D correction;
layout(set = 0, binding = 14, r32f) uniform writeonly image2D variance;
layout(set = 0, binding = 12, std430) readonly buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push {
    uvec4 counts;      // frames in the mean of each pixel of 2x2, with this one
    uvec2 sampled_pixel; // the pixel of 2x2 that the frame has sampled irradiance for
    uint sample_step;  // pixels from one sample to the next: 1, or 2
    float scale;       // of sampled irradiance
    uint adds;         // 1: the frame is added to the mean
} push;

bool is_finite(vec3 light) { return !any(isnan(light)) && !any(isinf(light)); }

// Adds a sample to the mean; NaN and infinity change nothing.
vec4 added(vec4 before, vec3 raw, float count) {
    if (!is_finite(raw)) return count > 1.0 ? before : vec4(0.0);
    vec3 now = count > 1.0 ? before.rgb + (raw - before.rgb) / count : raw;
    float squares = count > 1.0 ? before.a + (luminance(raw) - luminance(before.rgb)) * (luminance(raw) - luminance(now)) : 0.0;
    return vec4(now, squares);
}

// Weight of the difference from the denoised picture in the variance: few samples that are all dark seem to have none.
const float DISAGREEMENT = 4.0;

// Deviation of a mean without noise: 0 stands for a mean without samples.
const float LEAST_DEVIATION = 1e-4;

// Standard deviation of the luminance of the mean.
float deviation(vec4 mean, float denoised, float count) {
    float difference = denoised - luminance(mean.rgb);
    float squares = max(mean.a, 0.0) + DISAGREEMENT * difference * difference;
    return sqrt(squares / (count * max(count - 1.0, 0.5)));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 place = uvec2(pixel) % push.sample_step;
    float count = float(push.counts[place.x + 2u * place.y]);
    vec4 average = imageLoad(mean, pixel);
    if (push.adds == 1u && place == push.sampled_pixel) {
        vec3 irradiance = texelFetch(sampled_irradiance, pixel / int(push.sample_step), 0).rgb * push.scale;
        average = added(average, radiance_at(pixel, irradiance).rgb, count);
        imageStore(mean, pixel, average);
    }
    vec4 difference = vec4(0.0);
    if (count > 0.0) {
        vec3 light = imageLoad(denoised, pixel).rgb;
        vec3 relative_to = visible(light, exposure.factor);
        float relative = deviation(average, luminance(light), count) / luminance(relative_to);
        difference = vec4((average.rgb - light) / relative_to, max(relative, LEAST_DEVIATION));
    }
    imageStore(correction, pixel, storable(difference));
    imageStore(variance, pixel, vec4(difference.a * difference.a));
}
