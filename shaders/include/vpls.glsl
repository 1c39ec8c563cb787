// The VPLs of one temporal set, sorted by pixel class. Twin: GpuVpl in src/vpl/mod.rs.

struct GpuVpl {
    vec3 position; // on the surface
    uint slot;
    vec3 normal; // of the side that shines
    uint bounce;
    vec3 flux; // phi, W
    uint _pad;
};
