// Whether the scene has thin surfaces: elsewhere nobody pays for them. Twin: `TracerVariant` in src/gpu_scene/tracer.rs.

#ifndef HAS_THIN_SURFACES_GLSL
#define HAS_THIN_SURFACES_GLSL

layout(constant_id = 0) const bool HAS_THIN_SURFACES = true;

#endif
