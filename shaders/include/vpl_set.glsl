// The VPLs of the frame's set, by pixel class: a texel for each class, then three for each VPL. Needs vpls.glsl. Twin:
// UploadedSet in src/passes/indirect_shadows.rs.
//
// Define VPL_SET_BINDING before including. Texels, since CPU drivers load those of all lanes at once.

layout(set = 0, binding = VPL_SET_BINDING) uniform utextureBuffer vpl_set;

struct VplClass {
    uint first; // VPL
    uint end;
    float flux; // luminous, over all sets
};

// first_texel: where the set begins.
VplClass vpl_class(uint first_texel, uint index) {
    uvec4 texel = texelFetch(vpl_set, int(first_texel + index));
    return VplClass(texel.x, texel.y, uintBitsToFloat(texel.z));
}

// Luminous flux of the class of a pixel.
float flux_at(uint first_texel, ivec2 pixel) { return vpl_class(first_texel, class_of(uvec2(pixel))).flux; }

GpuVpl vpl_at(uint first_texel, uint index) {
    int at = int(first_texel + INTERLEAVE * INTERLEAVE + 3u * index);
    uvec4 a = texelFetch(vpl_set, at);
    uvec4 b = texelFetch(vpl_set, at + 1);
    uvec4 c = texelFetch(vpl_set, at + 2);
    return GpuVpl(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), c.w);
}
