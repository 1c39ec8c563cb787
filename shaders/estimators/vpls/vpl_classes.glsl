// The VPLs of the frame's set by pixel class. Needs vpls.glsl and interleave.glsl. Define VPL_CLASSES_BINDING before including.
// Twin: VplClass in src/estimators/vpls/vpl_buffer.rs.

struct VplClass {
    uint first; // VPL, counted from the set's first
    uint count;
    float flux; // luminous, over all sets
    uint pad0;
};

layout(set = 0, binding = VPL_CLASSES_BINDING, std430) readonly buffer VplClassBlock { VplClass data[]; } vpl_classes;
