// How threads come by their work: see src/passes/work.rs. Define WORK_BINDING before including. For workgroups of 64 threads
// in one dimension.

layout(set = 0, binding = WORK_BINDING, std430) buffer WorkBlock { uint count; } work_taken;

// Threads of a group. Twin: `GROUP` in src/passes/work.rs.
const uint GROUP = 64u;

// Twin: `Work` there.
struct Work {
    uint groups;  // that there is work for
    uint at_once; // that a thread works for
};

// What a thread does: the part of thread `thread` in each group from `first` on.
struct Share {
    uint first;
    uint end; // behind the last; not after the first if there is nothing to do
    uint thread;
};

Share take_share(Work work) {
    uint number = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * GROUP + gl_LocalInvocationIndex;
    if (work.at_once > 1u) {
        // To look is cheaper than to take.
        if (work_taken.count / GROUP * work.at_once >= work.groups) return Share(0u, 0u, 0u);
        // Threads that run in step mostly take numbers that follow one another, which keeps them together; nothing hangs on it.
        number = atomicAdd(work_taken.count, 1u);
    }
    uint first = number / GROUP * work.at_once;
    return Share(first, min(first + work.at_once, work.groups), number % GROUP);
}
