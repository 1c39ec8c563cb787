#version 460
#extension GL_GOOGLE_include_directive : require
// One level of SVGF's a-trous filter for reflections, whose taps lie twice as far apart on rough surfaces (Granja 2021, section 3.6). In: light, its standard deviation, and how wide a blur is of use. Out: light and
// deviation, filtered.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "visible_surface.glsl"
#include "svgf.glsl"

layout(set = 0, binding = 7, rgba16f) uniform readonly image2D gbuffer_albedo;

// From a roughness of 0.2 on, which half floats round down.
const float ROUGH = 0.1995;

#define STEP_AT(pixel) (imageLoad(gbuffer_albedo, pixel).a >= ROUGH ? 2 * push.step : push.step)
#include "svgf_atrous.glsl"
