// Counts rays into 64-bit sums, low word first: a subgroup adds once, and workgroups take turns at the sums, so that they seldom meet at
// one. Define RAY_COUNTER_BINDING before including. Twin: RAY_COUNTERS in src/estimators/ray_counters.rs.
#extension GL_KHR_shader_subgroup_arithmetic : require

const uint RAY_COUNTERS = 32u;

layout(set = 0, binding = RAY_COUNTER_BINDING, std430) buffer RayCounterBlock { uvec2 rays[RAY_COUNTERS]; } ray_counters;

void count_rays(uint rays) {
    uint all = subgroupAdd(rays);
    if (!subgroupElect() || all == 0u) return;
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) % RAY_COUNTERS;
    if (atomicAdd(ray_counters.rays[i].x, all) > 0xffffffffu - all) atomicAdd(ray_counters.rays[i].y, 1u);
}
