// The surface of a pixel in 32 bits, so that the filter reads one texel a neighbour: view depth as half
// float, shading normal as two octahedral bytes. Both are finer than what the filter tells apart.

uint pack_surface(float depth, vec2 octahedral_normal) {
    return packHalf2x16(vec2(depth * frame.depth_scale, 0.0)) | packSnorm4x8(vec4(0.0, 0.0, octahedral_normal));
}

bool is_surface(uint surface) { return (surface & 0xffffu) != 0u; }

// Scaled by frame.depth_scale; 0 where no surface is.
float unpack_depth(uint surface) { return unpackHalf2x16(surface & 0xffffu).x; }

// Of any length.
vec3 unpack_normal(uint surface) {
    vec2 p = vec2(ivec2(surface << 8, surface) >> 24);
    vec3 n = vec3(p, 127.0 - abs(p.x) - abs(p.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return n;
}
