// How much of the GGX lobe's light comes from reflection rays; the rest is by irradiance. `limit`: roughness up to which rays are
// traced; 1: always, below 0: never. Twin: `mirrored_share` in src/effects/reflections.rs.
const float MIRRORED_BLEND = 0.1;

float mirrored_share(float roughness, float limit) {
    if (limit < 0.0) return 0.0;
    return limit >= 1.0 ? 1.0 : 1.0 - smoothstep(limit - MIRRORED_BLEND, limit + MIRRORED_BLEND, roughness);
}
