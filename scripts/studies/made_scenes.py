"""Makes the four test scenes of scripts/study quality: an OBJ, an MTL and a scene file for each.

All are in metres and watts, stand still, and are made of nothing but numbers, so every run writes the same bytes. Each has
one difficulty of indirect light, surfaces of albedo 0.2 to 0.85, some saturated, some curved or tilted, and thin objects:

    corridor    a long way from the only light to what is seen
    blinds      a sun of which little enters, through narrow slits
    uplight     a light that shines at the ceiling alone, so that all light starts from one bright spot
    courtyard   24 lights under arcades and an open sky, which most light is lost to
"""

import math

PALETTE = {
    "white": (0.85, 0.85, 0.83),
    "plaster": (0.74, 0.71, 0.65),
    "stone": (0.56, 0.52, 0.45),
    "grey": (0.40, 0.41, 0.42),
    "slate": (0.20, 0.21, 0.23),
    "oak": (0.52, 0.35, 0.20),
    "walnut": (0.28, 0.20, 0.20),
    "terracotta": (0.62, 0.28, 0.16),
    "red": (0.70, 0.08, 0.06),
    "blue": (0.08, 0.18, 0.62),
    "green": (0.10, 0.45, 0.12),
    "yellow": (0.80, 0.62, 0.08),
    "linen": (0.66, 0.62, 0.54),
    "steel": (0.45, 0.47, 0.50),
}


def rotated(point, turn):
    """The point turned by degrees about the axes x, then y, then z."""
    for (a, b), degrees in zip([(1, 2), (2, 0), (0, 1)], turn):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        point = list(point)
        point[a], point[b] = c * point[a] - s * point[b], s * point[a] + c * point[b]
    return tuple(point)


def circle(count):
    return [(math.cos(2 * math.pi * i / count), math.sin(2 * math.pi * i / count)) for i in range(count)]


class Model:
    """Polygons by material; whatever is added stands in metres, y up, front faces counter-clockwise."""

    def __init__(self):
        self.points = []
        self.faces = {}

    def face(self, material, *corners):
        first = len(self.points) + 1
        self.points += corners
        self.faces.setdefault(material, []).append(range(first, first + len(corners)))

    def mesh(self, material, points, faces):
        """Faces that share their points."""
        first = len(self.points) + 1
        self.points += points
        self.faces.setdefault(material, []).extend([[first + i for i in face] for face in faces])

    def box(self, material, centre, size, turn=(0, 0, 0)):
        def corner(*signs):
            offset = rotated([sign * edge / 2 for sign, edge in zip(signs, size)], turn)
            return tuple(c + o for c, o in zip(centre, offset))

        for axis in range(3):
            for side in [-1, 1]:
                around = [(-1, -1), (1, -1), (1, 1), (-1, 1)][::side]
                corners = []
                for u, v in around:
                    signs = [0, 0, 0]
                    signs[axis], signs[(axis + 1) % 3], signs[(axis + 2) % 3] = side, u, v
                    corners.append(corner(*signs))
                self.face(material, *corners)

    def between(self, material, low, high):
        """A box from its lowest to its highest corner."""
        self.box(material, [(a + b) / 2 for a, b in zip(low, high)], [b - a for a, b in zip(low, high)])

    def lathe(self, material, foot, profile, segments=24, turn=(0, 0, 0)):
        """A profile of (radius, height) from the foot upwards, turned about the vertical, then tilted about the foot."""
        points, faces = [], []
        for radius, height in profile:
            for x, z in circle(segments):
                offset = rotated((radius * x, height, radius * z), turn)
                points.append(tuple(f + o for f, o in zip(foot, offset)))
        for ring in range(len(profile) - 1):
            for i in range(segments):
                j, a, b = (i + 1) % segments, ring * segments, (ring + 1) * segments
                faces.append([a + i, b + i, b + j, a + j])
        self.mesh(material, points, faces)

    def rod(self, material, start, end, radius, segments=10):
        """A closed cylinder from one point to another."""
        along = [b - a for a, b in zip(start, end)]
        length = math.hypot(*along)
        tilt = math.degrees(math.acos(along[1] / length))
        heading = math.degrees(math.atan2(along[0], along[2]))
        self.lathe(material, start, [(0, 0), (radius, 0), (radius, length), (0, length)], segments, (tilt, heading, 0))

    def ball(self, material, centre, radius, segments=24):
        angles = [math.pi * i / (segments // 2) for i in range(segments // 2 + 1)]
        self.lathe(material, centre, [(radius * math.sin(a), -radius * math.cos(a)) for a in angles], segments)

    def arch(self, material, start, along, width, heights, depth, segments=14):
        """A bay of an arcade: a wall of some depth from the springing of a round arch to the top, open below the arch.
        It goes from the start along x or z; its depth lies on the left of that way as seen from above."""
        spring, top = heights
        side = (along[1], -along[0])

        def at(run, height, back):
            return (start[0] + along[0] * run + side[0] * back, height, start[1] + along[1] * run + side[1] * back)

        steps = [math.pi * i / segments for i in range(segments + 1)]
        arc = [(width / 2 * (1 - math.cos(step)), spring + width / 2 * math.sin(step)) for step in steps]
        for (a, below_a), (b, below_b) in zip(arc, arc[1:]):
            self.face(material, at(a, below_a, 0), at(b, below_b, 0), at(b, top, 0), at(a, top, 0))
            self.face(material, at(b, below_b, depth), at(a, below_a, depth), at(a, top, depth), at(b, top, depth))
        soffit = [at(*point, back) for point in arc for back in [0, depth]]
        self.mesh(material, soffit, [[2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2] for i in range(segments)])

    def write(self, folder, name, scene, background=(0, 0, 0)):
        """Writes the three files; the background emits no light."""
        used = sorted(self.faces)
        lines = [f"mtllib {name}.mtl", *("v {:.5f} {:.5f} {:.5f}".format(*point) for point in self.points)]
        for material in used:
            lines += [f"usemtl {material}", *("f " + " ".join(map(str, face)) for face in self.faces[material])]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")
        (folder / f"{name}.mtl").write_text("".join("newmtl {}\nKd {} {} {}\n".format(m, *PALETTE[m]) for m in used))
        model = f'[[models]]\nname = "{name}"\npath = "{name}.obj"\n\n[[instances]]\nmodel = "{name}"\n'
        head = f'name = "{name}"\nbackground = {list(background)}\n\n'
        (folder / f"{name}.toml").write_text(head + model + scene)


def room(model, low, high, materials):
    """The inside of a box: floor, ceiling and the walls at low x, high x, low z and high z; None leaves one open."""
    (x, y, z), (X, Y, Z) = low, high
    sides = [
        [(x, y, z), (x, y, Z), (X, y, Z), (X, y, z)],
        [(x, Y, z), (X, Y, z), (X, Y, Z), (x, Y, Z)],
        [(x, y, z), (x, Y, z), (x, Y, Z), (x, y, Z)],
        [(X, y, z), (X, y, Z), (X, Y, Z), (X, Y, z)],
        [(x, y, z), (X, y, z), (X, Y, z), (x, Y, z)],
        [(x, y, Z), (x, Y, Z), (X, Y, Z), (X, y, Z)],
    ]
    for material, side in zip(materials, sides):
        if material:
            model.face(material, *side)


def table(model, material, centre, size, thickness=0.03, leg=0.02):
    """A top on four thin legs, standing on y = 0; the size is its length, height and width."""
    (x, z), (length, height, width) = centre, size
    model.box(material, (x, height - thickness / 2, z), (length, thickness, width))
    for sx in [-1, 1]:
        for sz in [-1, 1]:
            foot = (x + sx * (length / 2 - 2 * leg), 0, z + sz * (width / 2 - 2 * leg))
            model.rod("steel", foot, (foot[0], height - thickness, foot[2]), leg)


VASE = [(0, 0), (0.10, 0), (0.16, 0.12), (0.17, 0.22), (0.12, 0.36), (0.06, 0.44), (0.09, 0.52), (0.07, 0.52), (0.05, 0.44)]


def corridor(folder):
    """24 m x 2.4 m x 2.6 m with niches on the left and pillars on the right; the lamp is 19 m away, behind a door frame."""
    model = Model()
    room(model, (-1.2, 0, -24), (1.2, 2.6, 0), ["stone", "white", None, "plaster", "yellow", "blue"])
    # The left wall, with a niche every 4.5 m.
    edge = 0.0
    for niche, back in zip([-3.2, -7.7, -12.2, -16.7], ["red", "plaster", "green", "white"]):
        model.between("plaster", (-1.8, 0, niche), (-1.2, 2.6, edge))
        model.between("white", (-1.8, 2.1, niche - 1.4), (-1.2, 2.6, niche))
        model.between(back, (-1.82, 0, niche - 1.4), (-1.8, 2.6, niche))
        model.between("oak", (-1.8, 0, niche - 1.4), (-1.25, 0.5, niche))
        edge = niche - 1.4
    model.between("plaster", (-1.8, 0, -24), (-1.2, 2.6, edge))
    model.lathe("terracotta", (-1.52, 0.5, -8.4), VASE)
    model.ball("white", (-1.5, 0.78, -3.9), 0.28)
    model.box("blue", (-1.5, 0.95, -12.9), (0.03, 0.9, 0.8), (0, 15, 12))
    model.lathe("white", (-1.52, 0.5, -17.4), VASE)
    # Pillars and a handrail on the right.
    for z in [-2.5, -6, -9.5, -13, -16.5, -20]:
        model.lathe("white", (1.2, 0, z), [(0.26, 0), (0.26, 0.1), (0.2, 0.14), (0.2, 2.4), (0.28, 2.6)])
    for z in range(-24, 0, 2):
        model.rod("steel", (1.2, 0.9, z + 1), (1.08, 0.94, z + 1), 0.01, 6)
    model.rod("oak", (1.08, 0.95, -23.8), (1.08, 0.95, -0.2), 0.022)
    model.between("red", (-0.5, 0, -23), (0.5, 0.012, -1))
    model.between("plaster", (-1.2, 0, -11.3), (-1.0, 2.6, -11.0))
    model.between("plaster", (-1.0, 2.35, -11.3), (1.2, 2.6, -11.0))
    # What somebody left there.
    model.rod("oak", (0.75, 0, -5.0), (1.15, 1.5, -5.1), 0.013)
    table(model, "walnut", (0.78, -14.8), (0.5, 0.8, 1.1))
    model.box("yellow", (0.78, 0.92, -14.7), (0.3, 0.24, 0.3), (0, 33, 0))
    model.box("linen", (-0.75, 0.2, -19.5), (0.5, 0.4, 0.5), (0, 20, 0))
    model.box("green", (0.3, 0.35, -9.6), (0.9, 0.02, 0.5), (0, 40, 28))
    model.write(folder, "corridor", """
[camera]
eye = [0.35, 1.6, -3.6]
target = [-0.1, 1.2, -15]
vfov_deg = 62

[[lights]]
name = "ceiling lamp"
type = "area"
radiance = [1500, 1400, 1180]
polygon = [[-0.6, 2.58, -19.6], [0.6, 2.58, -19.6], [0.6, 2.58, -18.8], [-0.6, 2.58, -18.8]]
""")


def blinds(folder):
    """A study of 5 m x 2.7 m x 4 m; the sun shines through the slats before a window of 1.9 m x 1.5 m."""
    model = Model()
    room(model, (-2.5, 0, -2), (2.5, 2.7, 2), ["green", "white", None, "plaster", "plaster", "white"])
    # The wall of the window, 25 cm thick, and its 22 slats.
    for low, high in [((-2.75, 0, -2), (-2.5, 0.85, 2)), ((-2.75, 2.35, -2), (-2.5, 2.7, 2)),
                      ((-2.75, 0.85, -2), (-2.5, 2.35, -0.95)), ((-2.75, 0.85, 0.95), (-2.5, 2.35, 2))]:
        model.between("plaster", low, high)
    for slat in range(22):
        model.box("linen", (-2.62, 0.885 + 0.068 * slat, 0), (0.06, 0.003, 1.9), (0, 0, -8))
    for z in [-0.6, 0.6]:
        model.rod("white", (-2.62, 0.85, z), (-2.62, 2.35, z), 0.004, 6)
    # Furniture.
    table(model, "oak", (-0.2, -1.45), (1.7, 0.74, 0.8))
    model.box("slate", (0.0, 0.93, -1.7), (0.6, 0.36, 0.02), (-10, 12, 0))
    model.box("red", (-0.7, 0.79, -1.4), (0.22, 0.1, 0.3), (0, 25, 0))
    model.between("blue", (1.9, 0, -1.9), (2.48, 1.9, -0.5))
    for shelf in [0.45, 0.9, 1.35]:
        model.between("white", (1.86, shelf, -1.88), (1.9, shelf + 0.02, -0.52))
    model.box("linen", (1.35, 0.22, 1.0), (0.9, 0.44, 1.5), (0, -8, 0))
    model.box("linen", (1.78, 0.5, 1.06), (0.2, 1.0, 1.5), (0, -8, -10))
    model.rod("terracotta", (1.3, 0.54, 0.45), (1.3, 0.54, 1.05), 0.11, 20)
    model.between("terracotta", (-1.5, 0, -0.7), (0.7, 0.01, 1.3))
    model.lathe("white", (-1.7, 0, 1.55), VASE)
    model.ball("yellow", (0.25, 0.2, 0.55), 0.2)
    for angle in range(5):
        x, z = math.cos(angle * 1.2566), math.sin(angle * 1.2566)
        model.rod("slate", (-0.2, 0.06, -0.62), (-0.2 + 0.28 * x, 0.02, -0.62 + 0.28 * z), 0.014, 8)
    model.rod("steel", (-0.2, 0.05, -0.62), (-0.2, 0.44, -0.62), 0.025)
    model.lathe("slate", (-0.2, 0.44, -0.62), [(0, 0), (0.24, 0), (0.25, 0.03), (0.22, 0.06), (0, 0.06)])
    model.box("slate", (-0.2, 0.78, -0.36), (0.4, 0.45, 0.03), (12, 0, 0))
    model.write(folder, "blinds", """
[camera]
eye = [1.75, 1.55, 1.85]
target = [-1.0, 0.75, -0.8]
vfov_deg = 66

[[lights]]
name = "sun"
type = "directional"
direction = [0.80, -0.53, -0.12]
irradiance = [95, 86, 70]
""", background=(1.2, 1.6, 2.2))


def uplight(folder):
    """A living room of 5.4 m x 2.6 m x 4.4 m; a spot in the open shade of a floor lamp shines at the ceiling."""
    model = Model()
    room(model, (-2.7, 0, -2.2), (2.7, 2.6, 2.2), ["oak", "white", "plaster", "linen", "plaster", "white"])
    # The lamp: foot, pole, and a shade that no light passes.
    x, z = -1.75, -1.55
    model.lathe("slate", (x, 0, z), [(0, 0), (0.16, 0), (0.16, 0.02), (0.02, 0.04), (0.014, 0.06), (0.014, 1.55), (0, 1.55)])
    model.lathe("steel", (x, 1.55, z), [(0, 0), (0.05, 0), (0.19, 0.2), (0.185, 0.2), (0.046, 0.006), (0, 0.006)])
    # A sofa, its round arms and cushions.
    model.box("blue", (0.3, 0.22, -1.6), (2.0, 0.36, 0.85))
    model.box("blue", (0.3, 0.58, -1.98), (2.0, 0.6, 0.2), (-9, 0, 0))
    for side in [-0.78, 1.38]:
        model.rod("blue", (side, 0.48, -2.05), (side, 0.48, -1.18), 0.13, 20)
        model.between("blue", (side - 0.1, 0, -2.05), (side + 0.1, 0.46, -1.18))
    model.box("yellow", (-0.3, 0.56, -1.78), (0.42, 0.42, 0.1), (-18, 8, 4))
    model.box("red", (0.9, 0.56, -1.78), (0.42, 0.42, 0.1), (-20, -12, -6))
    table(model, "walnut", (0.3, -0.35), (1.1, 0.42, 0.6), 0.025, 0.014)
    model.lathe("white", (0.05, 0.42, -0.35), [(0, 0), (0.06, 0), (0.14, 0.07), (0.135, 0.07), (0.055, 0.008), (0, 0.008)])
    model.box("terracotta", (0.55, 0.44, -0.3), (0.21, 0.04, 0.29), (0, 31, 0))
    model.between("red", (-0.9, 0, -1.1), (1.5, 0.01, 0.6))
    # Shelves with books.
    model.between("walnut", (2.38, 0, -1.9), (2.7, 0.04, 0.3))
    for end in [-1.9, 0.27]:
        model.between("walnut", (2.38, 0, end), (2.7, 2.0, end + 0.03))
    colours = ["red", "linen", "green", "slate", "yellow", "blue", "white", "terracotta"]
    for row in range(5):
        height = 0.4 * (row + 1)
        model.between("walnut", (2.38, height - 0.02, -1.9), (2.7, height, 0.3))
        if row < 4:
            place, book = -1.84, 0
            while place < 0.15 - 0.3 * (row % 2):
                width = 0.03 + 0.017 * ((book * 7 + row * 3) % 4)
                tall = 0.22 + 0.03 * ((book * 5 + row) % 4)
                lean = 9 if book % 9 == 8 else 0
                model.box(colours[(book * 3 + row) % 8], (2.53, height + tall / 2, place + width / 2),
                          (0.2, tall, width - 0.003), (lean, 0, 0))
                place, book = place + width + (0.05 if lean else 0), book + 1
    # An armchair, a plant with thin leaves, a picture that leans on the wall.
    model.box("green", (-1.65, 0.24, 0.5), (0.8, 0.4, 0.8), (0, 62, 0))
    model.box("green", (-1.98, 0.6, 0.67), (0.8, 0.75, 0.16), (-10, 118, 0))
    model.lathe("terracotta", (1.95, 0, -1.75), [(0, 0), (0.14, 0), (0.19, 0.34), (0.17, 0.34), (0.15, 0.28), (0, 0.28)])
    for leaf in range(14):
        heading, lift = leaf * 137.5, 52 + (leaf * 29) % 34
        tip = rotated((0, 0, 0.34 + 0.02 * leaf), (-lift, heading, 0))
        wide = rotated((0.045, 0, 0), (0, heading, 0))
        middle = [0.55 * t for t in tip]
        foot = (1.95, 0.3, -1.75)
        model.face("green", foot, *(tuple(f + o for f, o in zip(foot, offset)) for offset in [
            [m + w for m, w in zip(middle, wide)], [t - (0.1 if i == 1 else 0) for i, t in enumerate(tip)],
            [m - w for m, w in zip(middle, wide)]]))
    model.box("walnut", (-2.62, 0.42, -0.9), (0.03, 0.8, 0.6), (0, 0, 8))
    model.box("yellow", (-2.6, 0.42, -0.9), (0.03, 0.7, 0.5), (0, 0, 8))
    model.between("red", (0.0, 1.35, -2.2), (0.9, 1.95, -2.17))
    model.write(folder, "uplight", """
[camera]
eye = [0.6, 1.5, 2.1]
target = [-0.05, 1.05, -1.2]
vfov_deg = 68

[[lights]]
name = "floor lamp"
type = "spot"
position = [-1.75, 1.68, -1.55]
direction = [0.05, 1, 0.05]
intensity = [62, 54, 42]
inner_deg = 30
outer_deg = 46
""")


def courtyard(folder):
    """A court of 9 m x 9 m with a walk of 2.4 m behind arcades on all sides, by night."""
    model = Model()
    bay, half, walk = 1.8, 4.5, 2.4
    edge = half + walk
    model.face("stone", (-edge, 0, -edge), (-edge, 0, edge), (edge, 0, edge), (edge, 0, -edge))
    walls = ["terracotta", "plaster", "blue", "plaster"]
    sides = [((1, 0), (-half, half)), ((0, -1), (half, half)), ((-1, 0), (half, -half)), ((0, 1), (-half, -half))]
    for wall, (along, start) in zip(walls, sides):
        out = (-along[1], along[0])

        def at(run, height, back):
            return (start[0] + along[0] * run + out[0] * back, height, start[1] + along[1] * run + out[1] * back)

        # Five bays on columns; the ceiling of the walk, its back wall with doors, and a roof that slopes.
        for i in range(5):
            foot = at(i * bay, 0, 0.15)
            model.arch("plaster", at(i * bay, 0, 0)[::2], along, bay, (2.0, 3.4), -0.3)
            model.lathe("white", foot, [(0.2, 0), (0.2, 0.12), (0.13, 0.17), (0.115, 1.8), (0.2, 1.92), (0.2, 2.0)], 20)
        model.face("white", at(-walk, 3.1, walk), at(2 * half + walk, 3.1, walk), at(2 * half, 3.1, 0), at(0, 3.1, 0))
        model.face(wall, at(-walk, 0, walk), at(2 * half + walk, 0, walk), at(2 * half + walk, 4.4, walk),
                   at(-walk, 4.4, walk))
        model.face("terracotta", at(0, 3.4, 0), at(2 * half, 3.4, 0), at(2 * half + walk, 4.4, walk), at(-walk, 4.4, walk))
        for i in [1, 3]:
            low, high = at(i * bay + 0.4, 0, walk), at(i * bay + 1.4, 2.1, walk - 0.06)
            model.between("walnut", [min(p) for p in zip(low, high)], [max(p) for p in zip(low, high)])
    # A fountain, benches, a pergola of thin bars, urns, boards against a column.
    model.lathe("stone", (0, 0, 0), [(1.3, 0), (1.3, 0.5), (1.1, 0.5), (1.1, 0.25), (0, 0.25)], 40)
    model.lathe("white", (0, 0.25, 0), [(0.25, 0), (0.12, 0.3), (0.1, 0.8), (0.55, 1.05), (0.53, 1.07), (0.1, 0.9), (0, 0.9)])
    model.ball("white", (0, 1.28, 0), 0.2)
    for x, z, turn in [(-2.6, 0.4, 90), (2.7, -0.6, 80), (0.3, -3.0, 0)]:
        model.box("oak", (x, 0.43, z), (1.5, 0.05, 0.4), (0, turn, 0))
        for end in [-0.6, 0.6]:
            dx, _, dz = rotated((end, 0, 0), (0, turn, 0))
            model.box("slate", (x + dx, 0.2, z + dz), (0.08, 0.41, 0.36), (0, turn, 0))
    for i in range(9):
        model.rod("steel", (2.2, 2.3, 1.2 + 0.25 * i), (4.3, 2.3, 1.2 + 0.25 * i), 0.015, 6)
    for x, z in [(2.3, 1.2), (4.2, 1.2), (2.3, 3.2), (4.2, 3.2)]:
        model.rod("steel", (x, 0, z), (x, 2.3, z), 0.03, 8)
    for x, z, material in [(-3.4, -3.4, "terracotta"), (-3.5, 2.9, "blue"), (3.3, -3.3, "green"), (-1.9, -2.6, "white")]:
        model.lathe(material, (x, 0, z), [(1.5 * r, 1.5 * h) for r, h in VASE])
    model.box("red", (-4.15, 0.6, -0.8), (0.03, 1.25, 0.8), (0, 0, 16))
    model.box("yellow", (1.7, 0.3, 3.2), (0.6, 0.6, 0.6), (0, 28, 0))
    model.box("green", (-1.4, 0.012, 2.4), (1.6, 0.02, 1.0), (0, 12, 0))
    # A lamp in every other place of the walks, and lanterns in the court.
    lamps, lanterns = [], [(-1.6, 0.9, 1.5), (1.6, 0.9, -1.5), (-3.0, 0.9, -1.6), (1.3, 1.9, 1.4), (3.2, 2.1, 2.2),
                           (-3.6, 1.9, 0.7), (2.4, 1.9, -3.0), (-0.8, 0.6, -3.6)]
    for side in [-1, 1]:
        for i in range(4):
            place, off = (i - 1.5) * 2 * bay, side * (half + walk / 2)
            lamps += [(place, 2.75, off), (off, 2.75, place)]
    scene = """
[camera]
eye = [-4.0, 1.75, 4.9]
target = [1.2, 1.0, -2.0]
vfov_deg = 64
"""
    for number, place in enumerate(lamps + lanterns):
        colour = [(9, 7.2, 4.6), (8, 7.6, 6.8), (9, 6, 3.2)][number % 3]
        colour = [(0.55 if place in lanterns else 0.8) * c for c in colour]
        scene += ('\n[[lights]]\nname = "lamp {}"\ntype = "point"\nposition = [{:.2f}, {:.2f}, {:.2f}]\n'
                  "intensity = [{:.2f}, {:.2f}, {:.2f}]\n").format(number + 1, *place, *colour)
    for x, y, z in lanterns:
        model.rod("slate", (x, 0, z), (x, y - 0.1, z), 0.025, 8)
    model.write(folder, "courtyard", scene, background=(0.004, 0.005, 0.009))


SCENES = {scene.__name__: scene for scene in [corridor, blinds, uplight, courtyard]}


def make(folder):
    """Writes all four and returns their scene files by name."""
    folder.mkdir(parents=True, exist_ok=True)
    for scene in SCENES.values():
        scene(folder)
    return {name: folder / f"{name}.toml" for name in SCENES}
