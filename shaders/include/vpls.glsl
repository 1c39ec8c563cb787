// The VPLs of one temporal set, sorted by pixel class. Twin: GpuVpl in src/vpl/mod.rs.

struct GpuVpl {
    vec3 position; // on the surface
    uint slot;
    vec3 normal; // of the side that shines
    uint bounce;
    vec3 flux; // phi, W
    uint _pad;
};

// The pixel of a thread of an 8x8 workgroup: all of a group's pixels have the same class, and so the
// same VPLs, which keeps rays coherent. The groups of the n^2 classes of one block of the picture follow
// one another, which keeps the block in the caches. Twin: `class_grid` in src/passes/indirect_shadows.rs.
uvec2 interleaved_pixel(uint n, out uint pixel_class) {
    uint classes = n * n;
    pixel_class = gl_WorkGroupID.x % classes;
    uvec2 block = uvec2(gl_WorkGroupID.x / classes, gl_WorkGroupID.y);
    return (block * 8u + gl_LocalInvocationID.xy) * n + uvec2(pixel_class % n, pixel_class / n);
}
