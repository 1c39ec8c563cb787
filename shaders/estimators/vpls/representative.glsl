// Texels of a set buffer lie `set_step` pixels apart, in both directions. Each stands for one pixel of its own, the
// representative; sets differ in which of the set_step x set_step it is, so that together they have seen every pixel.

// Set buffers are half floats; an infinity would stay in a history.
const float MAX_STORED = 65504.0;

uvec2 set_extent(uvec2 size, uint set_step) { return (size + set_step - 1u) / set_step; }

// The pixel that a texel stands for.
ivec2 representative(ivec2 texel, uint set_step, uvec2 offset, uvec2 size) {
    return min(texel * int(set_step) + ivec2(offset), ivec2(size) - 1);
}
