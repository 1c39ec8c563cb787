// Twin: PathPush in src/estimators/paths/mod.rs.
layout(push_constant) uniform PathPush {
    float spread;         // of a pixel, over a distance of 1
    float environment;    // luminance of the environment's mean where it has a map; 0: it is left to scattered rays
    uint has_environment; // 0: what lies behind all surfaces is only seen, it sends no light
    uint keeps;           // 1: the vertices that the last frame kept are where they were
} push;
