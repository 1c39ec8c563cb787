#version 460
#extension GL_GOOGLE_include_directive : require
// The mean of the environment's map without its suns over the GGX lobe around each direction, by roughness: see split_sum.glsl. In: the
// map. Out: its levels, as the map is turned, without the factor of its radiance.
#include "frame.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "environment.glsl"
#include "split_sum.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, rgba16f) uniform writeonly image2D prefiltered_environment;

const uint SAMPLES = 1024u;

// Point i of the Hammersley set.
vec2 sample_of(uint i) { return vec2((float(i) + 0.5) / float(SAMPLES), float(bitfieldReverse(i) >> 8u) * exp2(-24.0)); }

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, ivec2(LEVEL_SIZE.x, LEVEL_SIZE.y * LEVELS)))) return;
    int level = texel.y / LEVEL_SIZE.y;
    vec3 normal = map_direction((vec2(texel.x, texel.y % LEVEL_SIZE.y) + 0.5) / vec2(LEVEL_SIZE));
    // A white lobe, seen along its normal.
    float roughness = float(level + 1) / float(LEVELS);
    Reflection lobe = prepare_bsdf(Bsdf(vec3(0.0), 0.0, vec3(1.0), 1.0, roughness), normal, normal);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (uint i = 0u; i < SAMPLES; i++) {
        Sampled light = sample_reflected(lobe, sample_of(i));
        if (light.density <= 0.0) continue;
        float weight = reflected_towards_eye(lobe, light.direction).x * dot(normal, light.direction) / light.density;
        sum += weight * textureLod(sky_map, map_place(light.direction), 0.0).rgb;
        weights += weight;
    }
    imageStore(prefiltered_environment, texel, storable(vec4(sum / weights, 1.0)));
}
