// The window of pixels that the discontinuity filter joins, and which of them lie on the surface of its centre.
// Needs frame.glsl, gbuffer.glsl, packed_surface.glsl, interleave.glsl, `gbuffer_normal` and `packed_surfaces`.

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

// The texel with a word of each of a thread's pixels.
int word_texel(ivec2 thread, int word) {
    int threads_down = (int(frame.size.y) + ROWS - 1) / ROWS;
    return (word * threads_down + thread.y) * int(frame.size.x) + thread.x;
}

const float MIN_NORMAL_COSINE = 0.9;

// What a pixel must agree with to count, in scaled depths: plane distance is depth * dot(slope, (x, y, 1)) - offset, since
// positions are linear in pixel coordinates and depth.
struct Surface {
    vec3 shading;
    vec3 slope;
    float offset;
    float tolerance;
};

Surface surface_at(ivec2 pixel, float depth) {
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    vec3 geometric = octahedral_decode(normals.zw);
    vec2 step = 2.0 / vec2(frame.size);
    vec3 slope = vec3(dot(geometric, frame.ray_x.xyz) * step.x, dot(geometric, frame.ray_y.xyz) * step.y, 0.0);
    slope.z = dot(geometric, frame.ray.xyz - frame.ray_x.xyz - frame.ray_y.xyz) + 0.5 * (slope.x + slope.y);
    float offset = depth * dot(slope, vec3(pixel, 1.0));
    return Surface(octahedral_decode(normals.xy), slope, offset, 0.25 * frame.position_cutoff * depth);
}

// Twin: `same_surfaces` in discontinuities.comp, for four centres at once.
bool same_surface(Surface surface, uint packed, ivec2 at) {
    vec3 normal = unpack_normal(packed);
    float distance = unpack_depth(packed) * dot(surface.slope, vec3(at, 1.0)) - surface.offset;
    bool alike = dot(normal, surface.shading) >= MIN_NORMAL_COSINE * length(normal);
    return is_surface(packed) && alike && abs(distance) <= surface.tolerance;
}

// Pixels outside of the picture, which one that is smaller than the window has, lie on no surface.
uint packed_at(ivec2 at) {
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(frame.size)));
    return inside ? texelFetch(packed_surfaces, at.y * int(frame.size.x) + at.x).r : 0u;
}
