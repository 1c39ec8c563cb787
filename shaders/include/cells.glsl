// A hash map of cells of space on the device (Meijer 2019, after Binder et al. 2018): a key of quantised position, level of detail and
// normal, hashed twice, to the slot where probing begins and to the word that verifies it; sums by 32-bit atomics in fixed point, whose
// result does not depend on their order. Twin: tests/device/cells.rs.

// Words of a slot: the low and the high words of red, green and blue, and the number of samples.
const uint SUM_WORDS = 8u;
const uint SUM_HIGH = 3u;
const uint SUM_COUNT = 6u;
// Sums are in these parts of 1 W/m^2; a high word counts 2^32 of them.
const float QUANTA = 268435456.0;
const float HIGH = 16.0;
const float MOST_LOW = 4294967040.0;
// Most that a sample adds, W/m^2.
const float MOST_SAMPLE = 1e9;

struct CellKey {
    uint index;        // the slot where probing begins, before the capacity
    uint verification; // not 0
};

// Wang's hash of 32 bits.
uint wang(uint x) {
    x = (x ^ 61u) ^ (x >> 16u);
    x *= 9u;
    x ^= x >> 4u;
    x *= 0x27d4eb2du;
    return x ^ (x >> 15u);
}

// Marsaglia's xorshift, of what is not 0.
uint xorshift(uint x) {
    x += 0x9e3779b9u;
    if (x == 0u) x = 1u;
    x ^= x << 13u;
    x ^= x >> 17u;
    return x ^ (x << 5u);
}

// The power of two at or below a width, as its exponent.
int level_of(float width) { return clamp(int(floatBitsToUint(width) >> 23u & 255u) - 127, -64, 63); }

float width_of(int level) { return uintBitsToFloat(uint(level + 127) << 23u); }

// The cell's place in the grid of its level; beyond 2^30 cells from the origin all lie in the last.
ivec3 place_of(vec3 position, int level) {
    return ivec3(clamp(floor(position * width_of(-level)), vec3(-1073741824.0), vec3(1073741824.0)));
}

// On which sides of so many planes through the origin a normal lies. Opposite normals differ in each bit; the planes avoid the axes.
uint normal_bits(vec3 normal, uint bits) {
    uint sides = (dot(normal, vec3(0.80, 0.51, 0.33)) >= 0.0 ? 1u : 0u) | (dot(normal, vec3(-0.45, 0.83, 0.31)) >= 0.0 ? 2u : 0u)
        | (dot(normal, vec3(0.29, -0.41, 0.86)) >= 0.0 ? 4u : 0u) | (dot(normal, vec3(0.55, 0.57, -0.61)) >= 0.0 ? 8u : 0u);
    return sides & ((1u << bits) - 1u);
}

// `in_index`: whether the normal also decides where probing begins; otherwise cells of one place lie side by side.
CellKey key_of(ivec3 place, int level, uint normal, bool in_index) {
    uvec3 q = uvec3(place);
    uint l = uint(level);
    uint index = wang(q.z);
    index = wang(index + q.x);
    if (in_index) index = wang(index + normal);
    index = wang(index + q.y);
    index = wang(index + l);
    if (!in_index) index &= ~15u;
    uint verification = xorshift(q.z);
    verification = xorshift(verification + q.x);
    verification = xorshift(verification + normal);
    verification = xorshift(verification + q.y);
    verification = xorshift(verification + l);
    return CellKey(index, max(verification, 1u));
}
