#version 460
#extension GL_GOOGLE_include_directive : require
// Declares the scene set and does nothing: src/vulkan/shared_set.rs makes the layout of set 1 from it.
#include "tracer.glsl"

layout(local_size_x = 1) in;

void main() {}
