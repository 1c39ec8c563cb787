"""Writes scene files: what scenes that studies make have in common."""

# Seconds of the animation; what moves does so from the first frame on.
SECONDS = 4


def table(**values):
    """An inline table or the lines of one."""
    return "\n".join(f"{key} = {toml(value)}" for key, value in values.items())


def toml(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(inner) for inner in value) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value)


class Scene:
    """The text of a scene file."""

    def __init__(self, name, motion, background=(0.02, 0.02, 0.03)):
        self.parts = [table(name=name, **({"background": background} if background else {}))]
        self.motion = motion

    def add(self, kind, **values):
        self.parts.append(f"[[{kind}]]\n{table(**values)}")

    def box(self, name, size, at, colour, roughness=None, metallic=0, turn=(0, 0, 0), shape="box", moves=None):
        material = {"albedo": colour}
        if roughness is not None:
            material |= {"roughness": roughness, "metallic": metallic}
        self.add("models", name=name, primitive=shape, size=size, material=material)
        self.place(name, at, turn, moves)

    def place(self, model, at, turn=(0, 0, 0), moves=None):
        animation = {}
        if moves and self.motion == "objects":
            animation = {"animation": {"keyframes": [{"time": 0}, {"time": SECONDS, "translation": moves}]}}
        self.add("instances", name=model, model=model, translation=at, rotation=turn, **animation)

    def camera(self, eye, target, vfov, strafe=None, seconds=SECONDS):
        animation = {}
        if strafe and self.motion.endswith("camera"):
            animation = {"animation": {"keyframes": [{"time": 0}, {"time": seconds, "translation": strafe}]}}
        self.parts.append(f"[camera]\n{table(eye=eye, target=target, vfov_deg=vfov, **animation)}")

    def sun(self, direction, irradiance, half_angle):
        animation = {}
        if self.motion == "light":
            turn = {"axis": [0, 1, 0], "degrees_per_second": 10}
            animation = {"animation": {"rotation": turn}}
        self.add("lights", name="sun", type="directional", direction=direction, irradiance=irradiance,
                 angle_deg=half_angle, **animation)

    def text(self):
        return "\n\n".join(self.parts) + "\n"
