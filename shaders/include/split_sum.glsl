// Light of the environment in a GGX lobe by the split sum: its mean over the lobe, as it is seen along the normal, times the lobe's
// directional albedo (B. Karis, Real Shading in Unreal Engine 4, 2013, section "Image-Based Lighting"). Nothing is in the way.

// Levels of roughness, 1 / LEVELS apart, below each other, each an equirectangular map. Twin: src/effects/split_sum.rs.
const int LEVELS = 5;
const ivec2 LEVEL_SIZE = ivec2(128, 64);

#ifdef READS_PREFILTERED
// Needs environment.glsl and bsdf.glsl, and `prefiltered_environment`, which environment_prefilter.comp makes.

// Mean over the lobe of roughness (level + 1) / LEVELS, bilinear.
vec3 prefiltered_level(vec2 uv, int level) {
    vec2 place = uv * vec2(LEVEL_SIZE) - 0.5;
    ivec2 corner = ivec2(floor(place));
    vec2 share = place - vec2(corner);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        ivec2 texel = corner + offset;
        texel.x = (texel.x + LEVEL_SIZE.x) % LEVEL_SIZE.x;
        texel.y = clamp(texel.y, 0, LEVEL_SIZE.y - 1) + level * LEVEL_SIZE.y;
        vec2 weight = mix(1.0 - share, share, vec2(offset));
        sum += weight.x * weight.y * imageLoad(prefiltered_environment, texel).rgb;
    }
    return sum;
}

vec3 split_sum(Reflection r, float roughness) {
    vec3 mirrored = reflect(-r.to_eye, r.normal);
    float level = r.mirror ? 0.0 : roughness * float(LEVELS);
    int above = clamp(int(ceil(level)), 1, LEVELS);
    vec2 uv = environment_place(mirrored);
    vec3 smoother = above == 1 ? environment_radiance(mirrored, r.mirror) : frame.background.rgb * prefiltered_level(uv, above - 2);
    vec3 rougher = frame.background.rgb * prefiltered_level(uv, above - 1);
    return r.reflected * mix(smoother, rougher, level - float(above - 1));
}
#endif
