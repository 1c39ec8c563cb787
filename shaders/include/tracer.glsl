// The tracer that shaders use; whatever it is, it offers
//   bool trace_occluded(vec3 origin, vec3 direction, float t_min, float t_max)
// and trace_closest, and takes the bindings from TRACER_BINDING on.
#include "tracer_software.glsl"
