// Whether the scene has thin sheets: elsewhere nobody pays for them. Twin: `TracerVariant` in src/gpu_scene/tracer.rs.

#ifndef HAS_SHEETS_GLSL
#define HAS_SHEETS_GLSL

layout(constant_id = 0) const bool HAS_SHEETS = true;

#endif
