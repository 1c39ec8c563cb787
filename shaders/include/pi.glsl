// Half the circumference of the unit circle.

#ifndef PI_GLSL
#define PI_GLSL

const float PI = 3.14159265358979;

#endif
