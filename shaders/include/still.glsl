// What the passes of still frames share.
//
// A correction, rgba16f: rgb: the mean of still frames less the denoised picture, over that picture, so that neither texture nor direct light
// is in it; a: the standard deviation of the mean's luminance, over that picture; 0 where the mean has no sample yet.

// Of what is shown: in what is darker than this, noise is seen less.
const float DARK = 0.05;

// What corrections are relative to, at this factor of exposure.
vec3 visible(vec3 light, float exposure) { return light + DARK / max(exposure, 1e-20); }
