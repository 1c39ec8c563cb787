// How the G-buffer is packed: normals octahedral, two components each (Cigolle et al. 2014).

vec2 octahedral_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : folded;
}

vec3 octahedral_decode(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}

// A vertex's tangent: octahedral, 16 and 15 bits, then a bit for the other side of the bitangent; 0: none. w: that side, 1 or -1.
vec4 unpack_tangent(uint packed) {
    if (packed == 0u) return vec4(0.0);
    vec2 place = vec2(packed & 0xffffu, packed >> 16 & 0x7fffu) / vec2(65535.0, 32767.0) * 2.0 - 1.0;
    return vec4(octahedral_decode(place), (packed & 0x80000000u) == 0u ? 1.0 : -1.0);
}

// The G-buffer's surface channels. x: base colour (its root, so that dark colours are as fine as eyes are) and metallic, 8
// bits each; y: emission. Roughness is the alpha of its albedo.
uint pack_base(vec3 base, float metallic) { return packUnorm4x8(vec4(sqrt(base), metallic)); }

// rgb: base colour; a: metallic.
vec4 unpack_base(uint packed) {
    vec4 texel = unpackUnorm4x8(packed);
    return vec4(texel.rgb * texel.rgb, texel.a);
}

// Three mantissas of 9 bits and their exponent (Ward 1991; Vulkan's E5B9G9R9), rounded to nearest.
uint pack_emission(vec3 radiance) {
    float largest = max(radiance.r, max(radiance.g, radiance.b));
    if (!(largest > 0.0)) return 0u;
    int exponent = clamp(int(floor(log2(largest))) + 1, -15, 16);
    if (largest * exp2(float(9 - exponent)) >= 511.5) exponent = min(exponent + 1, 16);
    uvec3 mantissas = min(uvec3(radiance * exp2(float(9 - exponent)) + 0.5), uvec3(511u));
    return mantissas.r | mantissas.g << 9 | mantissas.b << 18 | uint(exponent + 15) << 27;
}

vec3 unpack_emission(uint packed) {
    vec3 mantissas = vec3(uvec3(packed, packed >> 9, packed >> 18) & 511u);
    return mantissas * exp2(float(packed >> 27) - 24.0);
}

// Bits of the G-buffer's material channel: the front side of the surface is seen.
const uint FRONT_FACING = 0x80000000u;
const uint MATERIAL = 0x7fffffffu;
