// Colours by luma and two differences, in which boxes around natural colours are tight.

vec3 ycocg(vec3 rgb) {
    return vec3(dot(rgb, vec3(0.25, 0.5, 0.25)), 0.5 * (rgb.r - rgb.b), dot(rgb, vec3(-0.25, 0.5, -0.25)));
}

vec3 rgb_of_ycocg(vec3 c) { return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z); }
