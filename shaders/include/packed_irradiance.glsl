// The irradiance of a pixel from the VPLs of its class in two words: each channel without its sign and the lower ten bits of
// its mantissa, off by at most 2^-14, a quarter of what the set buffers' half floats are.

const uint DROPPED_BITS = 10u;

uvec2 pack_irradiance(vec3 irradiance) {
    uvec3 bits = (floatBitsToUint(irradiance) + (1u << (DROPPED_BITS - 1u))) >> DROPPED_BITS;
    return uvec2(bits.r << 11 | bits.g >> 10, bits.g << 22 | bits.b);
}

vec3 unpack_irradiance(uvec2 words) {
    uint green = (words.x & 0x7ffu) << 10 | words.y >> 22;
    return uintBitsToFloat(uvec3(words.x >> 11, green, words.y & 0x1fffffu) << DROPPED_BITS);
}
