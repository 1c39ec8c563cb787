// Sampling a VPL for a texel: first a cluster, by the weights of the texel's block, then a VPL of the cluster. Needs clusters.glsl and
// `float cluster_weight(uint place)`, where place is that of a block's first cluster plus a cluster.

// A cluster is sampled in two steps, by runs.
const uint RUN = 8u;
const uint RUNS = CLUSTERS / RUN;

// The weights of the clusters of a block lie run by run.
struct BlockWeights {
    uint first;
    float cumulative[RUNS];
};

BlockWeights weights_from(uint first) {
    BlockWeights weights;
    weights.first = first;
    float sum = 0.0;
    for (uint run = 0u; run < RUNS; run++) {
        for (uint i = 0u; i < RUN; i++) sum += cluster_weight(weights.first + run * RUN + i);
        weights.cumulative[run] = sum;
    }
    return weights;
}

// Samples one of all VPLs: first the cluster, then the VPL.
SampledVpl sample_vpl(BlockWeights weights, Surface surface, float random) {
    float total = weights.cumulative[RUNS - 1u];
    float at = random * total;
    uint run = 0u;
    float below = 0.0;
    for (uint i = 0u; i < RUNS - 1u; i++) {
        bool after = weights.cumulative[i] <= at;
        run += after ? 1u : 0u;
        below = after ? weights.cumulative[i] : below;
    }
    uint chosen = run * RUN;
    float weight = 0.0;
    for (uint i = 0u; i < RUN; i++) {
        float next = cluster_weight(weights.first + run * RUN + i);
        bool here = weight <= 0.0 || below + weight <= at;
        below += here ? weight : 0.0;
        chosen = here ? run * RUN + i : chosen;
        weight = here ? next : weight;
    }
    VplCluster cluster = vpl_clusters.data[vpl.layer * CLUSTERS + chosen];
    if (weight <= 0.0 || cluster.count == 0u) return SampledVpl(0u, 0.0);
    SampledVpl sampled = choose_vpl(cluster, surface, clamp((at - below) / weight, 0.0, 0.9999999));
    sampled.inverse_probability *= total / weight;
    return sampled;
}

// One sample counts for at most this many times the expected unoccluded irradiance.
const float MOST_BROUGHT = 256.0;

// No more than that, where there is a bound at all: an outlier would stay in a history.
vec3 bounded(vec3 brought, BlockWeights weights) {
    if (vpl.geometry_bound == 0.0) return brought;
    float most = MOST_BROUGHT * weights.cumulative[RUNS - 1u];
    return brought * min(1.0, most / max(luminance(brought), 1e-30));
}
