// One of all lights, area lights among them: sampled in proportion to an estimate of its unoccluded radiance to the eye; then a
// point of the light. Needs unshadowed.glsl and tracer.glsl.
#include "reservoir.glsl"

// A light; probability 0: none sends anything.
struct ChosenLight {
    uint index;
    float probability;
    vec3 unshadowed; // what all lights send, about
};

// One of the lights from `first` on.
ChosenLight choose_light(ShadingPoint point, float pick, uint first, uint count) {
    Reservoir reservoir = new_reservoir(pick);
    vec3 all = vec3(0.0);
    // Where no surface is nothing is sampled.
    uint end = point.surface.depth > 0.0 ? first + count : first;
    for (uint i = first; i < end; i++) {
        vec3 radiance = unshadowed_radiance(i, point);
        all += radiance;
        update(reservoir, i, luminance(radiance));
    }
    return ChosenLight(reservoir.selected, reservoir.sum > 0.0 ? reservoir.weight / reservoir.sum : 0.0, all);
}

// One of those whose direct light is `direct`.
ChosenLight choose_light(ShadingPoint point, float pick) { return choose_light(point, pick, 0u, frame.direct_lights); }

// A point of a light.
struct LightSample {
    vec3 to_light;   // unit
    float reach;     // along it from the surface to the light, FAR at most
    vec3 irradiance; // across it, over the density of the direction; 0: nothing comes from there
    float gloss;     // share of the GGX lobe that counts
    float density;   // of the direction if points were uniform on the light, 1/sr; 0: rays do not meet the light
};

bool emitter_is_opaque(Emitter emitter, vec2 weights) {
    uint mask = floatBitsToUint(emitter.radiance.w);
    if (mask == 0u) return true;
    vec2 uv = emitter.uvs.xy * (1.0 - weights.x - weights.y) + emitter.uvs.zw * weights.x + emitter.uv.xy * weights.y;
    vec3 alphas = vec3(unpackHalf2x16(floatBitsToUint(emitter.uv.z)), unpackHalf2x16(floatBitsToUint(emitter.uv.w)).x);
    return mask_opaque(mask - 1u, uv, dot(alphas, vec3(1.0 - weights.x - weights.y, weights)));
}

LightSample sample_emitter(AreaLightData light, vec3 position, vec2 u, float gloss) {
    // By flux: a binary search in the cumulative distribution.
    uint low = light.first;
    uint high = light.first + light.count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (u.x < emitters.data[middle].corner.w) high = middle;
        else low = middle + 1u;
    }
    Emitter emitter = emitters.data[low];
    float before = low > light.first ? emitters.data[low - 1u].corner.w : 0.0;
    u.x = clamp((u.x - before) / max(emitter.corner.w - before, 1e-30), 0.0, 1.0);
    // Uniform in the triangle.
    float root = sqrt(u.x);
    vec2 weights = vec2(root * (1.0 - u.y), root * u.y);
    vec3 point = emitter.corner.xyz + emitter.edge_u.xyz * weights.x + emitter.edge_v.xyz * weights.y;
    vec3 normal = normalize(cross(emitter.edge_u.xyz, emitter.edge_v.xyz));
    vec3 d = point - position;
    float squared = dot(d, d);
    float cosine = -dot(normal, d);
    LightSample none = LightSample(normal, 0.0, vec3(0.0), gloss, 0.0);
    if (!(cosine > 0.0 && squared > 0.0) || !emitter_is_opaque(emitter, weights)) return none;
    vec3 end = point + normal * ray_offset(point) - position;
    float reach = length(end);
    float solid_angle = cosine * inversesqrt(squared) / squared; // of a unit of area
    float density = emitter.edge_v.w / (solid_angle * light.area);
    return LightSample(end / reach, reach, emitter.radiance.rgb * (solid_angle / emitter.edge_u.w), gloss, density);
}

// Samples a point of a light, as seen from the surface.
LightSample sample_light(uint index, ShadingPoint point, vec2 u) {
    if (index >= frame.light_count) {
        AreaLightData light = area_lights.data[index - frame.light_count];
        return sample_emitter(light, point.surface.position, u, gloss_of(light, point));
    }
    LightData light = lights.data[index];
    vec3 to_light;
    vec3 irradiance = unshadowed(light, point.surface.position, to_light);
    LightCone cone = cone_of(light, point.surface.position);
    LightSample result = LightSample(vec3(0.0), 0.0, irradiance * gain_of(cone), 1.0, 0.0);
    result.to_light = sample_cone(cone, u, result.reach);
    return result;
}

// Transmittance of the ray from just off the surface to the sample.
vec3 sample_transmittance(LightSample light, Surface surface) {
    if (light.reach <= 0.0) return vec3(1.0);
    vec3 origin = ray_origin(surface);
    bool is_far = light.reach >= FAR;
    vec3 direction = is_far ? light.to_light : surface.position + light.to_light * light.reach - origin;
    return trace_transmittance(origin, direction, 0.0, is_far ? FAR : 1.0);
}

// Radiance that the sampled light sends to the eye, over the probability of having chosen it.
vec3 sampled_radiance(ShadingPoint point, ChosenLight chosen, LightSample light) {
    float cosine = dot(point.surface.shading, light.to_light);
    bool faces = cosine > 0.0 && dot(point.surface.geometric, light.to_light) > 0.0;
    if (!faces || light.irradiance == vec3(0.0)) return vec3(0.0);
    vec3 radiance = bsdf_of(point, light.to_light, light.gloss) * light.irradiance * (cosine / chosen.probability);
    if (radiance == vec3(0.0)) return radiance;
    return radiance * sample_transmittance(light, point.surface);
}
