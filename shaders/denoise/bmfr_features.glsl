// The features of a texel: products of attributes of its surface. Twin: src/settings/bmfr_features.rs. Needs gbuffer.glsl and
// FEATURES.

// Codes of three factors a feature, 5 bits each: see `factor_of`; of two features a word.
layout(set = 0, binding = 7, std140) uniform FeatureBlock { uvec4 codes[8]; } features;

// The features' inputs at a surface. Positions and distance are from -1 to 1 in the block, so that products of them stay well-conditioned;
// what they span together with the constant is the same.
struct FeatureInputs {
    vec3 normal;
    vec4 place; // xyz: position; w: distance to the eye
    vec4 material; // rgb: albedo; w: roughness
};

// The bit of a code for the root of the magnitude.
const uint ROOT = 16u;

float factor_of(uint code, FeatureInputs at) {
    float value = 1.0;
    switch (code & 15u) {
        case 1u: value = at.normal.x; break;
        case 2u: value = at.normal.y; break;
        case 3u: value = at.normal.z; break;
        case 4u: value = at.place.x; break;
        case 5u: value = at.place.y; break;
        case 6u: value = at.place.z; break;
        case 7u: value = at.place.w; break;
        case 8u: value = at.material.r; break;
        case 9u: value = at.material.g; break;
        case 10u: value = at.material.b; break;
        case 11u: value = at.material.a; break;
    }
    return (code & ROOT) != 0u ? sqrt(abs(value)) : value;
}

uint code_of(uint feature) { return features.codes[feature / 8u][feature / 2u % 4u] >> (feature % 2u * 16u) & 0x7fffu; }

float feature_of(uint feature, FeatureInputs at) {
    uint code = code_of(feature);
    float value = 1.0;
    for (; code != 0u; code >>= 5u) value *= factor_of(code & 31u, at);
    return value;
}
