// The texels of a history that show the surface of a texel, by what `reprojected` says. Needs `reprojected`.

struct HistoryTaps {
    ivec2 first; // the first of side x side texels
    int side;
    uint mask;   // bit i: texel i shows the surface
    vec2 part;   // from the first texel to the next, of a bilinear filter
};

// `pixels`: of the picture, from one texel of the signal to the next. Where that is more than one the nearest texel stands for all.
HistoryTaps history_taps(ivec2 texel, int pixels) {
    vec4 found = imageLoad(reprojected, texel * pixels);
    vec2 place = vec2(texel) - found.xy / float(pixels);
    bool is_known = found.z > 0.0 || found.w > 0.0;
    if (pixels > 1) return HistoryTaps(ivec2(floor(place + 0.5)), 1, is_known ? 1u : 0u, vec2(0.0));
    bool bilinear = found.z > 0.0;
    ivec2 first = bilinear ? ivec2(floor(place)) : ivec2(floor(place + 0.5)) - 1;
    return HistoryTaps(first, bilinear ? 2 : 3, uint(bilinear ? found.z : found.w), place - floor(place));
}

// The weight of tap `i`; 0: it shows another surface.
float tap_weight(HistoryTaps taps, int i) {
    if ((taps.mask >> i & 1u) == 0u) return 0.0;
    if (taps.side != 2) return 1.0;
    // No tap weighs nothing: it may be the only one.
    vec2 along = max(mix(1.0 - taps.part, taps.part, vec2(i % 2, i / 2)), 1e-5);
    return along.x * along.y;
}

ivec2 tap_place(HistoryTaps taps, int i) { return taps.first + ivec2(i % taps.side, i / taps.side); }
