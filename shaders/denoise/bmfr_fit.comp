#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// BMFR's fit (Koskela et al. 2019, section 4.3): in each block of 32 x 32 texels the linear combination of features that is nearest to
// the noisy signal, by Householder's QR factorisation. Each thread keeps its rows of the matrix in registers; only sums over rows go
// through shared memory. In: the accumulated signal and the surfaces. Out: the fitted signal; a: frames, as in the signal.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"

layout(local_size_x = 256) in;

// Columns of the matrix, without the three of the signal.
layout(constant_id = 0) const uint FEATURES = 10u;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2D signal;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D fitted;
#include "surface.glsl"
#include "bmfr_features.glsl"

layout(push_constant) uniform Push {
    ivec2 offset; // of the first block, texels
    int pixels;   // of the picture, from one texel of the signal to the next
} push;

const uint SIDE = 32u;
const uint THREADS = 256u;
const uint TEXELS = SIDE * SIDE / THREADS; // of a thread
const uint ROWS = TEXELS + 1u;             // and one that keeps a weight small
const uint COLUMNS = FEATURES + 3u;
// Columns may repeat others. Koskela et al. add noise to the features; its expectation is a penalty on the squared weights (Tikhonov),
// here for each texel, which does not flicker.
const float PENALTY = 1e-6;
// Diagonals shorter than this determine nothing.
const float SINGULAR = 1e-6;
const uint MOST_SUBGROUPS = 64u;
// Columns that are summed at once.
const uint CHUNK = 16u;

shared float partial[CHUNK * MOST_SUBGROUPS];
shared float sums[COLUMNS];
shared float pivot[COLUMNS];
shared vec3 solved[FEATURES];
shared vec4 low_partial[MOST_SUBGROUPS];
shared vec4 high_partial[MOST_SUBGROUPS];
shared float valid_partial[MOST_SUBGROUPS];

// A row of the matrix: a texel of the block.
struct Row {
    ivec2 texel;
    bool is_valid; // a surface is seen there
    FeatureInputs at;
};

Row row_of(uint row) {
    Row result;
    ivec2 block = ivec2(gl_WorkGroupID.xy) * int(SIDE) + push.offset;
    result.texel = block + ivec2(row % SIDE, row / SIDE);
    ivec2 pixel = result.texel * push.pixels;
    bool is_inside = all(greaterThanEqual(result.texel, ivec2(0))) && all(lessThan(result.texel, imageSize(signal)));
    result.is_valid = is_inside && imageLoad(gbuffer_depth, pixel).r > 0.0;
    if (!result.is_valid) return result;
    Surface surface = surface_at(pixel);
    vec3 from_eye = surface.position - frame.eye.xyz;
    result.at = FeatureInputs(surface.shading, vec4(from_eye, length(from_eye)), imageLoad(gbuffer_albedo, pixel));
    return result;
}

// The rows of a thread, and what they are in the matrix.
Row rows[TEXELS];
float a[ROWS][COLUMNS];

// The least and the greatest place of all texels, and how many show a surface.
void find_bounds(out vec4 low, out vec4 high, out float valid) {
    valid = 0.0;
    low = vec4(1e30);
    high = vec4(-1e30);
    for (uint i = 0u; i < TEXELS; i++) {
        if (!rows[i].is_valid) continue;
        low = min(low, rows[i].at.place);
        high = max(high, rows[i].at.place);
        valid += 1.0;
    }
    low = subgroupMin(low);
    high = subgroupMax(high);
    valid = subgroupAdd(valid);
    if (subgroupElect()) {
        low_partial[gl_SubgroupID] = low;
        high_partial[gl_SubgroupID] = high;
        valid_partial[gl_SubgroupID] = valid;
    }
    barrier();
    valid = 0.0;
    for (uint i = 0u; i < gl_NumSubgroups; i++) {
        low = min(low, low_partial[i]);
        high = max(high, high_partial[i]);
        valid += valid_partial[i];
    }
}

// Sums over all rows of the products of column k with the columns from k on, from row k on, to `sums`.
void sum_products(uint k) {
    uint thread = gl_LocalInvocationIndex;
    for (uint first = k; first < COLUMNS; first += CHUNK) {
        uint end = min(first + CHUNK, COLUMNS);
        for (uint j = first; j < end; j++) {
            float sum = 0.0;
            for (uint i = 0u; i < ROWS; i++) sum += i > 0u || thread >= k ? a[i][k] * a[i][j] : 0.0;
            sum = subgroupAdd(sum);
            if (subgroupElect()) partial[(j - first) * MOST_SUBGROUPS + gl_SubgroupID] = sum;
        }
        barrier();
        if (thread < end - first) {
            float sum = 0.0;
            for (uint i = 0u; i < gl_NumSubgroups; i++) sum += partial[thread * MOST_SUBGROUPS + i];
            sums[first + thread] = sum;
        }
        barrier();
    }
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    for (uint i = 0u; i < TEXELS; i++) rows[i] = row_of(i * THREADS + thread);
    vec4 low, high;
    float valid;
    find_bounds(low, high, valid);
    float penalty = sqrt(PENALTY * valid);
    vec4 scale = 2.0 / max(high - low, vec4(1e-20));

    // The matrix; rows without a surface are 0 and determine nothing.
    for (uint i = 0u; i < TEXELS; i++) {
        rows[i].at.place = clamp((rows[i].at.place - low) * scale - 1.0, -1.0, 1.0);
        vec3 light = rows[i].is_valid ? imageLoad(signal, rows[i].texel).rgb : vec3(0.0);
        for (uint j = 0u; j < FEATURES; j++) {
            a[i][j] = rows[i].is_valid ? feature_of(j, rows[i].at) : 0.0;
        }
        for (uint c = 0u; c < 3u; c++) a[i][FEATURES + c] = light[c];
    }
    for (uint j = 0u; j < COLUMNS; j++) a[TEXELS][j] = j == thread && j < FEATURES && code_of(j) != 0u ? penalty : 0.0;

    // Column by column, a reflection takes what lies below the diagonal to 0 (Golub and Van Loan 2013, section 5.2).
    for (uint k = 0u; k < FEATURES; k++) {
        if (thread == k) {
            for (uint j = k; j < COLUMNS; j++) pivot[j] = a[0][j];
        }
        sum_products(k);
        float first = pivot[k];
        float norm = sqrt(sums[k]);
        // The sign avoids cancellation.
        float diagonal = first > 0.0 ? -norm : norm;
        float squared = sums[k] - first * diagonal; // half the squared length of the reflection's vector
        if (squared > 0.0) {
            for (uint j = k + 1u; j < COLUMNS; j++) {
                float factor = (sums[j] - diagonal * pivot[j]) / squared;
                for (uint i = 0u; i < ROWS; i++) {
                    if (i == 0u && thread == k) a[i][j] -= factor * (first - diagonal);
                    else if (i > 0u || thread > k) a[i][j] -= factor * a[i][k];
                }
            }
            if (thread == k) a[0][k] = diagonal;
        }
        barrier();
    }

    // Back-substitution: thread k has row k of the triangle.
    for (uint step = 0u; step < FEATURES; step++) {
        uint k = FEATURES - 1u - step;
        if (thread == k) {
            vec3 right = vec3(a[0][FEATURES], a[0][FEATURES + 1u], a[0][FEATURES + 2u]);
            solved[k] = abs(a[0][k]) > SINGULAR ? right / a[0][k] : vec3(0.0);
        }
        barrier();
        if (thread < k) {
            for (uint c = 0u; c < 3u; c++) a[0][FEATURES + c] -= a[0][k] * solved[k][c];
        }
    }

    // The sum of the features without noise.
    for (uint i = 0u; i < TEXELS; i++) {
        ivec2 texel = rows[i].texel;
        if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, imageSize(signal)))) continue;
        vec4 light = imageLoad(signal, texel);
        if (rows[i].is_valid) {
            light.rgb = vec3(0.0);
            for (uint j = 0u; j < FEATURES; j++) light.rgb += feature_of(j, rows[i].at) * solved[j];
        }
        imageStore(fitted, texel, storable(max(light, 0.0)));
    }
}
