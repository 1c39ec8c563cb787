#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Progressive accumulation: the mean of raw radiance, before all denoisers, over the frames in which nothing changes. The picture fades
// from the denoised one to that mean as its standard error falls. In: everything that
// radiance is made of, as sampled; the denoised picture. Out: mean and picture.
#include "frame.glsl"
#include "radiance.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2) uniform texture2D sampled_irradiance;
// The denoised picture before, unless that is `antialiased`; a: how much the pixel counts for automatic exposure.
layout(set = 0, binding = 4, rgba16f) uniform image2D picture;
layout(set = 0, binding = 5, rgba16f) uniform readonly image2D antialiased;
// a: sum of the squared differences of luminance from its mean (Welford 1962).
layout(set = 0, binding = 11, rgba32f) uniform image2D mean;
layout(set = 0, binding = 12, std430) readonly buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push {
    uvec4 counts;        // frames in the mean of each pixel of 2x2, with this one
    uvec2 represented;   // the pixel of 2x2 that the frame has sampled irradiance for
    uint sample_step;    // pixels from one sample to the next: 1, or 2
    float scale;         // of sampled irradiance
    uint adds;           // 1: the frame is added to the mean
    uint is_antialiased; // 1: the denoised picture is `antialiased`
    float least_weight;  // of the mean in the picture
} push;

// Relative standard deviations of the mean up to which it is all of the picture, and from which on it is nothing.
const float UNSEEN = 0.03;
const float NOISY = 0.3;
// Of what is shown: in what is darker than this, noise is seen less.
const float DARK = 0.05;

bool is_finite(vec3 light) { return !any(isnan(light)) && !any(isinf(light)); }

// One more sample; what is not a number changes nothing.
vec4 added(vec4 before, vec3 raw, float count) {
    if (!is_finite(raw)) return count > 1.0 ? before : vec4(0.0);
    vec3 now = count > 1.0 ? before.rgb + (raw - before.rgb) / count : raw;
    float squares = count > 1.0 ? before.a + (luminance(raw) - luminance(before.rgb)) * (luminance(raw) - luminance(now)) : 0.0;
    return vec4(now, squares);
}

// Weight in the variance of what the denoised picture knows better: few samples that are all dark seem to have no variance.
const float DISAGREEMENT = 4.0;

float weight_of(vec4 mean, float denoised, float count) {
    if (count < 2.0) return push.least_weight;
    float difference = denoised - luminance(mean.rgb);
    float squares = max(mean.a, 0.0) + DISAGREEMENT * difference * difference;
    float deviation = sqrt(squares / (count * (count - 1.0)));
    float relative = deviation / (luminance(mean.rgb) + DARK / max(exposure.factor, 1e-20));
    return max(1.0 - smoothstep(UNSEEN, NOISY, relative), push.least_weight);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 place = uvec2(pixel) % push.sample_step;
    float count = float(push.counts[place.x + 2u * place.y]);
    vec4 average = imageLoad(mean, pixel);
    if (push.adds == 1u && place == push.represented) {
        vec3 irradiance = texelFetch(sampled_irradiance, pixel / int(push.sample_step), 0).rgb * push.scale;
        average = added(average, radiance_at(pixel, irradiance).rgb, count);
        imageStore(mean, pixel, average);
    }
    vec4 denoised = push.is_antialiased == 1u ? imageLoad(antialiased, pixel) : imageLoad(picture, pixel);
    float weight = count > 0.0 ? weight_of(average, luminance(denoised.rgb), count) : 0.0;
    float counts = imageLoad(direct, pixel).a;
    imageStore(picture, pixel, storable(vec4(mix(denoised.rgb, average.rgb, weight), counts)));
}
