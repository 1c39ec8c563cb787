// The VPLs of one temporal set, sorted by pixel class. Twin: GpuVpl in src/vpl/mod.rs.

struct GpuVpl {
    vec3 position; // on the surface
    uint slot;
    vec3 normal; // of the side that shines
    uint bounce;
    vec3 flux; // phi, W
    uint _pad;
};

// The pixel of class (x, y) in tile (gx, gy), for a thread grid whose z is the class: threads of one
// workgroup share a class and so their VPLs, which keeps rays coherent.
uvec2 interleaved_pixel(uvec3 thread, uint n) {
    return thread.xy * n + uvec2(thread.z % n, thread.z / n);
}
