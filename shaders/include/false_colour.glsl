// Colours that stand for numbers.
#include "pi.glsl"

// Neighbouring numbers get colours far apart: their hues go on by the golden ratio.
vec3 number_colour(uint number) {
    float hue = fract(float(number) * 0.618034);
    return 0.55 + 0.45 * cos(2.0 * PI * (vec3(hue) + vec3(0.0, 1.0, 2.0) / 3.0));
}

// From black over blue and green to yellow.
vec3 share_colour(float share) {
    vec3 low = mix(vec3(0.0, 0.0, 0.05), vec3(0.15, 0.2, 0.75), clamp(share * 3.0, 0.0, 1.0));
    vec3 middle = mix(low, vec3(0.1, 0.65, 0.45), clamp(share * 3.0 - 1.0, 0.0, 1.0));
    return mix(middle, vec3(1.0, 0.92, 0.2), clamp(share * 3.0 - 2.0, 0.0, 1.0));
}
