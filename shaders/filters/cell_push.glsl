// Twin: CellPush in src/filters/cells.rs.
layout(push_constant) uniform CellPush {
    float spread;      // of a cell, over a distance of 1: its width in pixels times that of a pixel
    float widening;    // of cells behind the visible surface
    float jitter;      // in cell widths
    uint jitters;      // positions that a vertex is moved to
    uint bits;         // of the normal in the key
    uint normal;       // CELL_NORMAL_...
    uint probes;
    uint levels;       // sizes of cells
    uint samples;      // paths a pixel
    uint window;       // frames of the mean; 0: any number
    float growth;      // of the window, by each frame
    uint life;         // frames without samples until a cell is evicted
    uint view;         // of cell_view.comp
} push;

const uint CELL_NORMAL_EXACT = 0u;
const uint CELL_NORMAL_JITTERED = 1u;
const uint CELL_NORMAL_VERIFICATION = 2u;
