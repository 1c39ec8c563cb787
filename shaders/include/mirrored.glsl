// How much of the GGX lobe's light comes from reflection rays; the rest is by irradiance. Needs frame.glsl. Twin: `mirrored_share` in
// src/effects/reflections.rs.

#ifndef MIRRORED_GLSL
#define MIRRORED_GLSL

const float MIRRORED_BLEND = 0.1;

float mirrored_share(float roughness) {
    float limit = frame.reflection_limit;
    return 1.0 - smoothstep(limit - MIRRORED_BLEND, limit + MIRRORED_BLEND, roughness);
}

#endif
