// The window of pixels that the discontinuity filter joins. Needs frame.glsl and interleave.glsl.

// The window is centred on its pixel: for even n it is one pixel wider than n, and both its ends, which are of the same
// class, count for half. Off-centre by half a pixel, it would move steep gradients.
const bool EVEN = INTERLEAVE % 2u == 0u;
const int WIDTH = int(EVEN ? INTERLEAVE + 1u : INTERLEAVE);

float weight_at(int place) { return EVEN && (place == 0 || place == WIDTH - 1) ? 0.5 : 1.0; }

// First pixel of a window: moved inside at the borders, it still holds every class once.
ivec2 corner_of(ivec2 pixel) { return clamp(pixel - WIDTH / 2, ivec2(0), max(ivec2(frame.size) - WIDTH, ivec2(0))); }

// Pixels, one below the other, of which each thread takes care: a texel lies in the windows of several, and much of its
// cost is to load and unpack it. Twin: `ROWS` in src/passes/indirect_shading.rs.
const int ROWS = 4;

// Which pixels of a window lie on its centre's surface: a bit each, whole rows of the window to a word. Twin: `words` in
// src/passes/indirect_shading.rs.
const int ROWS_IN_WORD = 32 / WIDTH;
const int WORDS = (WIDTH + ROWS_IN_WORD - 1) / ROWS_IN_WORD;
// For n up to 8: arrays in structures are not sized by what is known only when a pipeline is made.
const int MOST_WORDS = 3;

int threads_down() { return (int(frame.size.y) + ROWS - 1) / ROWS; }

// The nearest thread with pixels of the picture.
ivec2 thread_inside(ivec2 thread) { return min(thread, ivec2(int(frame.size.x), threads_down()) - 1); }

// The texel with a word of each of a thread's pixels.
int word_texel(ivec2 thread, int word) {
    return (word * threads_down() + thread.y) * int(frame.size.x) + thread.x;
}

// A row of texels, as the windows of a thread's pixels see it.
struct Row {
    uvec4 same;   // bits of the texels that lie on the surface of each centre; none outside of its window
    vec4 weights; // of the whole row in each window
};

// words: of the pixels; corner_y: of their windows; y: of the row.
Row row_at(uvec4 words[MOST_WORDS], ivec4 corner_y, int y) {
    // Windows outside of which the row lies have their places before or after their rows: as unsigned, after them.
    uvec4 places = uvec4(y - corner_y);
    uvec4 same = words[0] >> (places * uint(WIDTH) & 31u);
    [[unroll]] for (int word = 1; word < WORDS; word++) {
        uvec4 in_word = words[word] >> ((places - uint(word * ROWS_IN_WORD)) * uint(WIDTH) & 31u);
        same = mix(same, in_word, greaterThanEqual(places, uvec4(word * ROWS_IN_WORD)));
    }
    same = mix(uvec4(0u), same & ((1u << WIDTH) - 1u), lessThan(places, uvec4(WIDTH)));
    bvec4 ends = bvec4(uvec4(equal(places, uvec4(0u))) | uvec4(equal(places, uvec4(WIDTH - 1))));
    return Row(same, EVEN ? mix(vec4(1.0), vec4(0.5), ends) : vec4(1.0));
}

// Notes in the words which texels of a row lie on the surface of each centre, and so have a bit in `same`.
void note_row(inout uvec4 words[MOST_WORDS], ivec4 corner_y, int y, uvec4 same) {
    uvec4 places = uvec4(y - corner_y);
    same = mix(uvec4(0u), same, lessThan(places, uvec4(WIDTH)));
    [[unroll]] for (int word = 0; word < WORDS; word++) {
        uvec4 in_word = places - uint(word * ROWS_IN_WORD);
        words[word] |= mix(uvec4(0u), same << (in_word * uint(WIDTH) & 31u), lessThan(in_word, uvec4(ROWS_IN_WORD)));
    }
}

// How much a texel of the row counts in each window. weight: of its column.
vec4 shares_at(Row row, int column, float weight) {
    bvec4 counts = notEqual(row.same & (1u << column), uvec4(0u));
    return mix(vec4(0.0), weight * row.weights, counts);
}
