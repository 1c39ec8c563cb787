// Interleaved sampling (Keller and Heidrich 2001): in each n x n tile every pixel is of another class.

layout(constant_id = 0) const uint INTERLEAVE = 4u; // n
const uint CLASSES = INTERLEAVE * INTERLEAVE;

uint class_of(uvec2 pixel) { return pixel.x % INTERLEAVE + pixel.y % INTERLEAVE * INTERLEAVE; }
