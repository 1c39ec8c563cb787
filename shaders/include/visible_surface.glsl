// A visible surface in 8 bytes, as denoisers keep it from frame to frame and compare it: view depth and shading normal (octahedral,
// 10 bits each). Needs gbuffer.glsl. Twin of the normal: `packed_shading` in tests/denoise/support.rs.
//
// Its instance lies in an image of its own, r32ui, whole: only reprojection reads it, so that it costs 4 bytes where a surface is written
// and 4 for each texel that is tested, and nothing in the many taps of filters, which read the 8 bytes.

struct VisibleSurface {
    float depth; // along the view; 0 where no surface is
    vec3 normal; // unit, on the side that is seen
};

uvec4 pack_surface(VisibleSurface surface) {
    uint depth = floatBitsToUint(surface.depth);
    uvec2 normal = uvec2((octahedral_encode(surface.normal) * 0.5 + 0.5) * 1023.0 + 0.5);
    uint rest = normal.x | normal.y << 10;
    return uvec4(depth & 0xffffu, depth >> 16, rest & 0xffffu, rest >> 16);
}

VisibleSurface unpack_surface(uvec4 texel) {
    uint rest = texel.z | texel.w << 16;
    vec2 normal = vec2(rest & 1023u, rest >> 10 & 1023u) * (2.0 / 1023.0) - 1.0;
    return VisibleSurface(uintBitsToFloat(texel.x | texel.y << 16), octahedral_decode(normal));
}
