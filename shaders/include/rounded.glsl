// The nearest half float, so that images round nothing: drivers may round towards zero, which darkens what is blended often.
vec4 rounded(vec4 light) {
    uvec4 bits = floatBitsToUint(light);
    return uintBitsToFloat(bits + 0xfffu + (bits >> 13 & 1u) & 0xffffe000u);
}
