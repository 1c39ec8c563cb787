// A line over the picture. Twin: OverlayLine in src/gpu_scene/structs.rs.

struct OverlayLine {
    vec4 from_width; // xyz: world position of one end; w: width in pixels
    vec4 to_hidden;  // xyz: of the other end; w: what the opacity of hidden parts is multiplied by
    vec4 colour;     // display values, opacity
};
