"""Generates docs/QUALITY.md from the figures in docs/quality."""

import json

SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room",
          "corridor", "blinds", "uplight", "courtyard"]
# Most frames of the table of one second.
MOST_FRAMES = 32

# Heading, figure and its format.
ERRORS = [("relMSE", "relmse", ".4f"), ("trimmed", "trimmed_relmse", ".4f"), ("HDR-FLIP", "flip", ".3f"), ("SSIM", "ssim", ".3f"),
          ("mean", "mean_ratio", ".3f"), ("brightest block", "brightest_block", ".2f"), ("pattern", "pattern", ".2f"),
          ("noise", "noise", ".4f")]
COSTS = [("ms", "ms", ".1f"), ("rays a pixel", "rays", ".2f"), ("efficiency", "efficiency", ".1f"),
         ("trimmed", "trimmed_efficiency", ".1f")]
STEADINESS = [("spread", "spread", ".3f"), ("deviation", "deviation", ".3f"), ("typical deviation", "typical_deviation", ".3f")]
# Counters that are told elsewhere or that concern moving scenes.
UNTOLD = ["slots", "stale", "invalidated", "shot", "useful"]
MOTION = [("HDR-FLIP", "flip", ".3f"), ("mean", "mean_ratio", ".3f"), ("mottling", "mottling", ".1f"), ("flicker", "flicker", ".3f"),
          ("rays", "rays", ".2f")]

HEAD = """# Quality of the indirect light

The irradiance alone against the path tracer (`glowworm reference`, paths through pixel centres): default settings, 2 bounces,
{device} ({driver}). These commands write this page:

```sh
scripts/study-quality               # --help lists sections and options, such as --seeds 8 for a table of other seeds
scripts/equal-time                  # adds a table of pictures after one second, beside Mitsuba
```

Four scenes are made by `scripts/study_scenes.py`: `corridor` with its light far away, a room behind `blinds`, an `uplight` that
shines at the ceiling, an open `courtyard` with 24 lights.
"""

SCENE_ERRORS = """## Scenes

Nothing moves, but frames are those of motion (`--still-frames 0`): the last of 33, {size}. References have {samples} samples a pixel.
Commit {commit}.

{errors}

- **relMSE, HDR-FLIP, SSIM, mean**: of the irradiance, as `glowworm compare` has them (SSIM at an exposure that brings 95 % of the
  pixels below 0.8); mean is the mean luminance over the reference's.
- **trimmed**: relMSE without the worst 0.1 % of the pixels; one bright pixel where it is dark may outweigh all others.
- **brightest block**: of the blocks of 8 x 8 pixels the greatest mean over the reference's (blocks above 2 % of the picture's mean).
- **pattern**: power of the error at periods of 4 pixels over that at neighbouring periods; 0.5 to 1.5 where interleaving leaves none.
- **noise**: the part of the relMSE that is due to noise of the reference, estimated with another one.

## Cost

{costs}

- **ms**: sum of the passes of a frame, median over the last 16 of 33 frames, the fastest of {turns} turns.
- **rays a pixel**: shadow rays of the shaders for each pixel of a frame, mean over the same frames.
- **efficiency**: 1 / (relMSE x seconds): how good a picture a second buys; trimmed, of the trimmed relMSE.
- **VPLs**: slots by what they hold, of all slots.
"""

IN_MOTION = """## In motion

The camera turns by 30 degrees a second; in the playroom lamps and objects move. Means over frames 32, 64 and 96 of 1/60 s,
{size}, against the path tracer's frames of {spp} samples a pixel; commit {commit}. Each cell: default / 16 times the samples (`{options}`).

{table}

- **mottling**: error of display luminance (exposure as in SSIM, sRGB) at periods of 8 to 64 pixels, root mean square, in steps of 8 bits.
- **flicker**: mean absolute change of the irradiance from frame to frame at the same surface points, over its mean.
- **rays**: rays a pixel of a frame, mean over frames 32 to 96.
- **noise**: HDR-FLIP of two of the path tracer's frames with different seeds: what 256 samples leave, which every cell before it holds in part.
- **path tracer**: HDR-FLIP and mottling of as many of its samples a pixel as take the time of a frame on the same cores, at least one.
"""

ANIMATIONS = """Default, 16 times the samples, path tracer (128 samples a pixel), at one exposure (`scripts/study-quality animations`):

{pictures}
"""

PIXELS = """## Single pixels

Share of the pixels in percent, {size}, scene's view after 64 frames, still and with the turning camera. **Clipped**: any channel, or all, at
255, where no lamp, sky or edge of them is seen. **Black**, **lone**: light that does not come straight from a lamp is below a quarter,
or above four times, of the reference's pixel and of the median of the 3 x 3 around it, where that is above 2 % of the picture's mean.

{table}
"""

CONVERGENCE = """## Standing still

Whole pictures, {size}, after so many still frames, against the path tracer: HDR-FLIP, and mean luminance over the reference's at the last.

{table}
"""

TEXTURES = """## Textures

Local contrast, {size}: standard deviation of the 3 x 3 pixels around each of `albedo`, root mean square, over that of the path tracer,
which averages the image over the pixel; of one frame, which samples a pixel once, and of the mean of 16, which antialiasing shows.

{table}
"""

SEEDS = """## Other seeds

Mean irradiance of blocks of 32 x 32 pixels over {seeds} seeds: **spread**, largest less smallest, and standard **deviation**, both over
the block's mean and of the worst block; **typical deviation**, root mean square over the blocks.

{table}
"""

ONE_SECOND = """## One second

The whole picture after one second on {cores} cores: by Mitsuba {mitsuba} ({variant}), with as many samples a pixel, and by
the renderer on {device}, with as many frames from the first on (at most {most}; after 16 a still picture stays as it is),
{size}. Loading and compiling are left out, highlights too. Each is compared with the path tracer's picture of its own pixel filter;
FLIP is of tone-mapped pictures (95 % of the pixels below 0.8, sRGB). Last: whose FLIP and whose HDR-FLIP is lower.

{table}
"""


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def read(file):
    """The figures of a scene, with its efficiency."""
    row = json.loads(file.read_text())
    for name in ["", "trimmed_"]:
        row[f"{name}efficiency"] = 1000 / (row[f"{name}relmse"] * row["ms"])
    return row


def line(scene, file):
    """One line for the terminal."""
    row = read(file)
    return f"{scene}: " + ", ".join(f"{head} {row[key]:{form}}" for head, key, form in ERRORS + COSTS)


def by_scene(rows, columns, head=(), more=lambda row: []):
    """A table with a row for each scene; `more` gives a row's other cells."""
    lines = [[scene, *(f"{row[key]:{form}}" for _, key, form in columns), *more(row)] for scene, row in rows.items()]
    return table(["scene", *(column[0] for column in columns), *head], lines)


def vpls(row):
    shown = [f"{name} {count}" for name, count in row["vpls"].items() if name not in UNTOLD]
    return ["; ".join(sorted(shown, reverse=True)) + f"; of {row['vpls']['slots']}"]


def equal_time(figures):
    rows = []
    for row in figures["rows"]:
        ours, theirs = row["glowworm"], row["mitsuba"]
        cells = [row["scene"], f"{theirs['samples']}", f"{theirs['flip']:.3f}", f"{theirs['hdr_flip']:.3f}"]
        cells += [f"{ours['frames']}", f"{ours['flip']:.3f}", f"{ours['hdr_flip']:.3f}"]
        rows.append(cells + ["glowworm" if ours[key] < theirs[key] else "Mitsuba" for key in ["flip", "hdr_flip"]])
    head = ["scene", "Mitsuba: samples a pixel", "FLIP", "HDR-FLIP", "glowworm: frames", "FLIP", "HDR-FLIP", "closer: FLIP", "HDR-FLIP"]
    return ONE_SECOND.format(**figures, most=MOST_FRAMES, device=figures["rows"][0]["glowworm"]["device"], table=table(head, rows))


def strips(rows):
    parts = [f"**{scene}**\n\n![{scene}: glowworm, reference](quality/{scene}.jpg)\n" for scene in rows]
    return "## Beside the reference\n\nIndirect irradiance at one exposure: the renderer, then the path tracer.\n\n" + "\n".join(parts)


def motion(figures, docs):
    def cells(row, key, form):
        return " / ".join(f"{row[way][key]:{form}}" for way in ["default", "16x"])

    rows = []
    for scene, row in figures["rows"].items():
        traced = row["reference"]
        rows.append([scene, *(cells(row, key, form) for _, key, form in MOTION), f"{row['noise']:.3f}" if "noise" in row else "",
                     f"{traced['flip']:.3f}, {traced['mottling']:.1f} ({traced['samples']})"])
    part = IN_MOTION.format(**figures, table=table(["scene", *(head for head, _, _ in MOTION), "noise", "path tracer (samples)"], rows))
    shown = [f"![{file.stem}: default, 16 times the samples, path tracer](quality/{file.name})"
             for file in sorted((docs / "quality").glob("*.gif"))]
    return part + ("\n" + ANIMATIONS.format(pictures="\n\n".join(shown)) if shown else "")


def pixels(figures, _):
    rows = [[scene, *(f"{100 * row[part][key]:.2f}" for part, key in
                      [("clipped", "any"), ("clipped", "all"), ("still", "black"), ("still", "lone"), ("moving", "black"), ("moving", "lone")])]
            for scene, row in figures["rows"].items()]
    head = ["scene", "clipped, any", "all", "still: black", "lone", "moving: black", "lone"]
    return PIXELS.format(**figures, table=table(head, rows))


def convergence(figures, _):
    first = next(iter(figures["rows"].values()))
    head = ["scene", *(f"{step['frames']:,}" for step in first["frames"]), "mean", "samples of the reference"]
    rows = [[scene, *(f"{step['flip']:.3f}" for step in row["frames"]), f"{row['frames'][-1]['mean_ratio']:.4f}", f"{row['spp']:,}"]
            for scene, row in figures["rows"].items()]
    return CONVERGENCE.format(**figures, table=table(head, rows))


def textures(figures, _):
    rows = [[name, f"{row['frame']:.3f}", f"{row['mean']:.3f}"] for name, row in figures["rows"].items()]
    return TEXTURES.format(**figures, table=table(["", "one frame", "mean of 16"], rows))


def write(docs):
    """Writes the page from the available figures."""
    files = {scene: docs / "quality" / f"{scene}.json" for scene in SCENES}
    rows = {scene: read(file) for scene, file in files.items() if file.exists()}
    if not rows:
        return
    first = next(iter(rows.values()))
    parts = [HEAD.format(**first)]
    for section in [motion, pixels, convergence, textures]:
        file = docs / "quality" / f"{section.__name__}.json"
        if file.exists():
            parts.append(section(json.loads(file.read_text()), docs))
    samples = " to ".join(f"{count:,}" for count in sorted({row["spp"] for row in rows.values()}))
    parts.append(SCENE_ERRORS.format(size=first["size"], commit=first["commit"], samples=samples, turns=len(first["turns"]),
                                     errors=by_scene(rows, ERRORS), costs=by_scene(rows, COSTS, ["VPLs"], vpls)))
    seeded = {scene: row for scene, row in rows.items() if "steadiness" in row}
    if seeded:
        steady = by_scene({scene: row["steadiness"] for scene, row in seeded.items()}, STEADINESS)
        parts.append(SEEDS.format(seeds=max(row["seeds"] for row in seeded.values()), table=steady))
    timed = docs / "quality" / "equal-time.json"
    if timed.exists():
        parts.append(equal_time(json.loads(timed.read_text())))
    (docs / "QUALITY.md").write_text("\n".join([*parts, strips(rows)]))
