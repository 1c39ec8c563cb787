// What the alpha of direct light says of a pixel's surface.

const float NOTHING = 0.0; // there is none
const float STATIC = 1.0;
const float MOVER = 2.0; // it may move
