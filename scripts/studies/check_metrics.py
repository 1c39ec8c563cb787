"""Compares the metrics of `glowworm compare` with those of scikit-image, flip-evaluator and NumPy on pairs of pictures, and prints both;
exit code 1 where a figure differs in its first three digits. With --known-answers it prints the expected figures of the pairs made by code as
tests/metrics/known.rs has them.

The pairs made by code use whole numbers only, so that tests/metrics/pairs.rs makes the very same ones.
"""

import tempfile
from pathlib import Path

import flip_evaluator
import numpy as np
import OpenEXR
from PIL import Image
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from .pictures import first_layer
from .program import Program, parser

WIDTH, HEIGHT = 96, 64
# Largest relative difference that leaves three digits alike.
TOLERANCE = 5e-4
FIGURES = ["mae", "rmse", "relmse", "psnr", "ssim", "flip", "mean_ratio", "mean_relative_error",
           "p95_relative_error", "block_mean", "block_p95", "within_3_percent", "within_5_percent", "luminance_rmse",
           "luminance_ssim"]


# The pairs, as tests/metrics/pairs.rs describes them.

def triangle(n, period):
    return np.abs(n % (2 * period) - period)


def scatter(x, y, channel):
    mask = 0xFFFFFFFF
    h = (x * 73856093 & mask) ^ (y * 19349663 & mask) ^ (channel * 83492791 & mask)
    h ^= h >> 13
    h = h * 0x5BD1E995 & mask
    return h ^ h >> 15


def grid():
    y, x, channel = np.mgrid[0:HEIGHT, 0:WIDTH, 0:3].astype(np.int64)
    return x, y, channel


def base(hdr):
    x, y, channel = grid()
    checker = 48 * ((x // 12 + y // 9) % 2)
    waves = [triangle(3 * x + y, 90) + checker, triangle(2 * x + 5 * y, 110) + checker,
             triangle(7 * x + 2 * y + 40, 200)]
    values = np.choose(channel, waves)
    disc = (x - 60) ** 2 + (y - 30) ** 2 < 150
    if hdr:
        return np.where(disc, 16, 1) * values * values
    return np.minimum(values + 90 * disc, 255)


def noise(values, hdr):
    offset = scatter(*grid()) % 49 - 24
    return values * (64 + offset) // 64 if hdr else np.clip(values + offset, 0, 255)


def blur(values, _):
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)), mode="edge")
    return sum(padded[j:j + HEIGHT, i:i + WIDTH] for j in range(3) for i in range(3)) // 9


def shift(values, _):
    return np.concatenate([values[:, :1], values[:, :-1]], axis=1)


def brightness(values, hdr):
    brighter = values * 9 // 8
    return brighter if hdr else np.minimum(brighter, 255)


def fireflies(values, hdr):
    hit = scatter(*grid()[:2], np.int64(0)) % 97 == 0
    bright = values * 20 + 4096 if hdr else np.minimum(values + 120, 255)
    return np.where(hit, bright, values)


KINDS = [noise, blur, shift, brightness, fireflies]


# Pictures on disk: 0 to 1 for PNG, linear for EXR.

def write(path, values):
    if path.suffix == ".png":
        Image.fromarray(values.astype(np.uint8)).save(path)
    else:
        pixels = np.ascontiguousarray(values / 4096, dtype=np.float32)
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": pixels}).write(str(path))


def read(path):
    if path.suffix == ".png":
        return np.asarray(Image.open(path).convert("RGB"), dtype=np.float32) / np.float32(255)
    return first_layer(path).astype(np.float32)


def made_pairs(folder):
    for suffix, hdr in [(".png", False), (".exr", True)]:
        reference = folder / f"reference{suffix}"
        write(reference, base(hdr))
        for kind in KINDS:
            image = folder / f"{kind.__name__}{suffix}"
            write(image, kind(base(hdr), hdr))
            yield kind.__name__, image, reference


def rendered_pairs(program):
    for suffix in [".png", ".exr"]:
        pictures = [program.folder / f"render-{vpls}{suffix}" for vpls in (64, 1024)]
        for picture, vpls in zip(pictures, ("64", "1024")):
            program.run("render", "cornell-box", "--size", "256x192", "--vpls", vpls, "--seed", vpls, "--exposure", 0, "--out", picture)
        yield "renders", *pictures


# The figures, after other people's programs.

def to_linear(display):
    return np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)


def to_display(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def relative(image, reference, mean):
    return np.abs(image - reference) / np.maximum(reference, 0.01 * mean)


def p95(values):
    return np.percentile(values, 95, method="inverted_cdf")


def block_means(luminance, side=16):
    height, width = luminance.shape
    return np.array([luminance[y:y + side, x:x + side].mean()
                     for y in range(0, height, side) for x in range(0, width, side)])


def expected(image_path, reference_path):
    image, reference = read(image_path), read(reference_path)
    hdr = image_path.suffix == ".exr"
    mode = "HDR" if hdr else "LDR"
    # That function takes the pictures as they are in the file.
    flip = flip_evaluator.evaluate(reference, image, mode, applyMagma=False)[1]
    a, b = image.astype(np.float64), reference.astype(np.float64)
    display_a, display_b = (to_display(a), to_display(b)) if hdr else (a, b)
    weights = np.array([0.2126, 0.7152, 0.0722])
    luminance_a, luminance_b = [(v if hdr else to_linear(v)) @ weights for v in (a, b)]
    mean = luminance_b.mean()
    grey_a, grey_b = display_a @ weights, display_b @ weights
    pixels = relative(luminance_a, luminance_b, mean)
    blocks = relative(block_means(luminance_a), block_means(luminance_b), mean)
    return {
        "mae": np.abs(a - b).mean(),
        "rmse": np.sqrt(((a - b) ** 2).mean()),
        "relmse": ((a - b) ** 2 / (b ** 2 + 0.01)).mean(),
        "psnr": peak_signal_noise_ratio(display_b, display_a, data_range=1),
        "ssim": structural_similarity(display_a, display_b, channel_axis=-1, data_range=1,
                                      gaussian_weights=True, sigma=1.5, use_sample_covariance=False),
        "flip": flip,
        "mean_ratio": luminance_a.mean() / mean,
        "mean_relative_error": pixels.mean(),
        "p95_relative_error": p95(pixels),
        "block_mean": blocks.mean(),
        "block_p95": p95(blocks),
        "within_3_percent": (blocks <= 0.03).mean(),
        "within_5_percent": (blocks <= 0.05).mean(),
        "luminance_rmse": np.sqrt(((grey_a - grey_b) ** 2).mean()),
        "luminance_ssim": structural_similarity(grey_a, grey_b, data_range=1, gaussian_weights=True, sigma=1.5,
                                                use_sample_covariance=False),
    }


def of_glowworm(program, image, reference):
    figures = program.run("compare", image, reference, "--luminance")
    blocks = figures["blocks"]
    return figures | {
        "block_mean": blocks["mean_relative_error"],
        "block_p95": blocks["p95_relative_error"],
        "within_3_percent": blocks["within_3_percent"],
        "within_5_percent": blocks["within_5_percent"],
    }


def agree(name, ours, theirs):
    if name.endswith("ssim"):
        # What is left to perfection says more than a figure close to 1.
        ours, theirs = 1 - ours, 1 - theirs
    return abs(ours - theirs) <= TOLERANCE * abs(theirs)


def print_known_answers(folder):
    for name, image, reference in made_pairs(folder):
        figures = expected(image, reference)
        known = ", ".join(str(float(f"{figures[figure]:.7g}")) for figure in FIGURES)
        print(f'    ("{name}", "{image.suffix[1:]}", [{known}]),')


def check(program):
    differ = 0
    print(f"{'pair':<11}{'kind':<6}{'figure':<21}{'glowworm':>14}{'expected':>14}")
    for name, image, reference in [*made_pairs(program.folder), *rendered_pairs(program)]:
        ours, theirs = of_glowworm(program, image, reference), expected(image, reference)
        for figure in FIGURES:
            good = agree(figure, ours[figure], theirs[figure])
            differ += not good
            print(f"{name:<11}{image.suffix[1:]:<6}{figure:<21}{ours[figure]:>14.6g}{theirs[figure]:>14.6g}"
                  f"{'' if good else '  DIFFERS'}")
    print(f"{differ} figures differ" if differ else "all figures agree to three digits")
    return 1 if differ else 0


def main():
    made = parser("check-metrics", __doc__)
    made.add_argument("--known-answers", action="store_true", help="print the figures of the pairs as tests/metrics/known.rs has them")
    options = made.parse_args()
    with tempfile.TemporaryDirectory(prefix="glowworm-metrics-") as folder:
        return print_known_answers(Path(folder)) if options.known_answers else check(Program(options.glowworm, folder))
