"""Generates docs/QUALITY.md from the figures in docs/quality."""

import json
import math

SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room",
          "corridor", "blinds", "uplight", "courtyard"]
# Of the table of one second.
MOST_FRAMES = 32

COLUMNS = [
    # Heading, figure, its format, whether the mean ratio over the scenes says something.
    ("relMSE", "relmse", ".4f", True),
    ("trimmed", "trimmed_relmse", ".4f", True),
    ("HDR-FLIP", "flip", ".3f", True),
    ("SSIM", "ssim", ".3f", False),
    ("mean", "mean_ratio", ".3f", False),
    ("brightest block", "brightest_block", ".2f", True),
    ("pattern", "pattern", ".2f", False),
]
COSTS = [("ms", "ms", ".1f", True), ("rays a pixel", "rays", ".2f", True), ("efficiency", "efficiency", ".1f", True),
         ("trimmed", "trimmed_efficiency", ".1f", True)]

COLUMN_NOTES = """- **relMSE, HDR-FLIP, SSIM, mean**: of the irradiance, as `glowworm compare` has them (SSIM at an exposure that brings 95 % of the
  pixels below 0.8); mean is the mean luminance over the reference's.
- **trimmed**: relMSE without the worst 0.1 % of the pixels; one bright pixel where it is dark may outweigh all others.
- **brightest block**: of the blocks of 8 x 8 pixels the greatest mean over the reference's (blocks above 2 % of the picture's mean).
- **pattern**: power of the error at periods of 4 pixels over that at neighbouring periods; 0.5 to 1.5 where interleaving leaves none.
- **noise**: the part of both relMSE that is due to noise of the reference, estimated with another one.
"""
COST_NOTES = """- **ms**: sum of the passes of a frame, median over the last 16 of 33 frames, the fastest of {turns} turns; the builds alternate.
- **rays a pixel**: shadow rays of the shaders for each pixel of a frame, mean over the same frames.
- **efficiency**: 1 / (relMSE x seconds): how good a picture a second buys; trimmed, of the trimmed relMSE.
- **VPLs**: slots that hold a VPL, slots whose path left the scene{more}, of all slots.
"""
SEED_NOTES = """Mean irradiance of blocks of 32 x 32 pixels over {seeds} seeds: **spread**, largest less smallest, and standard **deviation**, both over
the block's mean and of the worst block; **typical deviation**, root mean square over the blocks.
"""


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def with_efficiency(figures):
    for build in ["before", "now"]:
        row = figures[build]
        for name in ["", "trimmed_"]:
            row[f"{name}efficiency"] = 1000 / (row[f"{name}relmse"] * row["ms"])
    return figures


def pair(before, now, form, ratio=True):
    """Both values and their ratio."""
    quotient = f" ({now / before:.2f})" if ratio and before else ""
    return f"{before:{form}} → {now:{form}}{quotient}"


def line(scene, figures):
    """One line for the terminal."""
    figures = with_efficiency(figures)
    cells = [f"{head} {pair(figures['before'][key], figures['now'][key], form)}" for head, key, form, _ in COLUMNS + COSTS]
    return f"{scene}: " + ", ".join(cells)


def mean_ratio(rows, key):
    """Geometric mean over the scenes of now over before."""
    ratios = [row["now"][key] / row["before"][key] for row in rows]
    return math.exp(sum(map(math.log, ratios)) / len(ratios))


def compared(studies, columns, head, more):
    """A table with a row for each scene and, last, the mean ratios; `more` gives a row's other cells."""
    lines = [[scene, *(pair(row["before"][key], row["now"][key], form, ratio) for _, key, form, ratio in columns), *more(row)]
             for scene, row in studies.items()]
    means = [f"{mean_ratio(studies.values(), key):.2f}" if ratio else "" for _, key, _, ratio in columns]
    lines.append(["all (geometric mean)", *means, *([""] * len(head))])
    return table(["scene", *(column[0] for column in columns), *head], lines)


def vpls(row):
    """Counters that both builds have, or only the later one; those of moving scenes are left out."""
    shown = [name for name in row["now"]["vpls"] if name not in ["slots", "stale", "invalidated", "shot"]]
    shown.sort(key=lambda name: ["valid", "escaped"].index(name) if name in ["valid", "escaped"] else 2)
    return ["; ".join("{} {}".format(name, " → ".join(str(row[build]["vpls"].get(name, "?")) for build in ["before", "now"]))
                      for name in shown) + f"; of {row['now']['vpls']['slots']}"]


def others(studies):
    """Names of the counters that are there beside the usual ones."""
    usual = {"slots", "valid", "escaped", "stale", "invalidated", "shot"}
    return sorted({name for row in studies.values() for name in row["now"]["vpls"]} - usual)


def seeds(studies):
    with_seeds = {scene: row for scene, row in studies.items() if row["seeds"] > 1}
    if not with_seeds:
        return ""
    keys = ["spread", "deviation", "typical_deviation"]
    rows = [[scene, *(pair(*(row[build]["seeds"][key] for build in ["before", "now"]), ".3f") for key in keys)]
            for scene, row in with_seeds.items()]
    count = max(row["seeds"] for row in with_seeds.values())
    return f"""## Other seeds

{SEED_NOTES.format(seeds=count)}
{table(["scene", "spread", "deviation", "typical deviation"], rows)}
"""


def equal_time(figures):
    builds = [build for build in ["before", "now"] if build in figures["rows"][0]]
    rows = []
    for row in figures["rows"]:
        cells = [row["scene"], f"{row['mitsuba']['samples']}", *(f"{row['mitsuba'][key]:.3f}" for key in ["flip", "hdr_flip"])]
        for build in builds:
            cells += [f"{row[build]['frames']}", *(f"{row[build][key]:.3f}" for key in ["flip", "hdr_flip"])]
        cells += ["glowworm" if row[builds[-1]][key] < row["mitsuba"][key] else "Mitsuba" for key in ["flip", "hdr_flip"]]
        rows.append(cells)
    head = ["scene", "Mitsuba: samples a pixel", "FLIP", "HDR-FLIP"]
    for build in builds:
        head += [f"{build}: frames", "FLIP", "HDR-FLIP"]
    device = figures["rows"][0][builds[-1]]["device"]
    return f"""## One second

The whole picture after one second on {figures['cores']} cores: by Mitsuba {figures['mitsuba']} ({figures['variant']}), with as many samples a pixel, and by
the renderer on {device}, with as many frames from the first on (at most {MOST_FRAMES}; after 16 a still picture stays as it is),
{figures['size']}. Loading and compiling are left out, highlights too. Each is compared with the path tracer's picture of its own pixel filter;
FLIP is of tone-mapped pictures (95 % of the pixels below 0.8, sRGB). Last: whose FLIP and whose HDR-FLIP is lower.

{table([*head, "closer: FLIP", "HDR-FLIP"], rows)}
"""


def strips(studies):
    parts = [f"**{scene}**\n\n![{scene}: before, now, reference](quality/{scene}.jpg)\n" for scene in studies]
    return "## Before, now, reference\n\nIndirect irradiance at one exposure.\n\n" + "\n".join(parts)


def write(docs):
    """Writes the page from the available figures."""
    folder = docs / "quality"
    files = {scene: folder / f"{scene}.json" for scene in SCENES}
    studies = {scene: with_efficiency(json.loads(file.read_text())) for scene, file in files.items() if file.exists()}
    if not studies:
        return
    first = next(iter(studies.values()))
    before, now = first["before"], first["now"]
    more = "".join(f", {name}" for name in others(studies))
    parts = [f"""# Quality of the indirect light

Two builds against the path tracer (`glowworm reference`, paths through pixel centres): the irradiance alone, default settings, 2 bounces,
nothing moves. Before is commit {before['commit']}, now {now['commit']}; {first['size']}, {now['device']} ({now['driver']}). To make this page:

```sh
scripts/study-quality --before BINARY --seeds 8     # a build of the earlier commit; --help lists the options
scripts/equal-time --before BINARY                  # the last table
```

Cells read "before → now (now over before)". The last four scenes are made by `scripts/study_scenes.py`: a corridor with its lamp far
away, a room behind blinds, a lamp that shines at the ceiling, an open court with 24 lamps.

## Error

{compared(studies, COLUMNS, ["noise"], lambda row: [f"{row['noise']:.4f}"])}

{COLUMN_NOTES}
## Cost

{compared(studies, COSTS, ["VPLs"], vpls)}

{COST_NOTES.format(turns=len(now['turns']), more=more)}""", seeds(studies)]
    timed = folder / "equal-time.json"
    if timed.exists():
        parts.append(equal_time(json.loads(timed.read_text())))
    parts.append(strips(studies))
    (docs / "QUALITY.md").write_text("\n".join(part for part in parts if part))
