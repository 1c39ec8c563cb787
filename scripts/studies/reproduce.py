"""Measures what four theses claim, claim by claim, and brings docs/REPRODUCTION.md up to date. What was measured is kept in the
cache, so that it can be stopped and goes on.
"""

import hashlib
import statistics
import time

from . import page, reproduce_scenes
from .program import Failed, Program, parser, progress, read_json, write_json
from .reproduce_path_claims import CLAIMS

# Scenes whose frames take long.
LARGE = ["atrium", "atrium-drapery", "cathedral", "meeting-room", "flight", "playroom"]
VERDICTS = ["confirmed", "refuted", "not testable"]


class Lab(Program):
    """Measures what claims ask for; what glowworm reports is kept by command, scene and program."""

    def __init__(self, options):
        super().__init__(options.glowworm, options.cache)
        self.out, self.size = options.out, options.size
        self.most_seeds = 2 if options.ci else 3
        self.machine = {}
        self.commit = ""

    def scene(self, name):
        """A built-in scene, or the file of one of reproduce_scenes; and what tells it from others."""
        text = reproduce_scenes.text_of(name)
        if text is None:
            return name, name
        path = self.folder / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.toml"
        path.write_text(text)
        return path, text

    def seeds(self, scene):
        """Fewer where frames take long."""
        return range(min(self.most_seeds, 2) if scene.split(":")[0] in LARGE else self.most_seeds)

    def render(self, scene, options, frames, seed=0):
        """The report of a run, and the picture of its last frame, with layers."""
        path, text = self.scene(scene)
        arguments = [*options.split(), "--size", self.size, "--frames", frames, "--seed", seed, "--exposure", "0", "--layers"]
        key = ["render", text, *arguments]
        out = self.kept(".exr", self.build, *key)
        report = self.once(lambda: self.run("render", path, "--out", out, *arguments), self.build, *key)
        self.machine = {name: report[name] for name in ["device", "driver"]}
        self.commit = report["commit"]
        return report, out

    def reference_of(self, scene, bounces, frame=0, spp=128):
        return self.reference(self.scene(scene)[0], "--size", self.size, "--bounces", bounces, "--frame", frame, "--spp", spp,
                              "--pixel-filter", "center")[0]

    def errors(self, picture, reference, layer=None):
        options = ["--layer", layer] if layer else []
        return self.once(lambda: self.run("compare", picture, reference, *options), "compare", picture.name, reference.name, *options)

    def compared(self, scene, options, frames, bounces=2, layer=None):
        """The metrics against the reference of the last frame's moment, a list over the seeds."""
        reference = self.reference_of(scene, bounces, frames - 1 if reproduce_scenes.moves(scene) else 0)
        return [self.errors(self.render(scene, options, frames, seed)[1], reference, layer) for seed in self.seeds(scene)]

    def reports(self, scene, options, frames):
        return [self.render(scene, options, frames, seed)[0] for seed in self.seeds(scene)]


def figure(value):
    """A mean with its standard deviation over the seeds."""
    if not isinstance(value, list):
        return str(value)
    if len(value) == 1:
        return f"{value[0]:.3g}"
    return f"{statistics.fmean(value):.3g} ± {statistics.stdev(value):.1g}"


def figures(results):
    """The texts of the page by their marks."""
    rows, machine = results["rows"], results["machine"]
    lines = [[row["claim"], row["section"], row["ran"], row["figure"], row["verdict"] + (f": {row['why']}" if row.get("why") else ""), f"`{name}`"]
             for name, row in rows.items()]
    commits = sorted({row["commit"] for row in rows.values() if row.get("commit")})
    return {"counts": f"{len(rows)} claims: " + ", ".join(f"{sum(row['verdict'] == verdict for row in rows.values())} {verdict}" for verdict in VERDICTS),
            "measured": f"{machine['device']} ({machine['driver']}), commit {', '.join(commits)}, {results['size']}, {results['seeds']} seeds",
            "claims": page.table(["claim", "section", "what was run", "figure", "verdict", "name"], lines)}


def measure(lab, wanted, is_ci, save):
    rows, begun = {}, time.monotonic()
    for name, claim in CLAIMS.items():
        if (wanted and name not in wanted) or (is_ci and not claim.in_ci):
            continue
        progress(f"{name} ...")
        lab.commit = ""
        found = claim.measure(lab)
        figures = "; ".join(f"{what} {figure(value)}" for what, value in found.figures.items())
        rows[name] = {"claim": claim.text, "section": claim.section, "ran": claim.ran, "figure": figures, "verdict": found.verdict,
                      "why": found.why, "commit": lab.commit}
        progress(f"{name}: {found.verdict}: {figures} ({time.monotonic() - begun:.0f} s)")
        save(rows)
    return rows


def check(lab, wanted, known):
    """Measures a part, and fails if a verdict is another than the page's."""
    rows = measure(lab, wanted, True, lambda _: None)
    flipped = [f"{name}: {row['verdict']} ({row['figure']}), but the page has {known[name]['verdict']}"
               for name, row in rows.items() if name in known and row["verdict"] != known[name]["verdict"]]
    if flipped:
        raise Failed("verdicts flipped:\n" + "\n".join(flipped))


def main():
    made = parser("reproduce", __doc__, size="96x60")
    made.add_argument("--ci", action="store_true", help="a part, smaller; fails if a verdict is not the page's")
    made.add_argument("--only", type=lambda text: text.split(","), metavar="CLAIM,...", help=", ".join(CLAIMS))
    options = made.parse_args()
    unknown = set(options.only or []) - set(CLAIMS)
    if unknown:
        made.error(f"--only {', '.join(unknown)}: no such claim; known are {', '.join(CLAIMS)}")
    file, text = options.out / "reproduction.json", options.out / "REPRODUCTION.md"
    known = read_json(file) or {"rows": {}}
    if options.page_only:
        # Words of claims are those of reproduce_claims; figures and verdicts are kept.
        for name, row in known["rows"].items():
            row |= {"claim": CLAIMS[name].text, "section": CLAIMS[name].section, "ran": CLAIMS[name].ran}
        write_json(file, known)
        return page.fill(text, figures(known))
    lab = Lab(options)
    if options.ci:
        return check(lab, options.only, known["rows"])

    def save(rows):
        merged = known["rows"] | rows
        results = {"machine": lab.machine or known.get("machine"), "size": lab.size, "seeds": lab.most_seeds,
                   "rows": {name: merged[name] for name in CLAIMS if name in merged}}
        if results["machine"]:
            write_json(file, results)
            page.fill(text, figures(results))

    measure(lab, options.only, False, save)
