// Weighted reservoir sampling in one pass: keeps one of many by weight (Chao 1982). The number that decides is used again: what is left
// of it is uniform.

#ifndef CHOICE_GLSL
#define CHOICE_GLSL

struct Choice {
    uint kept;
    float weight; // of the kept one
    float sum;    // of all weights
    float random;
};

void offer(inout Choice choice, uint offered, float weight) {
    if (!(weight > 0.0)) return;
    choice.sum += weight;
    float share = weight / choice.sum;
    bool take = choice.random < share;
    if (take) choice.kept = offered;
    if (take) choice.weight = weight;
    choice.random = take ? choice.random / share : (choice.random - share) / max(1.0 - share, 1e-6);
    choice.random = clamp(choice.random, 0.0, 0.9999999);
}

Choice new_choice(float random) { return Choice(0u, 0.0, 0.0, random); }

#endif
