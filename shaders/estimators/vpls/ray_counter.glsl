// Counts rays into 64-bit sums, low word first; workgroups take turns at them, so that they seldom meet at one.
// Define RAY_COUNTER_BINDING before including. Twin: RAY_COUNTERS in src/estimators/vpls/vpl_buffer.rs.

const uint RAY_COUNTERS = 32u;

layout(set = 0, binding = RAY_COUNTER_BINDING, std430) buffer RayCounterBlock { uvec2 rays[RAY_COUNTERS]; } ray_counters;

void count_rays(uint rays) {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) % RAY_COUNTERS;
    if (rays == 0u) return;
    if (atomicAdd(ray_counters.rays[i].x, rays) > 0xffffffffu - rays) atomicAdd(ray_counters.rays[i].y, 1u);
}
