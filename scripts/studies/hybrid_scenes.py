"""Makes the scenes of scripts/study hybrid: scene files and the wire sphere's OBJ, after those of P. Granja, Real Time Hybrid
Rendering Techniques, 2021.

    boxes      boxes ever farther from a mirror of some roughness
    icosphere  a sphere of wires above a floor of some roughness
    sponza     the atrium with glossier stone; code makes another where the download is missing
    pillars    a row of thin pillars under a sun of some half angle
    objects    large plain objects under such a sun

Each moves in one way: not at all, the camera strafes, an object crosses, or the light swings.
"""

import itertools
import math
import os
from pathlib import Path

from .made_scenes import Model
from .scene_file import Scene

MOTIONS = ["still", "camera", "objects", "light"]
COLOURS = [[0.7, 0.1, 0.08], [0.75, 0.6, 0.1], [0.15, 0.5, 0.15], [0.1, 0.25, 0.7], [0.6, 0.6, 0.6], [0.55, 0.2, 0.5]]


def boxes(folder, motion, roughness):
    scene = Scene("boxes", motion)
    scene.box("floor", [30, 0.2, 16], [0, -0.1, 3], [0.5, 0.48, 0.45])
    scene.box("mirror", [16, 6, 0.2], [0, 3, -3.1], [0.9, 0.9, 0.9], roughness, 1)
    for index, colour in enumerate(COLOURS):
        at = [-4.5 + 1.8 * index, 0.5, -2.2 + 1.1 * index]
        moves = [1.5, 0, 0] if index == 2 else None
        scene.box(f"box {index}", [0.9, 1, 0.9], at, colour, turn=[0, 17 * index, 0], moves=moves)
    scene.sun([-0.5, -1, -0.6], [4, 3.9, 3.7], 0)
    scene.camera([1.5, 2.6, 8.5], [0, 1.2, -2], 42, [1.2, 0, 0])
    return scene


def icosphere(folder, motion, roughness):
    wires(folder)
    scene = Scene("icosphere", motion)
    scene.box("floor", [12, 0.2, 12], [0, -0.1, 0], [0.85, 0.85, 0.85], roughness, 1)
    scene.box("wall", [12, 5, 0.2], [0, 2.5, -4], [0.3, 0.45, 0.6])
    scene.box("side", [0.2, 5, 8], [-5, 2.5, 0], [0.65, 0.4, 0.2])
    scene.add("models", name="wires", path="wires.obj")
    scene.place("wires", [0, 1.35, 0], moves=[0.8, 0, 0])
    scene.sun([0.4, -1, -0.5], [4, 3.9, 3.7], 0)
    scene.camera([0.6, 2.4, 5.2], [0, 1, 0], 45, [1, 0, 0])
    return scene


def wires(folder):
    """The 120 edges of an icosahedron whose faces were divided once, as rods."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [p for s, t in itertools.product([-1, 1], repeat=2)
               for p in [(0, s, t * golden), (s, t * golden, 0), (t * golden, 0, s)]]
    unit = [tuple(x / math.sqrt(1 + golden * golden) for x in p) for p in corners]
    near = 1.2
    edges = [(a, b) for a, b in itertools.combinations(unit, 2) if math.dist(a, b) < near]

    def middle(a, b):
        sum_of = [x + y for x, y in zip(a, b)]
        return tuple(x / math.hypot(*sum_of) for x in sum_of)

    middles = [middle(a, b) for a, b in edges]
    halves = [(a, m) for (a, b), m in zip(edges, middles)] + [(b, m) for (a, b), m in zip(edges, middles)]
    faces = [(a, b) for a, b in itertools.combinations(middles, 2) if math.dist(a, b) < 0.65]
    model = Model()
    for a, b in halves + faces:
        # A rod that stands upright has no heading.
        model.rod("steel", a, tuple(x + 1e-6 for x in b), 0.03, 8)
    model.write(folder, "wires", "")


def sponza(folder, motion, roughness):
    assets = os.environ.get("GLOWWORM_ASSETS")
    here = assets and (Path(assets) / "sponza" / "sponza.obj").exists()
    scene = Scene("sponza", motion)
    if here:
        scene.add("models", name="sponza", asset="sponza/sponza.obj")
        glossy = ["sp_00_pod", "sp_01_stub", "sp_00_stup", "sp_01_stup", "sp_00_zid"]
    else:
        scene.add("models", name="sponza", builtin="atrium")
        glossy = []
    for name in glossy:
        scene.add("materials", name=name, roughness=roughness, metallic=0.3)
    scene.place("sponza", [0, 0, 0])
    scene.box("crate", [1.2, 1.2, 1.2], [2, 0.8, 0], [0.7, 0.15, 0.1], turn=[0, 30, 0], moves=[0, 0, 1.5])
    scene.sun([0.35, -1, 0.2], [9, 8.6, 8], 0.3)
    scene.camera([-6.5, 3, 0.4], [4, 2, -0.2], 60, [0, 0, 0.8])
    return scene


def pillars(folder, motion, half_angle):
    scene = Scene("pillars", motion)
    scene.box("floor", [24, 0.2, 14], [0, -0.1, 0], [0.6, 0.58, 0.55])
    scene.box("wall", [24, 6, 0.2], [0, 3, -5], [0.55, 0.55, 0.6])
    for index in range(12):
        moves = [0.6, 0, 0.8] if index == 5 else None
        scene.box(f"pillar {index}", [0.12, 3, 0.12], [-4.4 + 0.8 * index, 1.5, -1 - 0.1 * index], [0.7, 0.68, 0.6],
                  moves=moves)
    scene.sun([0.5, -1, -0.45], [4, 3.9, 3.7], half_angle)
    scene.camera([1, 3.2, 7.5], [0, 0.9, -1.5], 45, [1, 0, 0])
    return scene


def objects(folder, motion, half_angle):
    scene = Scene("objects", motion)
    scene.box("floor", [24, 0.2, 24], [0, -0.1, 0], [0.6, 0.58, 0.55])
    scene.box("tower", [1.5, 3.4, 1.5], [-2, 1.7, -1.5], [0.7, 0.5, 0.35], turn=[0, 25, 0])
    scene.box("slab", [3, 0.5, 2], [1.2, 1.6, -0.6], [0.35, 0.5, 0.7], turn=[0, -15, 0], moves=[0.8, 0, 0])
    scene.box("block", [1, 1.2, 1], [2.4, 0.6, 1.2], [0.5, 0.65, 0.4], turn=[0, 40, 0])
    scene.box("ball", [0.9, 0.9, 0.9], [-0.3, 0.9, 1.3], [0.75, 0.7, 0.3], shape="sphere")
    scene.sun([0.5, -1, -0.35], [4, 3.9, 3.7], half_angle)
    scene.camera([1.5, 4.5, 8], [0, 0.8, 0], 42, [1, 0, 0])
    return scene


REFLECTIONS = {"boxes": boxes, "icosphere": icosphere, "sponza": sponza}
SHADOWS = {"pillars": pillars, "objects": objects}


def make(folder, name, motion, value):
    """Writes the scene with this roughness or half angle, and gives its file."""
    folder = folder / f"{name}-{motion}-{value:g}"
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.toml"
    file.write_text((REFLECTIONS | SHADOWS)[name](folder, motion, value).text())
    return file
