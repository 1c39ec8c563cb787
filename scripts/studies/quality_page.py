"""The figures of docs/QUALITY.md, from docs/quality."""

from .page import columns, table
from .program import read_json

SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room",
          "corridor", "blinds", "uplight", "courtyard"]
# Heading, figure and its format.
ERRORS = [("relMSE", "relmse", ".4f"), ("trimmed", "trimmed_relmse", ".4f"), ("HDR-FLIP", "flip", ".3f"), ("SSIM", "ssim", ".3f"),
          ("mean", "mean_ratio", ".3f"), ("brightest block", "brightest_block", ".2f"), ("pattern", "pattern", ".2f"),
          ("noise", "noise", ".4f")]
COSTS = [("ms", "ms", ".1f"), ("rays a pixel", "rays", ".2f"), ("efficiency", "efficiency", ".1f"),
         ("trimmed", "trimmed_efficiency", ".1f")]
STEADINESS = [("spread", "spread", ".3f"), ("deviation", "deviation", ".3f"), ("typical deviation", "typical_deviation", ".3f")]
MOTION = [("HDR-FLIP", "flip", ".3f"), ("mean", "mean_ratio", ".3f"), ("mottling", "mottling", ".1f"), ("flicker", "flicker", ".3f"),
          ("rays", "rays", ".2f")]
PIXELS = [("clipped", "any"), ("clipped", "all"), ("still", "black"), ("still", "lone"), ("moving", "black"), ("moving", "lone")]


def read(file):
    """The figures of a scene, with its efficiency."""
    row = read_json(file)
    for name in ["", "trimmed_"]:
        row[f"{name}efficiency"] = 1000 / (row[f"{name}relmse"] * row["ms"])
    return row


def line(scene, file):
    """One line for the terminal."""
    row = read(file)
    return f"{scene}: " + ", ".join(f"{head} {row[key]:{form}}" for head, key, form in ERRORS + COSTS)


def motion(figures):
    def cells(row):
        return [" / ".join(f"{row[way][key]:{form}}" for way in ["default", "16x"]) for _, key, form in MOTION]

    head = ["scene", *(head for head, _, _ in MOTION), "noise", "path tracer (samples)"]
    return table(head, [[scene, *cells(row), f"{row['noise']:.3f}", f"{row['reference']['flip']:.3f}, {row['reference']['mottling']:.1f} "
                         f"({row['reference']['samples']})"] for scene, row in figures["rows"].items()])


def pixels(figures):
    rows = [[scene, *(f"{100 * row[part][key]:.2f}" for part, key in PIXELS)] for scene, row in figures["rows"].items()]
    return table(["scene", "clipped, any", "all", "still: black", "lone", "moving: black", "lone"], rows)


def convergence(figures):
    first = next(iter(figures["rows"].values()))
    head = ["scene", *(f"{step['frames']:,}" for step in first["frames"]), "mean", "samples of the reference"]
    return table(head, [[scene, *(f"{step['flip']:.3f}" for step in row["frames"]), f"{row['frames'][-1]['mean_ratio']:.4f}", f"{row['spp']:,}"]
                        for scene, row in figures["rows"].items()])


def textures(figures):
    return columns(figures["rows"], [("one frame", "frame", ".3f"), ("mean of 16", "mean", ".3f")], first="")


def equal_time(figures):
    rows = []
    for row in figures["rows"]:
        ours, theirs = row["glowworm"], row["mitsuba"]
        rows.append([row["scene"], theirs["samples"], *(f"{theirs[key]:.3f}" for key in ["flip", "hdr_flip"]),
                     ours["frames"], *(f"{ours[key]:.3f}" for key in ["flip", "hdr_flip"])])
    return table(["scene", "Mitsuba: samples a pixel", "FLIP", "HDR-FLIP", "glowworm: frames", "FLIP", "HDR-FLIP"], rows)


def figures(folder):
    """The texts of the page by their marks."""
    found = {}
    for name, text in {"motion": motion, "pixels": pixels, "convergence": convergence, "textures": textures, "equal-time": equal_time}.items():
        measured = read_json(folder / f"{name}.json")
        if measured:
            found[name] = text(measured)
            found[f"{name}-commit"] = measured.get("commit", "")
    rows = {scene: read(folder / f"{scene}.json") for scene in SCENES if (folder / f"{scene}.json").exists()}
    if rows:
        first = next(iter(rows.values()))
        found |= {"scenes": columns(rows, ERRORS), "scenes-commit": first["commit"], "device": f"{first['device']} ({first['driver']})",
                  "costs": columns(rows, COSTS)}
    seeded = {scene: row["steadiness"] for scene, row in rows.items() if "steadiness" in row}
    if seeded:
        found["seeds"] = columns(seeded, STEADINESS)
    return {name: text for name, text in found.items() if text}
