// A ray of a list; t as in tracer.glsl. Twin: GpuRay in src/passes/cast_rays.rs.

#ifndef RAY_GLSL
#define RAY_GLSL

struct GpuRay { vec3 origin; float t_min; vec3 direction; float t_max; };

#endif
