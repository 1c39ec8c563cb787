// What the passes of still frames share.
//
// A correction, rgba16f: rgb: how much brighter the mean of still frames is than the denoised picture, over that picture, so that neither
// texture nor direct light is in it; a: the standard deviation of its luminance, UNKNOWN where the mean has no sample yet.

const float UNKNOWN = -1.0;

// Of what is shown: in what is darker than this, noise is seen less.
const float DARK = 0.05;

// What corrections are relative to, at this factor of exposure.
vec3 visible(vec3 light, float exposure) { return light + DARK / max(exposure, 1e-20); }
