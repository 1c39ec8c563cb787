// A visible surface in 8 bytes, as denoisers keep it from frame to frame and compare it: view depth, shading normal (octahedral,
// 10 bits each) and the low 12 bits of the instance. Needs gbuffer.glsl. Twin of the normal: `packed_shading` in tests/denoise/support.rs.

struct VisibleSurface {
    float depth; // along the view; 0 where no surface is
    vec3 normal; // unit, on the side that is seen
    uint instance;
};

uvec4 pack_surface(VisibleSurface surface) {
    uint depth = floatBitsToUint(surface.depth);
    uvec2 normal = uvec2((octahedral_encode(surface.normal) * 0.5 + 0.5) * 1023.0 + 0.5);
    uint rest = normal.x | normal.y << 10 | surface.instance << 20;
    return uvec4(depth & 0xffffu, depth >> 16, rest & 0xffffu, rest >> 16);
}

VisibleSurface unpack_surface(uvec4 texel) {
    uint rest = texel.z | texel.w << 16;
    vec2 normal = vec2(rest & 1023u, rest >> 10 & 1023u) * (2.0 / 1023.0) - 1.0;
    return VisibleSurface(uintBitsToFloat(texel.x | texel.y << 16), octahedral_decode(normal), rest >> 20);
}
