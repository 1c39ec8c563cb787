// The correction of still frames, as their passes share it.
//
// A correction, rgba16f: rgb: the mean of still frames less the denoised picture, over that picture, so that neither texture nor direct light
// is in it; a: the standard deviation of the mean's luminance, over that picture; 0 where the mean has no sample yet.

// Displayed luminance of darkness: in a darker pixel noise is seen less.
const float DARK = 0.05;

// The radiance that corrections are relative to, at this factor of exposure.
vec3 visible(vec3 light, float exposure) { return light + DARK / max(exposure, 1e-20); }
