#version 460
#extension GL_GOOGLE_include_directive : require
// One level of SVGF's a-trous filter. In: light, its standard deviation, and how wide a blur is of use. Out: light and
// deviation, filtered.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"

#define STEP_AT(pixel) push.step
#include "svgf_atrous.glsl"
