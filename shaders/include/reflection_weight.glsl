// How much of the GGX lobe's light comes from reflection rays; the rest is by irradiance. Needs frame.glsl. Twin: `reflection_weight` in
// src/effects/reflections.rs.

#ifndef REFLECTION_WEIGHT_GLSL
#define REFLECTION_WEIGHT_GLSL

const float REFLECTION_BLEND = 0.1;

float reflection_weight(float roughness) {
    float limit = frame.reflection_limit;
    return 1.0 - smoothstep(limit - REFLECTION_BLEND, limit + REFLECTION_BLEND, roughness);
}

#endif
