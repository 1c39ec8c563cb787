// The VPLs of the set in clusters of neighbours, and choosing within one. Needs gather.glsl and representative.glsl.
// Define CLUSTERS_BINDING before including. Twins: VplCluster in src/estimators/vpls/clusters.rs,
// SamplingPush, TILE in src/estimators/vpls/indirect_shadows.rs.
#include "reservoir.glsl"

struct VplCluster {
    vec3 position;    // mean by flux; at infinity that of the directions
    float radius;     // root mean square of the distance from there, by flux
    vec3 normal;      // mean by flux: the shorter, the more the normals differ
    float flux;       // luminous; at infinity luminous irradiance
    uint first;       // VPL, counted from the set's first
    uint count;
    uint at_infinity; // 1: its VPLs lie there
    uint pad;
};

const uint CLUSTERS = 64u;
const uint TILE = 16u; // texels in each direction that share what they see
const uint BLOCK = 8u; // and that share the weights of the clusters

layout(set = 0, binding = CLUSTERS_BINDING, std430) readonly buffer ClusterBlock { VplCluster data[]; } vpl_clusters;
// The samples that a dispatch takes.
struct SamplingPush {
    uvec2 tiles;
    uint set_step;   // pixels from one texel of the set buffers to the next
    uint first_sample; // of this dispatch
    uint end_sample;
    uint samples;    // over all dispatches; 0: gather every VPL from first_sample to end_sample
    float set_share; // of the light, that a set holds
    uint spread;     // of bias_compensation.comp
};
layout(push_constant) uniform Push { SamplingPush data; } push_constants;
SamplingPush push = push_constants.data;

uint weight_index(uvec2 block, uint cluster) {
    uint columns = push.tiles.x * (TILE / BLOCK) + 1u;
    return (block.y * columns + block.x) * CLUSTERS + cluster;
}

// Multiples of irrational numbers by the cycle's number, modulo 1: exact whatever that is.
float cycle_shift(uint dimension) {
    const uint STEPS[4] = uint[](0x9e3779b9u, 0x6a09e667u, 0xbb67ae85u, 0x3c6ef373u);
    return float(vpl.cycle * STEPS[dimension % 4u] >> 8u) * exp2(-24.0);
}

// A number in [0, 1) for each texel, well spread among neighbours (the R2 sequence of Roberts 2018), over sets, cycles and uses.
float shift_of(uvec2 texel, uint use) {
    float spread = dot(vec2(texel), vec2(0.7548776662, 0.5698402910)) + 0.6180339887 * float(vpl.layer);
    return fract(spread + 0.41421356 * float(use) + cycle_shift(use));
}

// How far the blocks lie before the first texel: elsewhere in each set and turn, so that their edges are not seen.
ivec2 block_offset() { return ivec2(uvec2(3u, 5u) * vpl.layer + uvec2(5u, 2u) * vpl.cycle) % int(BLOCK); }

uvec2 block_of(uvec2 texel) { return (texel + uvec2(block_offset())) / BLOCK; }

// Approximates the unoccluded irradiance of a surface by a cluster. Never zero, as one of its VPLs may light the surface.
float importance(VplCluster cluster, Surface surface) {
    if (cluster.at_infinity != 0u) {
        return cluster.flux * clamp(dot(surface.shading, cluster.position) + cluster.radius, 0.05, 1.0);
    }
    vec3 d = cluster.position - surface.position;
    float inverse = 1.0 / (dot(d, d) + cluster.radius * cluster.radius + 1e-20);
    float inverse_length = sqrt(inverse);
    float arrives = clamp((dot(surface.shading, d) + cluster.radius) * inverse_length, 0.05, 1.0);
    float leaves = clamp((0.5 * cluster.radius - dot(cluster.normal, d)) * inverse_length, 0.1, 1.0);
    float bound = vpl.geometry_bound;
    return cluster.flux / PI * arrives * leaves * (bound > 0.0 ? min(inverse, bound) : inverse);
}

// VPLs of a cluster among which one is chosen; of larger clusters every so many.
const uint MOST_CHOICES = 8u;

// A VPL, counted from the set's first, and one over its probability; 0: it sends no light.
struct SampledVpl {
    uint index;
    float inverse_probability;
};

// Samples one VPL of a cluster, by its unoccluded irradiance at the surface.
SampledVpl choose_vpl(VplCluster cluster, Surface surface, float random) {
    uint stride = (cluster.count + MOST_CHOICES - 1u) / MOST_CHOICES;
    float at = random * float(stride);
    Reservoir reservoir = new_reservoir(fract(at));
    for (uint i = min(uint(at), stride - 1u); i < cluster.count; i += stride) {
        GpuVpl light = vpls.data[vpl.first_vpl + cluster.first + i];
        update(reservoir, cluster.first + i, luminance(unshadowed_irradiance(light, surface)));
    }
    return SampledVpl(reservoir.selected, reservoir.weight > 0.0 ? float(stride) * reservoir.sum / reservoir.weight : 0.0);
}
