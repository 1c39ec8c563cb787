"""The program of scripts/reproduce: measures what four theses claim, and writes docs/REPRODUCTION.md from docs/reproduction.json."""

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import reproduce_scenes
from reproduce_claims import CLAIMS

PAGE = "docs/REPRODUCTION.md"
FIGURES = "docs/reproduction.json"
# Scenes whose frames take long.
LARGE = ["atrium", "atrium-drapery", "cathedral", "meeting-room", "flight", "playroom"]
VERDICTS = ["confirmed", "refuted", "not testable"]


class Lab:
    """Runs glowworm; what it reports is kept by command, scene and program."""

    def __init__(self, options):
        self.options = options
        self.size = options.size
        self.most_seeds = 2 if options.ci else 3
        self.cache = options.cache
        self.cache.mkdir(parents=True, exist_ok=True)
        self.build = hashlib.sha256(options.glowworm.read_bytes()).hexdigest()[:16]
        self.machine = {}
        self.commit = ""

    def scene(self, name):
        """A built-in scene, or the file of one of reproduce_scenes."""
        text = reproduce_scenes.text_of(name)
        if text is None:
            return name, name
        path = self.cache / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.toml"
        path.write_text(text)
        return path, text

    def run(self, command, *arguments, key):
        name = hashlib.sha256("\n".join([self.build, command, *map(str, key)]).encode()).hexdigest()[:24]
        kept = self.cache / f"{name}.json"
        if not kept.exists():
            # Another run may use the same cache.
            partial = self.cache / f"partial-{os.getpid()}.json"
            done = subprocess.run([self.options.glowworm, command, *map(str, arguments), "--json", partial],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            if done.returncode != 0:
                sys.exit(f"reproduce: error: glowworm {command} {' '.join(map(str, arguments))}: {done.stderr.strip()}")
            partial.replace(kept)
        return json.loads(kept.read_text())

    def picture(self, key):
        return self.cache / (hashlib.sha256("\n".join([self.build, *map(str, key)]).encode()).hexdigest()[:24] + ".exr")

    def seeds(self, scene):
        """Fewer where frames take long."""
        return range(min(self.most_seeds, 2) if scene.split(":")[0] in LARGE else self.most_seeds)

    def render(self, scene, options, frames, seed=0):
        """The report of a run, and the picture of its last frame, with layers."""
        path, text = self.scene(scene)
        arguments = [*options.split(), "--size", self.size, "--frames", frames, "--seed", seed, "--exposure", "0", "--layers"]
        key = ["render", text, *arguments]
        out = self.picture(key)
        report = self.run("render", path, "--out", out, *arguments, key=key)
        self.machine = {name: report[name] for name in ["device", "driver"]}
        self.commit = report["commit"]
        return report, out

    def reference(self, scene, bounces, frame=0, spp=None):
        path, text = self.scene(scene)
        spp = spp or 128
        arguments = ["--size", self.size, "--bounces", bounces, "--frame", frame, "--spp", spp, "--pixel-filter", "center", "--layers"]
        out = self.picture(["reference", text, *arguments])
        if not out.exists():
            self.run("reference", path, "--out", out, *arguments, key=["reference", text, *arguments])
        return out

    def errors(self, picture, reference, layer=None):
        options = ["--layer", layer] if layer else []
        return self.run("compare", picture, reference, *options, key=[picture, reference, *options])

    def compared(self, scene, options, frames, bounces=2, layer=None):
        """The metrics against the reference of the last frame's moment, a list over the seeds."""
        reference = self.reference(scene, bounces, frames - 1 if reproduce_scenes.moves(scene) else 0)
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


def page(results):
    machine = results["machine"]
    rows = results["rows"]
    counts = ", ".join(f"{sum(row['verdict'] == verdict for row in rows.values())} {verdict}" for verdict in VERDICTS)
    commits = ", ".join(sorted({row["commit"] for row in rows.values() if row.get("commit")}))
    text = f"""# What four theses claim, measured

{len(rows)} claims of four theses, each run by the method as its author describes it (`--preset tonna|granja|flatval|meijer`) against the path
tracer: {counts}. Written by

```sh
scripts/reproduce        # --ci: a part, smaller, which fails if a verdict flips
```

{machine['device']} ({machine['driver']}), commits {commits} (docs/reproduction.json has that of each row), {results['size']}, {results['seeds']} seeds, 2 of large scenes; figures are means ± standard deviations
over the seeds. A CPU driver's milliseconds are no GPU's: ratios alone are judged, and what needs a GPU is said to be not testable here
(`scripts/gpu-report` measures it where there is one). HDR-VDP-2 and VMAF are external programs; SSIM and FLIP stand in for them. Models that
the theses used and that code makes here: Sponza as `atrium`, Crytek Sponza as `atrium-drapery`, Sibenik as `cathedral`, Conference as
`meeting-room`. A verdict is computed from the figures by `scripts/reproduce_claims.py`, which states the bounds. A speed-up is
confirmed if it is at least half of the claimed one. T = 16: so many temporal sets; a class: the VPLs that one pixel of the n x n pattern gathers; HPSF and
nHPSF: [PATH-SPACE](PATH-SPACE.md).

- **T**: K. Tonna, *Real-time GI for dynamic environments using temporal filtering*, 2019.
- **G**: P. Granja, *Real Time Hybrid Rendering Techniques*, 2021.
- **F**: H. Flatval, *Denoising Algorithms for Ray Tracing in Real-Time Applications*, 2020.
- **M**: D. Meijer, *Real-time Path Traced Global Illumination for Games by Path Space Filtering*, 2019.

| claim | section | what was run | figure | verdict | command |
|---|---|---|---|---|---|
"""
    for name, row in rows.items():
        verdict = row["verdict"] + (f": {row['why']}" if row.get("why") else "")
        text += f"| {row['claim']} | {row['section']} | {row['ran']} | {row['figure']} | {verdict} | `scripts/reproduce --only {name}` |\n"
    return text


def measure(lab, wanted, is_ci, save):
    rows, begun = {}, time.monotonic()
    for name, claim in CLAIMS.items():
        if (wanted and name not in wanted) or (is_ci and not claim.in_ci):
            continue
        print(f"{name} ...", file=sys.stderr, flush=True)
        lab.commit = ""
        found = claim.measure(lab)
        figures = "; ".join(f"{what} {figure(value)}" for what, value in found.figures.items())
        rows[name] = {"claim": claim.text, "section": claim.section, "ran": claim.ran, "figure": figures, "verdict": found.verdict,
                      "why": found.why, "commit": lab.commit}
        print(f"{name}: {found.verdict}: {figures} ({time.monotonic() - begun:.0f} s)", file=sys.stderr, flush=True)
        save(rows)
    return rows


def parsed(arguments):
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "glowworm" / "reproduce"
    parser = argparse.ArgumentParser(prog="scripts/reproduce", description=__doc__)
    parser.add_argument("--ci", action="store_true", help="a part, smaller; fails if a verdict is not the page's")
    parser.add_argument("--size", default="96x60", metavar="WxH", help="of the pictures; default: 96x60")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="CLAIM,...", help=", ".join(CLAIMS))
    parser.add_argument("--glowworm", type=Path, help="the built binary; otherwise target/release/glowworm")
    parser.add_argument("--cache", type=Path, default=cache, metavar="DIR", help=f"default: {cache}")
    return parser.parse_args(arguments)


def main():
    root = Path(sys.argv[1])
    options = parsed(sys.argv[2:])
    options.root = root
    unknown = set(options.only or []) - set(CLAIMS)
    if unknown:
        sys.exit(f"reproduce: error: --only {', '.join(unknown)}: no such claim; known are {', '.join(CLAIMS)}")
    options.glowworm = (options.glowworm or root / "target/release/glowworm").absolute()
    if not os.access(options.glowworm, os.X_OK):
        sys.exit(f"reproduce: error: --glowworm {options.glowworm}: there is no such program; build it by cargo build --release")
    lab = Lab(options)
    figures = root / FIGURES
    known = json.loads(figures.read_text()) if figures.exists() else {"rows": {}}
    if options.ci:
        rows = measure(lab, options.only, True, lambda _: None)
        flipped = [f"{name}: {row['verdict']} ({row['figure']}), but the page has {known['rows'][name]['verdict']}"
                   for name, row in rows.items() if name in known["rows"] and row["verdict"] != known["rows"][name]["verdict"]]
        if flipped:
            sys.exit("reproduce: error: verdicts flipped:\n" + "\n".join(flipped))
        return

    def save(rows):
        merged = known["rows"] | rows
        results = {"machine": lab.machine or known.get("machine"), "size": lab.size, "seeds": lab.most_seeds,
                   "rows": {name: merged[name] for name in CLAIMS if name in merged}}
        if results["machine"]:
            figures.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
            (root / PAGE).write_text(page(results))

    measure(lab, options.only, False, save)


if __name__ == "__main__":
    main()
