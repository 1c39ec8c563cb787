"""The scenes of scripts/reproduce that are not built in."""

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

# Boxes above a floor of some roughness that mirrors them, under a sun.
MIRROR = """name = "mirror"
background = [0.02, 0.02, 0.03]
[[models]]
name = "floor"
primitive = "box"
size = [12, 0.2, 12]
material = { albedo = [0.9, 0.9, 0.9], roughness = ROUGHNESS, metallic = 1 }
[[models]]
name = "red"
primitive = "box"
size = [1, 1, 1]
material = { albedo = [0.8, 0.2, 0.15] }
[[models]]
name = "blue"
primitive = "box"
size = [1, 2, 1]
material = { albedo = [0.15, 0.3, 0.8] }
[[models]]
name = "wall"
primitive = "box"
size = [12, 4, 0.2]
material = { albedo = [0.6, 0.7, 0.4] }
[[instances]]
model = "floor"
translation = [0, -0.1, 0]
[[instances]]
model = "red"
translation = [-1.2, 0.7, 0]
[[instances]]
model = "blue"
translation = [1.1, 1.3, -0.8]
[[instances]]
model = "wall"
translation = [0, 2, -3]
[camera]
eye = [0, 2.2, 5]
target = [0, 0.6, -0.5]
vfov_deg = 45
MOTION
[[lights]]
type = "directional"
direction = [-0.4, -1, -0.6]
irradiance = [3, 3, 2.8]
angle_deg = ANGLE
"""

# The shadow of a board on a floor; with a step beside it or without.
SHADOW = """name = "shadow"
[[models]]
name = "floor"
primitive = "box"
size = [20, 0.2, 20]
material = { albedo = [0.7, 0.7, 0.7] }
[[models]]
name = "board"
primitive = "box"
size = [1.6, 0.05, 1.6]
material = { albedo = [0.1, 0.1, 0.1] }
[[instances]]
model = "floor"
translation = [0, -0.1, 0]
[[instances]]
model = "board"
translation = [0, 1.5, 0]
BOX
[camera]
eye = [0, 3, 3.2]
target = [0, 0, 0]
vfov_deg = FOV
[[lights]]
type = "point"
position = [0, 6, 0]
intensity = [60, 60, 60]
"""
BOX = """[[models]]
name = "step"
primitive = "box"
size = [1.2, 0.5, 1.2]
material = { albedo = [0.7, 0.7, 0.7] }
[[instances]]
model = "step"
translation = [2.6, 0.25, 0]
"""
STRAFE = "animation = { keyframes = [{ time = 0 }, { time = SECONDS, translation = [1.5, 0, 0] }] }"
# Seconds of that by the motion of a scene.
STRAFES = {"camera": "2", "fast-camera": "0.25"}


def strafe(motion):
    return STRAFE.replace("SECONDS", STRAFES[motion]) if motion in STRAFES else ""


def text_of(name):
    """The text of a scene: NAME or NAME:PARAMETER:...; none for one that is built in."""
    kind, *parameters = name.split(":")
    if kind == "flight":
        return FLIGHT.replace("SECONDS", parameters[0] if parameters else "4")
    if kind == "mirror":
        roughness, motion = parameters
        return MIRROR.replace("ROUGHNESS", roughness).replace("MOTION", strafe(motion)).replace("ANGLE", "2")
    if kind == "metals":
        # Boxes of metal and a wall of metal above it, under the sky.
        text = text_of(":".join(["mirror", *parameters]))
        for colour in ["[0.8, 0.2, 0.15]", "[0.15, 0.3, 0.8]", "[0.6, 0.7, 0.4]"]:
            text = text.replace(f"albedo = {colour}", f"albedo = {colour}, roughness = 0.3, metallic = 1")
        return text.replace("background = [0.02, 0.02, 0.03]", "[environment]\ncolour = [0.5, 0.7, 1.0]")
    if kind == "penumbra":
        # The boxes on a rough floor under a sun of some half angle.
        angle, motion = parameters
        return (MIRROR.replace("roughness = ROUGHNESS, metallic = 1", "roughness = 1").replace("MOTION", strafe(motion))
                .replace("ANGLE", angle))
    if kind == "shadow":
        return SHADOW.replace("BOX", "").replace("FOV", "45")
    if kind == "step":
        # The shaded side of a step beside a floor that is lit.
        text = SHADOW.replace("BOX", BOX).replace("FOV", "30")
        return text.replace("eye = [0, 3, 3.2]", "eye = [6.5, 0.9, 0]").replace("target = [0, 0, 0]", "target = [3.25, 0.2, 0]")
    return None


def moves(name):
    return name.startswith("flight") or name.endswith("camera")
