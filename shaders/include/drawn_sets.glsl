// What is known of the sets that were drawn: a texel each, which CPU drivers load for all lanes at once. Define
// DRAWN_SETS_BINDING before including.

layout(set = 0, binding = DRAWN_SETS_BINDING) uniform utextureBuffer drawn_sets;

// Twin: `SetParameters::texel` in src/passes/set_history.rs.
struct SetParameters {
    float scale; // irradiance over what the set buffer holds
    float flux;  // luminous, of the set
    float tan_y; // tangent of half the vertical field of view of the camera that drew it
    uint layer;  // of the set buffers
};

// first_texel: where the list of sets begins.
SetParameters set_at(uint first_texel, uint index) {
    uvec4 texel = texelFetch(drawn_sets, int(first_texel + index));
    return SetParameters(uintBitsToFloat(texel.x), uintBitsToFloat(texel.y), uintBitsToFloat(texel.z), texel.w);
}
