// Texels of a set buffer lie `set_step` pixels apart, in both directions. Each stands for one pixel of its own, the
// representative; sets differ in which of the set_step x set_step it is, so that together they have seen every pixel.

// Most irradiance, scaled, that a texel holds: an infinity would stay in a history.
const float MAX_STORED = 65408.0;

// Longest history that a texel counts: the low bits of the depth, which leaves that 18 bits of mantissa.
const uint MAX_HISTORY = 31u;

// A texel: irradiance as three mantissas of 9 bits and their exponent (Ward 1991; Vulkan's E5B9G9R9), then the depth and the
// history length: how many turns of the set the irradiance is the mean of. `random` rounds up: 0.5 to nearest; a mean over many turns
// changes by less than a step, and takes random numbers.
uvec4 pack_texel(vec3 irradiance, float depth, float history_length, vec3 random) {
    irradiance = clamp(irradiance, 0.0, MAX_STORED);
    float largest = max(max(irradiance.r, irradiance.g), irradiance.b);
    int exponent = clamp(int(floor(log2(max(largest, 1e-30)))) + 1, -15, 16);
    // Rounding may reach the next power of two.
    if (largest * exp2(float(9 - exponent)) >= 511.0) exponent = min(exponent + 1, 16);
    uvec3 mantissas = min(uvec3(irradiance * exp2(float(9 - exponent)) + random), uvec3(511u));
    uint packed = mantissas.r | mantissas.g << 9 | mantissas.b << 18 | uint(exponent + 15) << 27;
    uint bits = floatBitsToUint(depth) & ~MAX_HISTORY;
    if (depth > 0.0) bits |= min(uint(history_length + 0.5), MAX_HISTORY);
    return uvec4(packed & 0xffffu, packed >> 16, bits & 0xffffu, bits >> 16);
}

// rgb: irradiance; a: depth.
vec4 unpack_texel(uvec4 texel) {
    uint packed = texel.x | texel.y << 16;
    vec3 mantissas = vec3(uvec3(packed, packed >> 9, packed >> 18) & 511u);
    return vec4(mantissas * exp2(float(packed >> 27) - 24.0), uintBitsToFloat((texel.z | texel.w << 16) & ~MAX_HISTORY));
}

// A depth whose low bits hold a share from 0 to 1.
float depth_with_share(float depth, float share) {
    uint bits = floatBitsToUint(depth) & ~MAX_HISTORY;
    return uintBitsToFloat(depth > 0.0 ? bits | uint(clamp(share, 0.0, 1.0) * float(MAX_HISTORY) + 0.5) : 0u);
}

float share_in(float depth) { return float(floatBitsToUint(depth) & MAX_HISTORY) / float(MAX_HISTORY); }

float history_length_of(uvec4 texel) { return float(texel.z & MAX_HISTORY); }

uvec2 set_extent(uvec2 size, uint set_step) { return (size + set_step - 1u) / set_step; }

// The pixel that a texel stands for.
ivec2 representative(ivec2 texel, uint set_step, uvec2 offset, uvec2 size) {
    return min(texel * int(set_step) + ivec2(offset), ivec2(size) - 1);
}
