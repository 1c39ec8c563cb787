"""Sections of scripts/study quality that look at single pixels, at textures, and at what a still picture becomes."""

import json

import numpy as np
from PIL import Image

from . import motion
from . import pictures as images
from .motion import MIDDLE, SIZE
from .pictures import LUMINANCE

PICTURES = [*motion.SCENES, "damaged-helmet", "material-grid"]
# Factors below and above which a pixel is called black or lone.
BLACK, LONE = 1 / 4, 4
CONVERGING = ["cornell-box", "sponza", "classroom"]
STILL_FRAMES = [16, 64, 256, 1024]
# The view of the frame that all references are of.
REST = ["--time-step", 0, "--time", MIDDLE / 60]


def around(image):
    """The 3 x 3 pixels around each inner one, along the first axis."""
    height, width = (extent - 2 for extent in image.shape)
    return np.stack([image[y:y + height, x:x + width] for y in range(3) for x in range(3)])


def bounced(picture):
    """Luminance of all light that does not come straight from a light."""
    return np.maximum(images.layer(picture, "colour") - images.layer(picture, "direct"), 0) @ LUMINANCE


def outliers(picture, reference):
    """Shares of pixels that are black or lone and bright. The reference's pixel and the median around must both say so, as a
    reference has noise; pixels in which it has hardly any light do not count."""
    ours, theirs = bounced(picture), bounced(reference)
    median = np.median(around(np.pad(theirs, 1, mode="edge")), 0)
    counted = np.minimum(theirs, median) > images.DARK * theirs.mean()
    black = counted & (ours < BLACK * np.minimum(theirs, median))
    lone = counted & (ours > LONE * np.maximum(theirs, median))
    return {"black": float(black.mean()), "lone": float(lone.mean())}


def clipped(shown, layers):
    """Shares of pixels with any channel, and with all, at 255, without those that show a light, the sky, or their edges."""
    pixels = np.asarray(Image.open(shown))[..., :3]
    lit = (images.channels(layers, "emission").max(2) > 0) | (images.channels(layers, "instance")[..., 0] < 0)
    near = around(np.pad(lit, 1)).any(0)
    return {"any": float(((pixels == 255).any(2) & ~near).mean()), "all": float(((pixels == 255).all(2) & ~near).mean())}


def pixels(study):
    """Clipped, black and lone bright pixels of twelve pictures, still and in motion."""
    rows = study.rows("pixels")
    shown, still = study.folder / "shown.png", study.folder / "still.exr"
    for scene in study.chosen(PICTURES):
        file = motion.moving(study, scene)
        expected, _, _ = motion.reference(study, scene, MIDDLE)
        study.render(file, shown, SIZE, *REST, "--frames", MIDDLE + 1)
        study.render(file, still, SIZE, *REST, "--frames", MIDDLE + 1, "--antialiasing", "none")
        moved, _ = study.frames(file, SIZE, MIDDLE, *motion.MOVES)
        rows[scene] = {"clipped": clipped(shown, still), "still": outliers(still, expected),
                       "moving": outliers(moved[-1], expected)}
        print(scene, json.dumps(rows[scene]), flush=True)
        study.keep("pixels", {"size": SIZE, "rows": rows})


def convergence(study):
    """What a still picture becomes: errors after so many frames."""
    rows = study.rows("convergence")
    for scene in study.chosen(CONVERGING):
        file = motion.moving(study, scene)
        expected, spp, _ = study.reference(file, SIZE, scene=scene, frame=MIDDLE, spp=8 * study.options.spp)
        rows[scene] = {"spp": spp, "frames": []}
        for frames in STILL_FRAMES:
            study.render(file, study.rendered, SIZE, *REST, "--frames", frames, "--antialiasing", "none")
            compared = study.run("compare", study.rendered, expected)
            rows[scene]["frames"].append({"frames": frames, **{key: compared[key] for key in ["flip", "mean_ratio", "relmse"]}})
        print(scene, json.dumps(rows[scene]), flush=True)
        study.keep("convergence", {"size": SIZE, "rows": rows})


def variance(one, other):
    """What the 3 x 3 pixels around each inner one vary in both pictures: if their noise is independent, it is not in it."""
    one, other = (around(picture @ LUMINANCE) for picture in [one, other])
    return ((one - one.mean(0)) * (other - other.mean(0))).mean(0)


def checkerboard(folder):
    """A floor of squares of 62 cm seen at 80 degrees from its normal."""
    squares = (np.indices((256, 256)) // 32).sum(0) % 2
    Image.fromarray(np.where(squares == 0, 40, 230).astype(np.uint8)).save(folder / "checkerboard.png")
    (folder / "checkerboard.mtl").write_text("newmtl floor\nKd 1 1 1\nmap_Kd checkerboard.png\n")
    (folder / "checkerboard.obj").write_text("mtllib checkerboard.mtl\nusemtl floor\nv -10 0 10\nv 10 0 10\nv 10 0 -10\n"
                                             "v -10 0 -10\nvt 0 0\nvt 4 0\nvt 4 4\nvt 0 4\nf 1/1 2/2 3/3 4/4\n")
    file = folder / "checkerboard.toml"
    file.write_text('[[models]]\nname = "floor"\npath = "checkerboard.obj"\n[[instances]]\nmodel = "floor"\n'
                    '[camera]\neye = [0, 1.042, 5.909]\ntarget = [0, 0, 0]\nvfov_deg = 30\n'
                    '[[lights]]\ntype = "point"\nposition = [0, 5, 0]\nintensity = [9, 9, 9]\n')
    return file


# What is looked at: a scene and the heights, in its unit, between which its horizontal surfaces count.
TEXTURES = {"checkerboard at 80 degrees": ("checkerboard", -1, 1), "floor of sponza": ("sponza", -0.5, 0.5),
            "desks of classroom": ("classroom", 0.6, 0.9)}
TEXTURE_SIZE = "640x360"
# Positions in a pixel that antialiasing goes through.
JITTERS = 16


def textures(study):
    """Local contrast of textures over the path tracer's, which averages the full image over each pixel."""
    rows = study.rows("textures")
    for name, (scene, low, high) in TEXTURES.items():
        file = checkerboard(study.folder / "scenes") if scene == "checkerboard" else study.file(scene)
        pair = [study.reference(file, TEXTURE_SIZE, scene, spp=64, seed=seed, pixel_filter="box", bounces=0)[0]
                for seed in [0, 1]]
        frames, _ = study.frames(file, TEXTURE_SIZE, JITTERS - 1, "--time-step", 0, "--indirect", "none")
        height = around(images.channels(pair[0], "position")[..., 1])
        # Surfaces that are level, without edges nearby.
        level = (np.ptp(height, 0) < 0.002) & (height.min(0) > low) & (height.max(0) < high)
        inner = around(np.pad(level, 1)).all(0)
        albedos = [images.layer(frame, "albedo") for frame in frames]
        expected = variance(*(images.layer(picture, "albedo") for picture in pair))[inner].mean()
        rows[name] = {"pixels": int(inner.sum())} | {
            key: float(np.sqrt(variance(albedo, albedo)[inner].mean() / expected))
            for key, albedo in [("frame", albedos[-1]), ("mean", np.mean(albedos, 0))]}
        print(name, json.dumps(rows[name]), flush=True)
        study.keep("textures", {"size": TEXTURE_SIZE, "rows": rows})
