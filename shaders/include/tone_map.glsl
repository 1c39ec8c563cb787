// From exposed radiance to what is shown: a tone curve and the sRGB transfer function. Needs frame.glsl. Twin: src/output/tone_map.rs.

// Values of `frame.tone_map`; twin: `ToneMap` in src/settings/mod.rs.
const uint TONE_ACES = 0u;
const uint TONE_AGX = 1u;

// The exposed radiance from which a grey surface is nearly white.
float white_of_curve() { return frame.tone_map == TONE_ACES ? 8.0 : frame.tone_map == TONE_AGX ? 10.0 : 0.9; }

// The reference rendering and output transforms of ACES, as Hill fitted them; middle grey stays what it is.
vec3 aces(vec3 exposed) {
    const mat3 TO_RRT = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 FROM_ODT = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 x = TO_RRT * (1.45 * exposed);
    return FROM_ODT * ((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.432951) + 0.238081));
}

// Sobotka's AgX, its curve by the polynomial of Wrensch: highlights lose their colour rather than change it.
vec3 agx(vec3 exposed) {
    const mat3 INSET = mat3(0.8424791, 0.042328242, 0.042375655, 0.0784336, 0.87846864, 0.0784336, 0.079223745, 0.07916613, 0.879143);
    const mat3 OUTSET =
        mat3(1.196879, -0.05289685, -0.052971635, -0.09802088, 1.1519031, -0.09804345, -0.09902974, -0.09896118, 1.1510737);
    const float LEAST = -12.47393;
    const float MOST = 4.026069;
    vec3 x = clamp((log2(max(INSET * exposed, 1e-10)) - LEAST) / (MOST - LEAST), 0.0, 1.0);
    vec3 x2 = x * x;
    vec3 x4 = x2 * x2;
    vec3 y = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    return pow(max(OUTSET * y, 0.0), vec3(2.2));
}

vec3 srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

vec3 shown(vec3 exposed) {
    // Bounded first: squares overflow on very bright lights.
    exposed = min(exposed, 1e4);
    if (frame.tone_map == TONE_ACES) exposed = aces(exposed);
    if (frame.tone_map == TONE_AGX) exposed = agx(exposed);
    return srgb(clamp(exposed, 0.0, 1.0));
}
