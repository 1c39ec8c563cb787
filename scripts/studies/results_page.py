"""The figures of docs/RESULTS.md and its chart, from docs/results."""

from .page import plot, table
from .program import read_json


def percent(share, digits=1):
    return f"{100 * share:.{digits}f} %"


def mitsuba(figures):
    return table(["scene", "samples a pixel", "mean, glowworm over Mitsuba", "blocks within 3 %", "95 % of blocks within"], [
        [r["scene"], f"{r['spp']:,}", f"{r['mean_ratio']:.4f}", percent(r["blocks_within_3_percent"]), percent(r["block_p95"], 2)]
        for r in figures["rows"]])


def reference(figures):
    return table(["scene", "mean, renderer over path tracer", "blocks within 5 %", "95 % of blocks within", "valid VPLs", "escaped"], [
        [r["scene"], f"{r['mean_ratio']:.4f}", percent(r["within_5_percent"]), percent(r["p95_relative_error"], 2), f"{r['valid']:,}", f"{r['escaped']:,}"]
        for r in figures["rows"]])


def clamp(figures):
    return table(["scene", "512 VPLs", "512, clamp off", "65,536 VPLs", "65,536, clamp off"], [
        [r["scene"], *(f"{r[f'{vpls} {bound}']:.3f}" for vpls in [512, 65536] for bound in ["default", "off"])] for r in figures["rows"]])


def convergence(figures):
    """A row for every fourfold number; the chart has all."""
    curves, slopes = figures["curves"], figures["slopes"]
    ways = [(key, sequence) for key in ["rmse", "mae"] for sequence in ["sobol", "random"]]
    rows = [[f"{count:,}", *(f"{curves[sequence][i][key]:.4f}" for key, sequence in ways)] for i, count in enumerate(figures["counts"]) if i % 2 == 0]
    rows.append(["slope", *(f"{slopes[sequence][key]:.2f}" for key, sequence in ways)])
    return table(["VPLs", "RMSE", "RMSE, random", "MAE", "MAE, random"], rows)


def curve(figures, file):
    lines = [([(count, point["rmse"]) for count, point in zip(figures["counts"], figures["curves"][sequence])],
              {"marker": marker, "label": f"{sequence}: slope {figures['slopes'][sequence]['rmse']:.2f}"})
             for sequence, marker in [("sobol", "o"), ("random", "s")]]
    plot(file, lines, title="cornell-box", xlabel="VPLs", ylabel="RMSE of the irradiance, W/m²", xscale="log", yscale="log")


def temporal(figures):
    def shown(row, key):
        return f"{row[key]:.3g}" if key != "mean_ratio" else f"{row[key]:.3f}"

    return table(["scene", "T", *figures["keys"]], [[r["scene"], r["sets"], *(shown(r, key) for key in figures["keys"])] for r in figures["rows"]])


def speed(figures):
    return table(["scene", "Mitsuba's variant", "glowworm, s", "Mitsuba, s", "times as fast", "of three runs"], [
        [r["scene"], r["variant"], f"{r['seconds'][0]:.1f}", f"{r['seconds'][1]:.1f}", f"{r['ratios'][1]:.2f}", f"{r['ratios'][0]:.2f} to {r['ratios'][2]:.2f}"]
        for r in figures["rows"]])


def metrics(figures):
    """The last line of the comparison, which counts what differs."""
    lines = figures["table"].strip().splitlines()
    return f"{len(lines) - 2} figures compared: {lines[-1]}"


def figures(folder):
    """Draws the chart, and gives the texts of the page by their marks."""
    found = {}
    for text in [mitsuba, reference, clamp, convergence, temporal, speed, metrics]:
        measured = read_json(folder / f"{text.__name__}.json")
        if measured:
            found[text.__name__] = text(measured)
            if text is convergence:
                curve(measured, folder / "convergence.svg")
    return found
