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
UNTOLD = ["slots", "stale", "invalidated", "shot"]

HEAD = """# Quality of the indirect light

The irradiance alone against the path tracer (`glowworm reference`, paths through pixel centres): default settings, 2 bounces,
nothing moves; {size}, {device} ({driver}). These commands write this page:

```sh
scripts/study-quality               # --help lists the options, such as --seeds 8 for a table of other seeds
scripts/equal-time                  # a table of pictures after one second, beside Mitsuba
```

The last four scenes are made by `scripts/study_scenes.py`: a corridor with its light far away, a room behind blinds, a light that
shines at the ceiling, an open court with 24 lights.

## Error

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


def write(docs):
    """Writes the page from the available figures."""
    files = {scene: docs / "quality" / f"{scene}.json" for scene in SCENES}
    rows = {scene: read(file) for scene, file in files.items() if file.exists()}
    if not rows:
        return
    first = next(iter(rows.values()))
    parts = [HEAD.format(**{key: first[key] for key in ["size", "device", "driver"]}, turns=len(first["turns"]),
                         errors=by_scene(rows, ERRORS), costs=by_scene(rows, COSTS, ["VPLs"], vpls))]
    seeded = {scene: row for scene, row in rows.items() if "steadiness" in row}
    if seeded:
        steady = by_scene({scene: row["steadiness"] for scene, row in seeded.items()}, STEADINESS)
        parts.append(SEEDS.format(seeds=max(row["seeds"] for row in seeded.values()), table=steady))
    timed = docs / "quality" / "equal-time.json"
    if timed.exists():
        parts.append(equal_time(json.loads(timed.read_text())))
    (docs / "QUALITY.md").write_text("\n".join([*parts, strips(rows)]))
