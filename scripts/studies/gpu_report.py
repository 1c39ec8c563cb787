"""Checks a device and measures every method on it, within a budget of seconds: gpu-report.json and gpu-report.md.

Each run is a process of its own, so a lost device costs one run. Only the standard library of Python is needed. What no longer fits
the budget is skipped, and the page says so.
"""

import hashlib
import subprocess
import tempfile
import time
from pathlib import Path

from . import gpu_report_page
from .program import Failed, Program, parser, write_json
from .reproduce_scenes import FLIGHT

# Made by code, so a binary is enough.
MOVING = FLIGHT.replace("SECONDS", "4")

PATHS = "--indirect paths --direct paths"
METHODS = {
    "vpls": "",
    "vpls, soft shadows": "--direct soft",
    "vpls, all gathered": "--pool 512",
    "paths, svgf": PATHS,
    "paths, bmfr": PATHS + " --denoise bmfr",
    "paths, sspsf": PATHS + " --filter sspsf",
    "paths, hpsf": PATHS + " --filter hpsf",
    "paths, nhpsf": PATHS + " --filter nhpsf",
    "paths, a-nhpsf": PATHS + " --filter a-nhpsf",
    "paths, cache": PATHS + " --filter cache",
    "none": "--indirect none",
    "preset tonna": "--preset tonna",
    "preset granja": "--preset granja",
    "preset flatval": "--preset flatval",
    "preset meijer": "--preset meijer",
}
# The mean of still frames is the raw light before filters and denoisers, of as many bounces as the reference's. Whoever has no
# indirect light, or adds up all bounces, is not compared.
COMPARED = ["vpls", "vpls, all gathered", "paths, svgf", "paths, cache", "preset tonna", "preset flatval", "preset meijer"]
TOLERANCE = 0.04
SETS = [1, 4, 8, 16, 32]


class Report(Program):
    """Runs glowworm within what is left of the budget, and collects what came of it."""

    def __init__(self, options, folder):
        super().__init__(options.glowworm, folder)
        self.options = options
        self.begun = time.monotonic()
        self.results = {"skipped": [], "failed": []}
        self.device = ["--device", options.device] if options.device else []

    def left(self):
        return self.options.budget - (time.monotonic() - self.begun)

    def attempt(self, what, arguments, needs, most=120):
        """The JSON of a command and its seconds; none where it failed or would not fit."""
        if self.left() < needs:
            self.results["skipped"].append(what)
            return None
        begun = time.monotonic()
        try:
            report = self.run(*arguments, timeout=max(1, min(most, self.left())))
        except subprocess.TimeoutExpired:
            self.results["skipped"].append(f"{what} (took too long)")
            return None
        except Failed as failed:
            self.results["failed"].append({"what": what, "message": str(failed).splitlines()[-1]})
            return None
        return report | {"wall_s": time.monotonic() - begun}

    def render(self, what, scene, options, needs=3, out="picture.exr"):
        return self.attempt(what, ["render", scene, "--out", self.folder / out, *self.device, *options], needs)


def device_of(report):
    info = report.attempt("info", ["info"], 0)
    if info is None:
        raise Failed(report.results["failed"][0]["message"])
    wanted = report.options.device
    devices = info["devices"]
    named = [device for device in devices if wanted and (wanted == str(device["index"]) or wanted in device["name"])]
    if wanted and not named:
        raise Failed(f"--device {wanted}: there is none; glowworm info lists them")
    used = named[0] if named else next(device for device in devices if device["index"] == info["used"])
    report.results |= {"device": used, "commit": info["commit"]}
    return used


def check_methods(report):
    """Validation, and bit-equality of two runs, at small size."""
    rows = {}
    for name, options in METHODS.items():
        base = ["--size", "96x72", "--frames", "6", *options.split()]
        first = report.render(f"validation of {name}", "cornell-box", [*base, "--validate"])
        if first is None:
            was_run = any(failed["what"] == f"validation of {name}" for failed in report.results["failed"])
            rows[name] = {"validated": False if was_run else None}
            continue
        picture = report.folder / "picture.exr"
        digest = hashlib.sha256(picture.read_bytes()).hexdigest()
        again = report.render(f"second run of {name}", "cornell-box", base)
        same = again is not None and hashlib.sha256(picture.read_bytes()).hexdigest() == digest
        rows[name] = {"validated": True, "same_bits": same if again else None, "wall_s": first["wall_s"]}
    report.results["methods"] = rows


def compare_means(report):
    rows = {}
    for name in COMPARED:
        options = METHODS[name].split()
        bounces = {"preset flatval": "3", "preset meijer": "1"}.get(name, "2")
        # The same sampling: the middle of each pixel.
        still = ["--still-frames", "48", "--frames", "49", "--antialiasing", "none", "--exposure", "0"]
        reference = report.folder / f"reference-{bounces}.exr"
        size = ["--size", "96x72"]
        if not reference.exists():
            traced = report.attempt("reference", ["reference", "cornell-box", *size, "--bounces", bounces, "--spp", "256",
                                              "--pixel-filter", "center", "--out", reference], 5)
            if traced is None:
                break
        options += ["--direct", "hard"] if name.startswith("vpls") else []
        if report.render(f"mean of {name}", "cornell-box", [*options, *size, *still], 5) is None:
            continue
        compared = report.attempt(f"comparison of {name}", ["compare", report.folder / "picture.exr", reference], 1)
        if compared:
            ratio = compared["mean_ratio"]
            rows[name] = {"mean_ratio": ratio, "holds": abs(ratio - 1) < TOLERANCE}
    report.results["means"] = rows


def time_methods(report, size, device):
    """Milliseconds of each pass, and frames a second: of a few frames of every run, then of many of those that fit."""
    scene = report.folder / "atrium-flight.toml"
    scene.write_text(MOVING)
    # What temporal sets gain, from the cheapest on.
    runs = [(name, sets, None) for sets in reversed(SETS) for name in ["vpls", "preset tonna"]]
    runs += [(name, None, None) for name in METHODS]
    if device["ray_query"]:
        runs += [(name, None, tracer) for name in ["vpls", "paths, svgf"] for tracer in ["hardware", "software"]]
    few, many = report.options.frames
    rows, commands = {}, {}
    for name, sets, tracer in runs:
        label = name + (f", T = {sets}" if sets else "") + (f", {tracer} tracer" if tracer else "")
        options = [*METHODS[name].split(), "--size", size, "--exposure", "0"]
        options += ["--temporal-sets", str(sets)] if sets else []
        options += ["--tracer", tracer] if tracer else []
        commands[label] = options
        done = report.render(f"time of {label}", scene, [*options, "--frames", str(few)], 4, "picture.png")
        if done:
            rows[label] = row_of(label, done)
    for label, row in rows.items():
        # Where these do not fit, the few stand, and the page says how many they were.
        needs = row["wall_s"] * many / few
        done = report.left() > needs and report.render(
            f"{many} frames of {label}", scene, [*commands[label], "--frames", str(many)], needs, "picture.png")
        if done:
            rows[label] = row_of(label, done)
    report.results["times"] = {"size": size, "scene": "atrium-flight, the camera moving", "runs": list(rows.values())}


def row_of(label, report):
    median, interval = report["summary"]["median"], report["interval_ms"]
    return {"name": label, "frames": len(report["frames"]), "ms": median["total_ms"], "wall_s": report["wall_s"],
            "frames_a_second": 1000 / interval if interval else None,
            "passes": {key: ms for key, ms in median["passes"].items() if ms > 0},
            "rays": median.get("shadow_rays", median.get("rays")), "device_memory": report["device_memory"]}


def micro(report):
    folder = report.folder / "micro"
    done = report.attempt("rays a second", ["bench", "atrium", "--micro", "--rays", "65536", "--size", "256x256", "--out", folder,
                                        *report.device], 20)
    if done:
        report.results["rays_a_second"] = [
            {"kind": run["kind"], "query": run["query"], "tracers": run["tracers"]}
            for scene in done["scenes"] for run in scene["rays"]]


def main():
    made = parser("gpu-report", __doc__)
    made.add_argument("--device", help="name or index of the device; otherwise the best one")
    made.add_argument("--budget", type=float, default=450, metavar="SECONDS", help="default: 450")
    made.add_argument("--size", metavar="WxH", help="of the timed pictures; default: 1920x1080, on a CPU 160x90")
    made.set_defaults(out=Path("."))
    options = made.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        report = Report(options, Path(folder))
        device = device_of(report)
        is_cpu = device["kind"] == "cpu"
        options.frames = [4, 10] if is_cpu else [8, 104]
        size = options.size or ("160x90" if is_cpu else "1920x1080")
        # Each step ends early enough for those after it.
        whole = options.budget
        for share, step in [(0.4, check_methods), (0.5, compare_means), (0.6, micro)]:
            options.budget = share * whole
            step(report)
        options.budget = whole
        time_methods(report, size, device)
        report.results["seconds"] = time.monotonic() - report.begun
    write_json(options.out / "gpu-report.json", report.results)
    (options.out / "gpu-report.md").write_text(gpu_report_page.page(report.results))
    print(f"{options.out / 'gpu-report.md'}: {report.results['seconds']:.0f} s, "
          f"{len(report.results['failed'])} failed, {len(report.results['skipped'])} skipped")
    return 1 if gpu_report_page.problems(report.results) else 0
