"""Runs glowworm for the studies and keeps what it made; also the options that studies share."""

import argparse
import functools
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# A scene file names models that these write, so its pictures depend on them as well.
SCENE_SOURCES = b"".join(file.read_bytes() for file in sorted(Path(__file__).parent.glob("*_scenes.py")))


class Failed(Exception):
    """A command that failed, with what it said."""


class Program:
    """Runs the binary; the folder keeps pictures and reports by what made them."""

    def __init__(self, binary, folder):
        self.binary, self.folder = Path(binary).absolute(), Path(folder)
        if not os.access(self.binary, os.X_OK):
            raise Failed(f"--glowworm {binary}: there is no such program; build it by cargo build --release")
        self.folder.mkdir(parents=True, exist_ok=True)

    @functools.cached_property
    def build(self):
        return hashlib.sha256(self.binary.read_bytes()).hexdigest()[:16]

    def start(self, command, *arguments, timeout=None):
        """Runs a command to its end."""
        done = subprocess.run([self.binary, command, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True, timeout=timeout)
        if done.returncode != 0:
            raise Failed(f"glowworm {command} {' '.join(map(str, arguments))}: {done.stderr.strip()}")

    def run(self, command, *arguments, report=None, timeout=None):
        """The command's report. Commands that run at the same time need reports of different names."""
        file = self.folder / f"{report or command}-{os.getpid()}.json"
        self.start(command, *arguments, "--json", file, timeout=timeout)
        figures = json.loads(file.read_text())
        file.unlink()
        return figures

    def kept(self, suffix, *what):
        """The file for something that is made once; scene files count by their content."""
        parts = [part.read_bytes() + SCENE_SOURCES if isinstance(part, Path) and part.exists() else str(part).encode() for part in what]
        return self.folder / (hashlib.sha256(b"\n".join(parts)).hexdigest()[:24] + suffix)

    def once(self, make, *what):
        """The figures that `make` returns, measured once for these parts."""
        file = self.kept(".json", *what)
        if not file.exists():
            # Another run may use the same folder.
            partial = self.folder / f"partial-{os.getpid()}.json"
            partial.write_text(json.dumps(make()))
            partial.replace(file)
        return json.loads(file.read_text())

    def reference(self, scene, *options):
        """The path tracer's picture with its layers, and its report; rendered once."""
        picture = self.kept(".exr", "reference", scene, *options)
        report = self.once(lambda: self.run("reference", scene, "--layers", *options, "--out", picture, "--resume"), "report", scene, *options)
        return picture, report

    def export(self, scene, out, *options):
        """The report of an export for Mitsuba."""
        self.start("export", scene, *options, "--out", out)
        return json.loads((out / "glowworm-export.json").read_text())


def write_json(file, figures):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n")


def read_json(file):
    return json.loads(file.read_text()) if file.exists() else None


def progress(*what):
    print(*what, file=sys.stderr, flush=True)


def parser(name, description, sections=None, **defaults):
    """The options that a study has a default for: scenes, size, spp, turns; and those of all."""
    listed = "\n".join(f"  {key:12} {section.__doc__}" for key, section in (sections or {}).items())
    made = argparse.ArgumentParser(prog=f"scripts/study {name}", description=description, formatter_class=argparse.RawDescriptionHelpFormatter,
                                   epilog=f"sections:\n{listed}" if sections else None)
    if sections:
        made.add_argument("sections", nargs="*", metavar="SECTION", choices=[[], *sections], help="otherwise all")
    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    helps = {"scenes": ("A,B", "names"), "size": ("WxH", "size of the pictures"), "spp": ("N", "samples a pixel of the references"),
             "turns": ("N", "turns, of which the fastest counts")}
    for key, value in defaults.items():
        kind = (lambda text: text.split(",")) if key == "scenes" else type(value)
        made.add_argument(f"--{key}", type=kind, default=value, metavar=helps[key][0],
                          help=f"{helps[key][1]} ({','.join(value) if key == 'scenes' else value})")
    made.add_argument("--glowworm", type=Path, metavar="BINARY", default=ROOT / target / "release" / "glowworm",
                      help="the program to be measured (%(default)s)")
    made.add_argument("--cache", type=Path, default=caches / "study", metavar="DIR", help="keeps what was made (%(default)s)")
    made.add_argument("--out", type=Path, default=ROOT / "docs", metavar="DIR", help="folder of pages and figures (%(default)s)")
    made.add_argument("--page-only", action="store_true", help="measure nothing, bring the page's figures up to date")
    return made
