"""The page of scripts/study gpu-report, made from its figures."""

from .page import table

# Rays a pixel on paper at the defaults, the camera moving: docs/PERFORMANCE.md.
PAPER_RAYS = {"vpls": "0.4 to 0.9", "vpls, T = 16": "0.4 to 0.9", "preset tonna": "at most 2", "preset tonna, T = 1": "at most 32", "paths, svgf": "at most 6",
              "preset flatval": "at most 8", "preset meijer": "at most 4"}


def problems(results):
    """What does not hold, a sentence each."""
    found = [f"{failed['what']} failed: {failed['message']}" for failed in results["failed"]]
    for name, row in results.get("methods", {}).items():
        if row.get("same_bits") is False:
            found.append(f"{name}: two runs differ")
    for name, row in results.get("means", {}).items():
        if not row["holds"]:
            found.append(f"{name}: the mean is {row['mean_ratio']:.3f} of the reference's")
    return found


def checks(results):
    mark = {True: "yes", False: "no", None: "not run"}
    methods, means = results.get("methods", {}), results.get("means", {})
    rows = []
    for name, row in methods.items():
        mean = means.get(name)
        rows.append([name, mark[row["validated"]], mark[row.get("same_bits")], f"{mean['mean_ratio']:.3f}" if mean else ""])
    return table(["method", "no validation message", "two runs, same bits", "mean / reference"], rows) + "\n"


def rays_of(row, size):
    width, height = map(int, size.split("x"))
    return f"{row['rays'] / (width * height):.2f}" if row["rays"] else ""


def times(results):
    size, runs = results["times"]["size"], results["times"]["runs"]
    rows = []
    for row in runs:
        fps = row.get("frames_a_second")
        plain = row["name"].split(", hardware")[0].split(", software")[0]
        rows.append([row["name"], row["frames"], f"{row['ms']:.2f}", f"{fps:.1f}" if fps else "", rays_of(row, size), PAPER_RAYS.get(plain, ""),
                     f"{row['device_memory'] / 2**20:.0f}"])
    head = ["method", "frames", "ms a frame", "frames a second", "rays a pixel", "on paper", "device memory, MiB"]
    text = table(head, rows) + "\n\n### Passes\n\nMilliseconds, medians; a stage stands before its parts.\n\n"
    for row in runs:
        passes = ", ".join(f"`{name}` {ms:.3f}" for name, ms in row["passes"].items())
        text += f"- **{row['name']}**: {passes}\n"
    return text


def speeds(results):
    rows = []
    for run in results.get("rays_a_second", []):
        for tracer in run["tracers"]:
            rates = sorted(tracer["rates"])
            rows.append([run["kind"], run["query"], tracer["tracer"], f"{rates[len(rates) // 2]:.2f}"])
    return table(["rays", "asked", "tracer", "million a second"], rows) + "\n" if rows else "Not measured.\n"


def page(results):
    device, found = results["device"], problems(results)
    text = f"# {device['name']}\n\n{device['kind']}, driver {device['driver']}, Vulkan {device['vulkan']}, "
    text += "ray queries" if device["ray_query"] else f"no ray queries (lacks {device['ray_query_lacks']})"
    text += f"; commit {results['commit']}; by `scripts/study gpu-report` in {results['seconds']:.0f} s.\n\n"
    text += "Everything that ran holds.\n" if not found else "**Does not hold:**\n\n" + "".join(f"- {line}\n" for line in found)
    if results["skipped"]:
        text += "\nNot run, for lack of time: " + "; ".join(results["skipped"]) + ".\n"
    text += "\n## Checks\n\nThe Cornell box, 96x72.\n\n" + checks(results)
    text += f"\n## Times\n\n{results['times']['scene']}, {results['times']['size']}. Milliseconds: passes of CPU and device, one after another. "
    text += "Frames a second: of the loop, which overlaps both and presents nothing.\n\n" + times(results)
    return text + "\n## Rays\n\nOf real frames, the atrium, 256x256.\n\n" + speeds(results)
