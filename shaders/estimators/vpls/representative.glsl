// Texels of a set buffer lie `set_step` pixels apart, in both directions. Each stands for one pixel of its own, the
// representative; sets differ in which of the set_step x set_step it is, so that together they have seen every pixel.

// Most irradiance, scaled, that a texel holds: an infinity would stay in a history.
const float MAX_STORED = 65408.0;

// A texel: irradiance as three mantissas of 9 bits and their exponent (Ward 1991; Vulkan's E5B9G9R9), then all bits of the depth.
uvec4 pack_texel(vec3 irradiance, float depth) {
    irradiance = clamp(irradiance, 0.0, MAX_STORED);
    float largest = max(max(irradiance.r, irradiance.g), irradiance.b);
    int exponent = clamp(int(floor(log2(max(largest, 1e-30)))) + 1, -15, 16);
    // Rounding may reach the next power of two.
    if (largest * exp2(float(9 - exponent)) >= 511.5) exponent = min(exponent + 1, 16);
    uvec3 mantissas = min(uvec3(irradiance * exp2(float(9 - exponent)) + 0.5), uvec3(511u));
    uint packed = mantissas.r | mantissas.g << 9 | mantissas.b << 18 | uint(exponent + 15) << 27;
    uint bits = floatBitsToUint(depth);
    return uvec4(packed & 0xffffu, packed >> 16, bits & 0xffffu, bits >> 16);
}

// rgb: irradiance; a: depth.
vec4 unpack_texel(uvec4 texel) {
    uint packed = texel.x | texel.y << 16;
    vec3 mantissas = vec3(uvec3(packed, packed >> 9, packed >> 18) & 511u);
    return vec4(mantissas * exp2(float(packed >> 27) - 24.0), uintBitsToFloat(texel.z | texel.w << 16));
}

uvec2 set_extent(uvec2 size, uint set_step) { return (size + set_step - 1u) / set_step; }

// The pixel that a texel stands for.
ivec2 representative(ivec2 texel, uint set_step, uvec2 offset, uvec2 size) {
    return min(texel * int(set_step) + ivec2(offset), ivec2(size) - 1);
}
