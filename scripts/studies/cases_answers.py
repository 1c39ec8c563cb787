"""What the inputs of `scripts/study cases` must give: for each case the input, what is looked at, the right value, and how it is read from a
picture. Metres and watts; the sun of these inputs has 1 W/m^2, so a white wall that faces it has a radiance of 1/pi."""

from dataclasses import dataclass, field
from math import atan2, cos, hypot, pi, radians, sin, tan

import numpy as np
from numpy import arctan, sqrt

NONE = ["--antialiasing", "none"]


@dataclass
class Known:
    """A figure of a picture: it is right if it is within this share of `scale`, which is the right value unless given."""
    file: str
    what: str
    right: float
    probe: object
    view: list = field(default_factory=list)
    size: str = "64x64"
    frames: int = 64
    spp: int = 256
    time: float = None
    within: float = 0.02
    scale: float = None
    why: str = ""
    render: list = field(default_factory=list)
    reference: list = field(default_factory=list)

    def __str__(self):
        return f"{self.right:.4g}"

    def __post_init__(self):
        self.scale = abs(self.right) if self.scale is None else self.scale
        self.tolerance = f"{self.within:g} of {self.scale:.3g}: {self.why}" if self.why else ""


@dataclass
class Loads:
    """Inputs (patterns) that are all read, or refused, with a message that has one pattern and not the other; within a megabytes of memory if given."""
    file: str
    what: str
    says: str = ""
    silent: str = "panicked|checkerboard|could not|not glTF 2.0"
    refused: bool = False
    megabytes: int = None
    tolerance = ""

    def __str__(self):
        return ("refused" if self.refused else "loads") + (f", below {self.megabytes} MB" if self.megabytes else "")


def look(eye, target, vfov, *more):
    return ["--eye", eye, "--target", target, "--vfov", vfov, *more]


# Ways to read a picture.

def at(name, point, radius=0.05, channel=None):
    """The mean of a layer around a point of the scene: luminance, or one channel."""
    return lambda p: (p.lum(name) if channel is None else p[name][..., channel])[p.near(point, radius)].mean()


def expected(right, where, name="colour"):
    """The mean of a layer over what it must be at the same places."""
    return lambda p: p.lum(name)[where(p)].mean() / right(p)[where(p)].mean()


def ratio(above, below):
    return lambda p: above(p) / below(p)


def over(probe, other):
    """The same of another input."""
    return lambda p: probe(p) / probe(p.beside(other))


def mean(p):
    return p.lum().mean()


def worst_block(other, side=8):
    """Of the means of blocks over those of another input, the one farthest from 1; blocks that are dark there do not count."""
    def blocks(p):
        return np.array([[block.mean() for block in np.split(row, p.lum().shape[1] // side, 1)] for row in np.split(p.lum(), p.lum().shape[0] // side)])

    def probe(p):
        ours, theirs = blocks(p), blocks(p.beside(other))
        found = (ours / np.maximum(theirs, 1e-30))[theirs > 0.05 * theirs.mean()]
        return found[np.abs(found - 1).argmax()]
    return probe


def share(shown, times=1):
    """The share of the pixels where it is so."""
    return lambda p: times * shown(p).mean()


def front(axis, z):
    """The middle of what is seen in front of a depth."""
    return lambda p: np.nanmean((p.x, p.y)[axis][p.z > z])


def middle_of_light(axis):
    """The mean place of the direct light on surfaces."""
    def probe(p):
        light = np.where(np.isnan(p.x), 0, p.lum("direct"))
        return np.nansum((p.x, p.y)[axis] * light) / light.sum()
    return probe


def rectangle(height, x0, x1, y0, y1):
    """Form factor from a point to a parallel rectangle at a height, with its extents from the point's foot."""
    def corner(x, y):
        a, b = x / height, y / height
        return (a / sqrt(1 + a * a) * arctan(b / sqrt(1 + a * a)) + b / sqrt(1 + b * b) * arctan(a / sqrt(1 + b * b))) / (2 * pi)
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)


def srgb(*values):
    """Linear values of bytes."""
    return [value / 255 / 12.92 if value < 11 else ((value / 255 + 0.055) / 1.055) ** 2.4 for value in values]


def between_texels(name, values, channel=0):
    """The share of the pixels of a surface that have none of these values: a nearest sampler has none."""
    return lambda p: np.mean([min(abs(found - value) for value in values) > 0.005 for found in p[name][..., channel][~np.isnan(p.x)]])


def rim(p):
    """Pixels of a surface whose neighbours in a row or column see none."""
    seen = ~np.isnan(p.x)
    return seen & ~np.logical_and.reduce([np.roll(seen, step, axis) for step in (-1, 1) for axis in (0, 1)])


def flatness(p):
    """How far shading normals are from those of the surface between neighbouring pixels."""
    step = np.diff(p.position, axis=1)
    return np.nanmedian(np.abs((p.normal[:, :-1] * step).sum(2)) / np.linalg.norm(step, axis=2))


def roundness(p):
    """How far shading normals are from those of a ball about the origin."""
    return np.nanmedian(np.linalg.norm(p.normal - p.position / np.linalg.norm(p.position, axis=2, keepdims=True), axis=2))


def evenness(name, of):
    """The 20th part of a surface that is darkest over its median."""
    return lambda p: np.percentile(p.lum(name)[of(p)], 5) / np.median(p.lum(name)[of(p)])


def spline(t, axis):
    """Where the rotation of cubicspline.gltf takes what is 1.5 m out."""
    start, end = (1 + 2 * t) * (1 - t) ** 2, t * t * (3 - 2 * t)
    z = 2 * t * (1 - t) ** 2 + sqrt(0.5) * end + 2 * t * t * (t - 1)
    turn = 2 * atan2(z, start + sqrt(0.5) * end)
    return 1.5 * (cos(turn), sin(turn))[axis]


def cosine(p):
    """Between the axis of the lamp of 10, one metre above the floor, and the ray to what is seen."""
    return 1 / sqrt(1 + p.x ** 2 + p.z ** 2)


def spot(p):
    """The floor's radiance below that lamp."""
    return 0.5 / pi * np.maximum((cosine(p) - 0.5) / 0.5, 0) ** 2 * cosine(p) ** 3


def strip(p, low, high):
    """The floor of 09 below the emitter."""
    return (p.x > low) & (p.x < high) & (abs(p.z) < 0.3) & (p.y < 0.01)


def under_halves(p):
    return 5 * rectangle(0.1, -1 - p.x, -p.x, -0.5 - p.z, 0.5 - p.z)


def under_ball(p, centre=(2, 0.7, 0), radius=0.5):
    """The radiance of the floor of 16 in the light of the ball, were it round."""
    distance = np.linalg.norm(p.position - centre, axis=2)
    return 0.5 * 15 * (centre[1] - p.y) / distance * (radius / distance) ** 2


def ring(p, low, high):
    """The floor of 16 around the place under the ball."""
    distance = np.hypot(p.x - 2, p.z)
    return (p.y < 0.01) & (distance >= low) & (distance < high)


BELOW, ABOVE, SIDE = look("0,-0.6,0.95", "0,0.1,-.2", 90), look("0,0.6,0.95", "0,-0.1,-.2", 90), look("0,0,0.95", "0,0,-1", 90)
WALL, SQUARE, FAR = look("0,0,6", "0,0,0", 40), look("0,0,6", "0,0,0", 18.9), look("0,0,8", "0,0,0", 40)
ASIDE = look("4,0,4", "0,0,-.5", 40)
EDGE = {"view": look("1,0,6", "1,0,0", 9.5), "size": "512x128", "frames": 2, "spp": 2, "render": NONE, "within": 0.01, "scale": 1}
TEXEL = {"view": look("0.5,0.5,3", "0.5,0.5,0", 20), "frames": 4, "spp": 16, "render": NONE}
SHEET = look("0,.3,.001", "0,3,0", 10)
DOWN = look("0,.3,.001", "0,0,0", 4)
MOVES = {"view": FAR, "size": "96x96", "frames": 2, "spp": 2, "render": NONE, "within": 0.02, "scale": 1}
POSTER = {"view": look("2,1,10", "0,0,0", 14), "frames": 4, "spp": 4, "render": NONE}
PICTURE = {"view": look("0,0,3", "0,0,0", 20), "size": "8x8", "frames": 2, "spp": 2, "render": NONE, "scale": 1}
OBJ = {"view": WALL, "size": "192x192", "frames": 2, "spp": 4, "render": NONE}
UNDER = look("0,0.08,1.0", "0,0.03,0", 70)
PIXELS = "edges lie between pixels"
STEEP = {"within": 0.05, "why": "steep there"}
DIM = "170 times darker than beside it"
NOISE = "noise in the worst place"
SPOTS = {"within": 0.1, "why": "noise that falls with more frames"}
WORST = {"within": 0.05, "why": NOISE}
STEPS, RED, GREY = srgb(30, 90, 150, 210), srgb(200, 60, 30), srgb(100, 100, 100)


def colour(*right):
    """The greatest error in the middle of a picture, over its brightest channel: channels may share an exponent."""
    return lambda p: np.abs(p["colour"][3:5, 3:5] - right).max() / max(right)


CASES = {
    "01-emitter-both-sides": [
        Known("double.gltf", "emitter from below", 10, at("colour", (0, 0, 0), 0.1), BELOW),
        Known("double.gltf", "emitter from above", 10, at("colour", (0, 0, 0), 0.1), ABOVE),
        *[Known(file, "ceiling over floor", 1, ratio(at("colour", (0.5, 1, -0.5), 0.3), at("colour", (0.5, -1, -0.5), 0.3)), SIDE)
          for file in ["double.gltf", "double.toml"]],
        Known("single.gltf", "emitter from above", 10, at("colour", (0, 0, 0), 0.1), ABOVE),
        Known("single.gltf", "pixels of it from below", 0, share(lambda p: p.near((0, 0, 0), 0.2)), BELOW, scale=1),
    ],
    "02-back-faces": [
        Known("single.gltf", "the box inside, in the light of the lamp inside", 5 * 0.4 / 0.65 ** 1.5 * 0.8 / pi, at("direct", (0, 0, 0.3), 0.06, 0),
              look("0,0,4", "0,0,0", 30)),
        Known("double.gltf", "the near wall, in the sun", 0.5 / pi, at("direct", (0, 0, 1), 0.1), look("0,0,4", "0,0,0", 30)),
    ],
    "03-mask-vertex-alpha": [
        Known("mask.gltf", "height of what is left", 1, lambda p: p.y[p.z > -0.5].max() + 1, WALL, "96x192", frames=2, spp=4, render=NONE, within=0.025, why=PIXELS),
        Known("mask.gltf", "wall behind the part that is cut", 0.5 / pi, at("direct", (0.9, 0.6, -1)), ASIDE),
        Known("mask.gltf", "wall in the shadow of what is left", 0, at("direct", (0.9, -0.6, -1)), ASIDE, scale=0.5 / pi),
        *[Known(file, "middle of the quad, red", 0.5 * alpha * 0.8 / pi + (1 - 0.5 * alpha) ** 2 * 0.5 / pi,
                lambda p: p["direct"][30:34, 30:34, 0].mean(), WALL) for file, alpha in [("blend.gltf", 1), ("blend999.gltf", 0.999)]],
    ],
    "04-cutoff-limits": [Known(f"{file}.gltf", "share of the picture that the quad fills", right, share(lambda p: p.z > -0.5), SQUARE, "32x32",
                               frames=2, spp=4, render=NONE, scale=1)
                         for file, right in [("cutoff0", 1), ("cutoff1_0", 1 / 16), ("cutoff1_1", 0)]],
    "05-mask-edge": [Known(f"cutoff{name}.gltf", "edge, m", right, lambda p: p.x[p.z > -0.5].min(), why="a pixel is 8 mm", **EDGE)
                     for name, right in [("0_25", 0.75), ("0_5", 1), ("0_75", 1.25)]],
    "06-texture-transform": [
        *[Known(file, f"texel (3, 1), {name}", value, at("colour", (0.3125, 0.375, 0), 0.04, channel), **TEXEL)
          for file in ["base.gltf", "emissive1.gltf"] for name, channel, value in [("red", 0, STEPS[3]), ("green", 1, STEPS[1])]],
        *[Known(file, "share of pixels between texels", 0, between_texels("colour", STEPS), **TEXEL, scale=1) for file in ["base.gltf", "emissive1.gltf"]],
        Known("metalrough.gltf", "texel (3, 1), what is no metal and enters it", 0.96 * (1 - 210 / 255), at("albedo", (0.3125, 0.375, 0), 0.04), **TEXEL),
        Known("normal.gltf", "texel (3, 1), in the sun", 1 / hypot(1, 2 * 210 / 255 - 1, 2 * 90 / 255 - 1) / pi, at("direct", (0.3125, 0.375, 0), 0.04), **TEXEL),
        Known("normal.gltf", "colour over direct light: flat surfaces see nothing of themselves", 1, ratio(mean, lambda p: p.lum("direct").mean()),
              **TEXEL | {"frames": 64}),
    ],
    "07-dark-vertex-colours": [
        Known(f"{file}.gltf", f"square {place + 1} in the sun", value / pi, at("direct", (place + 0.5, 0.5, 0), 0.3), look("2,0.5,6", "2,0.5,0", 40), frames=2, spp=4)
        for file, place, value in [("float", 0, 0.2), ("float", 1, 0.02), ("float", 2, 0.002), ("float", 3, 0.001), ("ushort", 2, 131 / 65535), ("ubyte", 2, 1 / 255)]],
    "09-textured-emitter": [
        Known("halves.toml", f"floor at x = {low} to {high}", 1, expected(under_halves, lambda p, low=low, high=high: strip(p, low, high)), UNDER, "96x64",
              render=NONE, **tolerance)
        for low, high, tolerance in [(-0.7, -0.3, {}), (-0.2, -0.1, {}), (-0.1, 0, STEEP), (0, 0.1, STEEP), (0.1, 0.2, STEEP), (0.45, 0.55, {"within": 0.2, "why": DIM})]],
    "10-spot-falloff": [
        Known("inner0.gltf", f"floor where the cosine is {low} to {high}", 1,
              expected(spot, lambda p, low=low, high=high: (cosine(p) > low) & (cosine(p) < high), "direct"), look("1,4,0.01", "1,0,0", 50), frames=2, spp=16, render=NONE)
        for low, high in [(0.9, 1), (0.8, 0.9), (0.7, 0.8), (0.6, 0.7)]],
    "12-names": [
        Loads("tex/[!a]*.gltf tex/apostrophe.gltf", "images of any name"),
        Loads("tex/abs.gltf", "a file of the system is no image", "out of the folder|could not", silent="panicked"),
        Loads("model/*.gltf", "images in a folder beside"),
        Loads("data/*.[gG]*", "data URIs, names of any letters"),
    ],
    "14-far-and-scaled": [
        *[Known(f"{name}.toml", what, 1, probe, size="48x48", frames=64, render=NONE, **tolerance)
          for name in ["far1e4", "far1e5", "mm", "km", "small1e6"]
          for what, probe, tolerance in [("mean over that of the origin", over(mean, "base.toml"), {}),
                                         ("worst block over that of the origin", worst_block("base.toml"), WORST)]],
        Known("bright.toml", "below the small emitter", 1e6 * 0.5 * rectangle(1, -0.01, 0.01, -0.01, 0.01), at("colour", (0, 0, 0), 0.1), size="48x48"),
        *[Known(f"{name}.gltf", "red in the place of the poster", 0.8 / pi, at("direct", (0, 0, 0), 0.9, 0), **POSTER)
          for name in ["poster0_001", "poster0_0001", "poster2em05"]],
    ],
    "16-light-that-stays": [
        Known("rest.toml", f"floor {low} to {high} m from under the ball, {frames} frames", 0.975, expected(under_ball, lambda p, low=low, high=high: ring(p, low, high)),
              size="48x48", frames=frames, render=NONE, within=0.03, why="320 triangles are less than a ball")
        for frames in (16, 64) for low, high in [(0, 0.4), (0.4, 0.8), (0.8, 2)]],
    "18-furnace-lowpoly": [
        Known(f"{name}.toml", what, 1, probe, size="48x48", render=NONE, reference=["--bounces", 4], **tolerance)
        for name in ["rough0", "rough0_5", "rough1", "lambert"] for what, probe, tolerance in [
            ("mean of the ball", lambda p: p.lum()[~np.isnan(p.x)].mean(), {}), ("mean of its rim", lambda p: p.lum()[rim(p)].mean(), {}),
            ("darkest 20th part of the rim", lambda p: np.percentile(p.lum()[rim(p)], 5), SPOTS),
            ("brightest 20th part of the rim", lambda p: np.percentile(p.lum()[rim(p)], 95), SPOTS)]],
    "21-motion": [
        Known("scale-step-hides.gltf", "cube is seen at 0.5 s, x", 0, front(0, 0.4), time=0.5, **MOVES),
        Known("scale-step-hides.gltf", "pixels of the cube at 1.5 s", 0, share(lambda p: p.z > -1), time=1.5, **MOVES),
        *[Known("cubicspline.gltf", f"{'xy'[axis]} at {t} s", spline(t, axis), front(axis, 0.25), time=t, **MOVES) for t in (0.25, 0.75) for axis in (0, 1)],
        *[Known("starts-at-5.gltf", f"x at {t} s (it ends at 7 s and begins again)", x, front(0, 0.25), time=t, **MOVES) for t, x in [(0, -1), (6, 0), (8, -1)]],
        Known("two-animations.gltf", "x at 0.75 s", 0.5, front(0, 0.25), time=0.75, **MOVES),
        Known("two-animations.gltf", "y at 0.75 s", 0, front(1, 0.25), time=0.75, **MOVES),
        Known("channel-without-node.gltf", "x at 0.75 s", 0.5, front(0, 0.25), time=0.75, **MOVES),
        *[Known("camera-child.gltf", f"x in the middle of the picture at {t} s", 2 * t, lambda p: p.x[:, p.x.shape[1] // 2 - 1:][:, :2].mean(), time=t,
                **MOVES | {"view": []}) for t in (0, 0.9)],
    ],
    "22-skins": [Known(f"{file}.gltf", f"middle of the mesh, {'xy'[axis]}", right, front(axis, -1), **MOVES)
                 for file in ["joint-moves-mesh-node-does-not", "morph-weights-mesh"] for axis, right in [(0, 1.5), (1, 0.5)]],
    "24-images": [
        *[Known(f"{name}.gltf", "error of its colour", 0, colour(*right), **PICTURE) for name, right in [
            ("grey8", GREY), ("greyalpha", GREY), ("palette-trns", srgb(200, 40, 90)), ("onebit", (1, 1, 1)), ("rgb16", srgb(128, 64, 32)),
            ("grey16", [400 / 65535 / 12.92] * 3), ("jpeg", srgb(199, 60, 29)), ("jpeg-cmyk", RED), ("jpeg-exif180", srgb(199, 60, 29)),
            ("gamma-chunk", GREY), ("chrm", RED), ("1x1", RED), ("1x16384", RED), ("webp-no-ext", RED), ("emission-grey8", GREY)]],
        Loads("truncated.gltf zero-bytes.gltf gif.gltf", "says what is wrong", "could not be decoded|empty", silent="panicked"),
    ],
    "25-obj": [
        *[Known(f"{name}.obj", "area, m^2", area, share(lambda p: p.z > -0.5, (12 * tan(radians(20))) ** 2), within=0.03, why=PIXELS, **OBJ)
          for name, area in [("concave", 4 - 1.6 ** 2), ("negative", 4), ("continuation", 4), ("utf16be", 4), ("bom", 4)]],
        *[Known(f"{name}.obj", what, value, at("albedo", (x, 0, 0), 0.017, channel), **OBJ, scale=1, within=0.05, why="between texels within a pixel") for name, what, value, x, channel in [
            ("usemtl-space", "red", 0.8, 0, 0), ("crlf", "green", 0.8, 0, 1), ("vertex-colours", "green of red", 0, 0, 1),
            ("map-options", "-s and -o: the green texel, green", srgb(250)[0], -0.875, 1), ("map-options", "-s and -o: the green texel, red", 0, -0.875, 0),
            ("map-clamp", "-clamp: the last texel, green", srgb(250)[0], 0.5, 1), ("map-clamp", "-clamp: the last texel, red", srgb(250)[0], 0.5, 0)]],
        Known("smooth-off.obj", "normals off the facets", 0, flatness, **OBJ, scale=1),
        Known("smooth-1.obj", "normals off the ball", 0, roundness, **OBJ, scale=1),
    ],
    "27-many-nodes-bare": [Loads("*.gltf", "in 6 GB of addresses", megabytes=300)],
    "28-files": [
        Loads("bom*.obj anim-*.gltf palette.obj morph-noview.gltf vertex-colours.obj utm.obj image-no-mime.gltf", "whole or in part", silent="panicked|not glTF 2.0"),
        Loads("texture-no-source.gltf", "loads"),
        Loads("light-behind.gltf", "says that it is dark", "dark|behind"),
        Loads("scene-empty.gltf", "has nothing in it", "no triangles|no meshes", refused=True),
        Known("utm.obj", "dark pixels (the 20th part) of a face under the sky over its median", 1, evenness("colour", lambda p: p.z > 5400019.9), render=NONE,
              within=0.05, why=NOISE),
    ],
    "29-mirrored-root-moves": [Known(f"{file}.gltf", "middle of the spot, x", x, middle_of_light(0), time=0.5,
                                     view=look("0,0,3", "0,0,-2", 50), size="96x96", frames=4, spp=64)
                               for file, x in [("spot-plain", -2 / sqrt(3)), ("second-spot-mirrored", 2 / sqrt(3))]],
    "30-hdr-exr-layouts": [
        Known("hdr-exposure2.toml", "over the plain one: EXPOSURE divides", 1, over(mean, "hdr-plain.toml"), size="32x32", frames=4, spp=4),
        Known("exr-data-lower-half.toml", "upper half of the picture", 0, lambda p: p.lum()[:8].mean(), size="32x32", frames=4, spp=4, scale=1),
        Known("exr-data-lower-half.toml", "lower half over the plain one", 1, over(lambda p: p.lum()[24:].mean(), "exr-plain.toml"), size="32x32", frames=4, spp=4),
    ],
    "31-many-sheets": [
        Known("ceiling8.gltf", "emitter through 8 sheets", 0.95 ** 8, mean, SHEET, "32x32"),
        Known("ceiling16.gltf", "emitter through 16 sheets", 0.95 ** 16, mean, SHEET, "32x32"),
        Known("sun16.gltf", "floor below 16 sheets in the sun", 0.95 ** 16 / pi, at("direct", (0, 0, 0), 0.1), look("0,.3,.001", "0,0,0", 40), "32x32"),
    ],
    "32-emitter-blends": [
        Known("opaque.gltf", "floor", 10 * rectangle(1, -0.5, 0.5, -0.5, 0.5), mean, DOWN),
        Known("blend-half.gltf", "floor", 5 * rectangle(1, -0.5, 0.5, -0.5, 0.5), mean, DOWN),
    ],
    "33-small-in-huge": [Known(f"{file}.toml", f"{what} over that of alone.toml", 1, probe, **tolerance) for file in ["dome1e4", "ground1e5"]
                         for what, probe, tolerance in [("mean", over(mean, "alone.toml"), {}),
                                                        ("worst block", worst_block("alone.toml"), WORST)]],
    "34-bumps": [Known(file, "colour over direct light: a flat floor sees nothing of itself", 1, ratio(mean, lambda p: p.lum("direct").mean()),
                       look("0,6,.001", "0,0,0", 20)) for file in ["flat.gltf", "ripples45.gltf"]],
    "35-sealed-room": [Known("zero.toml", f"brightest pixel after {frames} frames", 0, lambda p: p.lum().max(), scale=1, within=0.001, frames=frames, spp=16,
                             render=["--direct", "hard"]) for frames in (4, 64)],
}
