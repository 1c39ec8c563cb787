// Statistics of SVGF's history over the 5x5 texels around a place: of all frames and of the last few. Needs svgf.glsl and `last_moments`.

struct Recent {
    float mean;      // of the history's luminance
    float deviation; // standard deviation of luminance, frame by frame
    float change;    // of the mean of the last frames from that of the history
    float texels;    // that witness it
};

// Histories shorter than this many frames do not differ from their last frames.
const float FEW_FRAMES = 3.4;

// Texels whose history is short witness as if they said the same as the rest: it may just have been dropped.
Recent recent_at(ivec2 place) {
    Recent sum = Recent(0.0, 0.0, 0.0, 0.0);
    float count = 0.0;
    for (int i = 0; i < 25; i++) {
        ivec2 at = place + ivec2(i % 5, i / 5) - 2;
        if (!inside(at)) continue;
        vec4 then = imageLoad(last_moments, at);
        if (then.b > 0.0) sum.texels += 1.0;
        if (then.b < FEW_FRAMES) continue;
        sum.mean += then.r;
        sum.deviation += then.g * then.g;
        sum.change += then.a - then.r;
        count += 1.0;
    }
    if (count == 0.0) return sum;
    return Recent(sum.mean / count, sqrt(sum.deviation / count), sum.change / count, sum.texels);
}

// Error of the change by rounding, as a share of the mean.
const float ROUNDING = 0.02;
// Rare bright samples come in heaps, but never go so: the rarer they are, by deviation over mean, the more proof light that comes
// needs.
const float RARITY = 0.15;

// How much of the history the last frames leave: all up to two thirds of `rejection`, nothing beyond it, in standard deviations of
// the mean over as many texels. A test for means of samples (Welch 1947).
float kept_history(Recent recent, float rejection) {
    float expected = rejection * recent.deviation * inversesqrt(max(recent.texels, 1.0)) + ROUNDING * recent.mean;
    float rarity = recent.deviation / max(recent.mean, 1e-6);
    if (recent.change > 0.0) expected *= 1.0 + RARITY * rarity;
    return clamp(3.0 - 3.0 * abs(recent.change) / max(expected, 1e-6), 0.0, 1.0);
}
