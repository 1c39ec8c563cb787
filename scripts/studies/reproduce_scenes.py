"""The scenes of scripts/study reproduce that are not built in."""

from .scene_file import Scene

# The camera flies along the court of the atrium and looks aside.
FLIGHT = """name = "atrium-flight"
background = [0.75, 1.2, 2.1]
[[models]]
name = "atrium"
builtin = "atrium"
[[instances]]
model = "atrium"
[camera]
eye = [-9.6, 2.1, 1.5]
target = [2.0, 3.9, -0.9]
vfov_deg = 62
[camera.animation]
keyframes = [{ time = 0 }, { time = SECONDS, translation = [8, 0.5, -1], rotation = [0, 40, 0] }]
[[lights]]
name = "sun"
type = "spot"
position = [-24, 46, 16]
direction = [25.5, -46, -17.5]
intensity = [28000, 24700, 19800]
inner_deg = 13
outer_deg = 14
"""
# Seconds of the camera's way by the motion of a scene.
STRAFES = {"camera": 2, "fast-camera": 0.25}


def boxes(motion, floor, half_angle, metals=False):
    """Boxes and a wall on a floor, under a sun; of metal under a sky, too."""
    scene = Scene("mirror", motion, None if metals else [0.02, 0.02, 0.03])
    metal = {"roughness": 0.3, "metallic": 1} if metals else {}
    scene.box("floor", [12, 0.2, 12], [0, -0.1, 0], [0.9, 0.9, 0.9], **floor)
    scene.box("red", [1, 1, 1], [-1.2, 0.7, 0], [0.8, 0.2, 0.15], **metal)
    scene.box("blue", [1, 2, 1], [1.1, 1.3, -0.8], [0.15, 0.3, 0.8], **metal)
    scene.box("wall", [12, 4, 0.2], [0, 2, -3], [0.6, 0.7, 0.4], **metal)
    if metals:
        scene.parts.append("[environment]\ncolour = [0.5, 0.7, 1.0]")
    scene.camera([0, 2.2, 5], [0, 0.6, -0.5], 45, [1.5, 0, 0], STRAFES.get(motion))
    scene.sun([-0.4, -1, -0.6], [3, 3, 2.8], half_angle)
    return scene.text()


def shadow(step=False):
    """The shadow of a board on a floor; or the shaded side of a step beside a floor that is lit."""
    scene = Scene("shadow", "still", None)
    grey = [0.7, 0.7, 0.7]
    scene.box("floor", [20, 0.2, 20], [0, -0.1, 0], grey)
    scene.box("board", [1.6, 0.05, 1.6], [0, 1.5, 0], [0.1, 0.1, 0.1])
    if step:
        scene.box("step", [1.2, 0.5, 1.2], [2.6, 0.25, 0], grey)
        scene.camera([6.5, 0.9, 0], [3.25, 0.2, 0], 30)
    else:
        scene.camera([0, 3, 3.2], [0, 0, 0], 45)
    scene.add("lights", type="point", position=[0, 6, 0], intensity=[60, 60, 60])
    return scene.text()


def text_of(name):
    """The text of a scene: NAME or NAME:PARAMETER:...; none for one that is built in."""
    kind, *parameters = name.split(":")
    if kind == "flight":
        return FLIGHT.replace("SECONDS", parameters[0] if parameters else "4")
    if kind in ["mirror", "metals"]:
        roughness, motion = parameters
        return boxes(motion, {"roughness": float(roughness), "metallic": 1}, 2, kind == "metals")
    if kind == "penumbra":
        half_angle, motion = parameters
        return boxes(motion, {"roughness": 1}, float(half_angle))
    return {"shadow": shadow(), "step": shadow(step=True)}.get(kind)


def moves(name):
    return name.startswith("flight") or name.endswith("camera")
