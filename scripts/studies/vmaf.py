"""Measures VMAF v0.6.1 of denoised pictures against their references, on luma alone: hands two sequences of PNGs to ffmpeg's libvmaf, and prints what it found as JSON."""

import argparse
import json
import re
import subprocess
import tempfile
from pathlib import Path

import imageio_ffmpeg

from .program import Failed

MODEL = "vmaf_v0.6.1"
# Luma as Rec. 601 has it, in the whole range of 8 bits; of other planes VMAF reads nothing.
LUMA = "scale=out_color_matrix=bt601:out_range=full,format=yuv444p"


def number(name):
    """By which names are sorted: as texts, but their numbers as numbers."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", name)]


def pictures(name):
    """The PNGs of a folder or of a {frame} pattern, in order."""
    path = Path(name)
    if path.is_dir():
        found = [file for file in path.iterdir() if file.suffix.lower() == ".png"]
    else:
        placeholder = re.search(r"\{frame(:0\d)?\}", path.name)
        if not placeholder:
            raise Failed(f"{name}: neither a folder nor a name with a {{frame}}")
        if not path.parent.is_dir():
            raise Failed(f"{name}: there is no folder {path.parent}")
        before, after = path.name[:placeholder.start()], path.name[placeholder.end():]
        pattern = re.compile(re.escape(before) + r"\d+" + re.escape(after))
        found = [file for file in path.parent.iterdir() if pattern.fullmatch(file.name)]
    if not found:
        raise Failed(f"{name}: there is no .png of this name")
    return sorted(found, key=lambda file: number(file.name))


def measure(denoised, reference):
    """VMAF of each frame."""
    with tempfile.TemporaryDirectory() as folder:
        inputs = []
        for side, files in (("denoised", denoised), ("reference", reference)):
            (Path(folder) / side).mkdir()
            for index, file in enumerate(files):
                (Path(folder) / side / f"{index:06}.png").symlink_to(file.resolve())
            inputs += ["-framerate", "25", "-i", f"{side}/%06d.png"]
        graph = f"[0:v]{LUMA}[a];[1:v]{LUMA}[b];[a][b]libvmaf=model=version={MODEL}:log_fmt=json:log_path=vmaf.json"
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-loglevel", "error", *inputs, "-lavfi", graph,
                   "-f", "null", "-"]
        run = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        log = Path(folder) / "vmaf.json"
        if run.returncode != 0 or not log.exists():
            lines = run.stderr.strip().splitlines() or ["no reason given"]
            raise Failed(f"ffmpeg: {lines[0]}")
        return [frame["metrics"]["vmaf"] for frame in json.loads(log.read_text())["frames"]]


def main():
    parser = argparse.ArgumentParser(prog="scripts/study vmaf", description="VMAF of denoised pictures, as JSON.")
    parser.add_argument("denoised", help="a folder of .png, or a name with a {frame}")
    parser.add_argument("reference", help="likewise, with as many pictures of the same size")
    arguments = parser.parse_args()
    denoised, reference = pictures(arguments.denoised), pictures(arguments.reference)
    if len(denoised) != len(reference):
        raise Failed(f"{arguments.denoised} has {len(denoised)} pictures, {arguments.reference} {len(reference)}")
    frames = measure(denoised, reference)
    report = {"vmaf": sum(frames) / len(frames), "model": MODEL, "ffmpeg": imageio_ffmpeg.get_ffmpeg_version(),
              "frames": [{"picture": str(file), "vmaf": vmaf} for file, vmaf in zip(denoised, frames)]}
    print(json.dumps(report, indent=2))
