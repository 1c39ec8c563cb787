"""Renders small inputs whose pictures are known, by virtual point lights (the default), by paths and SVGF, and by the path tracer, and prints what is
right beside what was found. Inputs of which only loading is asked are read by the path tracer. Exit code 1 where a figure is off.

The inputs are no part of the repository: FOLDER has a folder for each case (cases_answers.py names them and says what is right).
"""

import functools
import os
import re
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from .cases_answers import CASES, Loads
from .pictures import LUMINANCE, channels, layer
from .program import Failed, Program, parser, progress

METHODS = {
    "VPLs": ["render"],
    "paths + SVGF": ["render", "--indirect", "paths", "--denoise", "svgf"],
    "reference": ["reference", "--pixel-filter", "center"],
}
SECONDS = 300
# Of memory, for inputs that are only loaded: too little for what grows with the square of something.
ADDRESSES = 6 << 30


class Picture:
    """The layers of a picture: `p["direct"]` as height x width x 3, `p.lum("direct")` its luminance; `p.x`, `p.y`, `p.z` are not a number where
    nothing is seen."""

    def __init__(self, file, beside):
        self.file, self.beside = file, beside

    @functools.cache
    def __getitem__(self, name):
        return layer(self.file, name)

    def lum(self, name="colour"):
        return self[name] @ LUMINANCE

    @functools.cached_property
    def position(self):
        seen = channels(self.file, "instance") >= 0
        return np.where(seen, channels(self.file, "position"), np.nan)

    x = property(lambda self: self.position[..., 0])
    y = property(lambda self: self.position[..., 1])
    z = property(lambda self: self.position[..., 2])

    @functools.cached_property
    def normal(self):
        return channels(self.file, "normal")

    def near(self, point, radius):
        return np.linalg.norm(self.position - point, axis=2) < radius


class Pictures:
    """Renders inputs, each once for the same options."""

    def __init__(self, program, folder):
        self.program, self.folder, self.made = program, folder, {}

    def of(self, method, case, known, file):
        command, *settings = METHODS[method]
        options = [*settings, "--size", known.size, *known.view]
        if command == "render":
            options += ["--frames", known.frames, *known.render]
            options += ["--time", known.time, "--time-step", 0] if known.time is not None else []
        else:
            options += ["--spp", known.spp, *known.reference]
            options += ["--time-step", "1/60", "--frame", round(60 * known.time)] if known.time is not None else []
        key = (command, case, file, *map(str, options))
        if key not in self.made:
            picture = self.program.folder / f"{len(self.made)}.exr"
            self.program.start(command, self.folder / case / file, "--layers", *options, "--out", picture, timeout=SECONDS)
            self.made[key] = Picture(picture, lambda other: self.of(method, case, known, other))
        return self.made[key]


def few_addresses():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))


def loads(pictures, case, known):
    """What became of loading the inputs, and whether all went right: how they ended, the memory, what was said."""
    files = [file for pattern in known.file.split() for file in sorted((pictures.folder / case).glob(pattern))]
    wrong = []
    for file in files:
        with tempfile.TemporaryFile("w+") as said:
            command = ["reference", file, "--size", "8x8", "--spp", "1", "--out", pictures.program.folder / "loaded.exr"]
            run = subprocess.Popen([pictures.program.binary, *command], stdout=said, stderr=said, preexec_fn=few_addresses)
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            said.seek(0)
            text = said.read()
        megabytes = usage.ru_maxrss / 1024
        expected = run.returncode == int(known.refused) and re.search(known.says, text) and not re.search(known.silent, text)
        if not expected or known.megabytes and megabytes > known.megabytes:
            wrong.append(f"{file.name} (exit {run.returncode}, {megabytes:.0f} MB)")
            progress(f"{file}: {text}")
    found = f"{len(files) - len(wrong)} of {len(files)}" + (f", not {', '.join(wrong)}" if wrong else "")
    return ["", "", found], bool(files) and not wrong


def measured(pictures, case, known):
    """What each method finds, and whether it is right."""
    found, good = [], True
    for method in METHODS:
        try:
            value = float(known.probe(pictures.of(method, case, known, known.file)))
            found.append(f"{value:.4g}")
            good &= abs(value - known.right) <= known.within * known.scale
        except (Failed, subprocess.TimeoutExpired, ValueError) as failed:
            progress(f"{case}, {known.file}: {failed}")
            found.append("fails")
            good = False
    return found, good


def main():
    made = parser("cases", __doc__)
    made.add_argument("folder", type=Path, metavar="FOLDER", help="has the folders of the cases")
    made.add_argument("cases", nargs="*", metavar="CASE", help="names or numbers of cases; otherwise all")
    options = made.parse_args()
    chosen = {case: rows for case, rows in CASES.items() if not options.cases or any(case.startswith(name) for name in options.cases)}
    if not chosen:
        raise Failed(f"no such case; there are {', '.join(CASES)}")
    off = missing = 0
    print("| case | what | right | VPLs | paths + SVGF | reference | verdict |\n|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory(prefix="glowworm-cases-") as made_in:
        pictures = Pictures(Program(options.glowworm, made_in), options.folder)
        for case, rows in chosen.items():
            if not (options.folder / case).is_dir():
                missing += 1
                progress(f"{case}: there is no such folder in {options.folder}")
                continue
            for known in rows:
                found, good = (loads if isinstance(known, Loads) else measured)(pictures, case, known)
                off += not good
                verdict = ("right" if good else "OFF") + (f" (within {known.tolerance})" if known.tolerance else "")
                print(f"| {case} | {known.file}: {known.what} | {known} | {' | '.join(found)} | {verdict} |", flush=True)
    print(f"\n{off} of {sum(map(len, chosen.values()))} are off" + (f"; {missing} cases have no folder" if missing else ""))
    return 1 if off or missing else 0
