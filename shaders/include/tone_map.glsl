// From exposed radiance to what is shown: a filmic curve (the ACES fit of Narkowicz 2015) and the sRGB transfer
// function. Twin: src/output/tone_map.rs.

// Brings the curve's middle grey to where it was before the curve.
const float CURVE_EXPOSURE = 0.6;

vec3 filmic(vec3 x) {
    x *= CURVE_EXPOSURE;
    return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

// Bounded first: the curve's square overflows on very bright lights.
vec3 shown(vec3 exposed) { return srgb(filmic(min(exposed, vec3(1e4)))); }
