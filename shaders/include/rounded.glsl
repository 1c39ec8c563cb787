// Light in images of half floats.

#ifndef ROUNDED_GLSL
#define ROUNDED_GLSL

// Most that a half float holds.
const float MOST_HALF = 65504.0;

// The nearest half float, so that images round nothing: drivers may round towards zero, which darkens what is blended often.
vec4 rounded(vec4 light) {
    uvec4 bits = floatBitsToUint(light);
    return uintBitsToFloat(bits + 0xfffu + (bits >> 13 & 1u) & 0xffffe000u);
}

// Light as images hold it: the nearest half float, none of them infinite. NaN becomes 0.
vec4 storable(vec4 light) { return rounded(min(mix(light, vec4(0.0), isnan(light)), MOST_HALF)); }

#endif
