// Weighted reservoir sampling of one element of a stream (Chao 1982). One random number decides all: after each decision it is rescaled to
// [0, 1), so it stays uniform and independent of what was selected.

#ifndef RESERVOIR_GLSL
#define RESERVOIR_GLSL

struct Reservoir {
    uint selected;
    float weight; // of the selected element
    float sum;    // of all weights
    float random;
};

void update(inout Reservoir reservoir, uint element, float weight) {
    if (!(weight > 0.0)) return;
    reservoir.sum += weight;
    float share = weight / reservoir.sum;
    bool take = reservoir.random < share;
    if (take) reservoir.selected = element;
    if (take) reservoir.weight = weight;
    reservoir.random = take ? reservoir.random / share : (reservoir.random - share) / max(1.0 - share, 1e-6);
    reservoir.random = clamp(reservoir.random, 0.0, 0.9999999);
}

Reservoir new_reservoir(float random) { return Reservoir(0u, 0.0, 0.0, random); }

#endif
