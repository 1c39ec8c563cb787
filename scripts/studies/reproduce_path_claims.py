"""The claims of scripts/study reproduce about BMFR and path-space filters: Flatval's and Meijer's. CLAIMS has those of
reproduce_claims as well."""

import json
import statistics

from .reproduce_claims import CLAIMS, Found, above, claim, holds, mean, metric, ratios, times

__all__ = ["CLAIMS"]

# --- Flatval
BMFR, SVGF = "--preset flatval", "--preset flatval --denoise svgf"
BMFR_PASSES = ["indirect_bmfr_accumulate", "indirect_bmfr_fit", "indirect_bmfr_filtered"]
SVGF_PASSES = ["indirect_svgf_temporal", "indirect_svgf_variance", "indirect_svgf_atrous"]
PLACES = {"flight": "Sponza", "cornell-box": "a closed room", "playroom": "a room in motion"}


@claim("f-speed", "F: BMFR is 2.3 to 2.6 times faster than SVGF", "table 5.1", "flight through `atrium`: the denoisers' passes")
def f_speed(lab):
    svgf, bmfr = times(lab.reports("flight", SVGF, 12), SVGF_PASSES), times(lab.reports("flight", BMFR, 12), BMFR_PASSES)
    found = ratios(svgf, bmfr)
    if lab.machine["device"].startswith("llvmpipe"):
        return Found({"times faster on a CPU": found}, "not testable", "BMFR is made for a GPU's shared memory, which a CPU driver has not")
    return Found({"times faster": found}, *holds(mean(found) > 1.5, "less"))


@claim("f-quality", "F: BMFR has less error than SVGF in two scenes of three", "table 5.2",
       "flight through `atrium`, `cornell-box`, `playroom`: RMSE against the reference of the 12th frame")
def f_quality(lab):
    figures, better = {}, 0
    for scene, title in PLACES.items():
        frames = 12 if scene == "flight" else 24
        of = lambda options: metric(lab.compared(scene, options + " --antialiasing none --time-step 0", frames, bounces=3), "rmse") \
            if scene != "flight" else metric(lab.compared(scene, options + " --antialiasing none", frames, bounces=3), "rmse")
        svgf, bmfr = of(SVGF), of(BMFR)
        figures |= {f"{title}: SVGF": svgf, "BMFR" + " " * len(figures): bmfr}
        better += mean(bmfr) < mean(svgf)
    return Found(figures, *holds(better >= 2, f"in {better} of three"))


@claim("f-spikes", "F: SVGF's times have a peak while histories are short, BMFR's have none", "5.1, figure 5.1",
       "`cornell-box`: the first 3 frames over the last 12 of 16, the passes of the variance and of BMFR")
def f_spikes(lab):
    def peak(options, passes):
        found = []
        for report in lab.reports("cornell-box", options, 16):
            ms = [sum(frame["passes"][name] for name in passes) for frame in report["frames"]]
            found.append(statistics.median(ms[:3]) / statistics.median(ms[4:]))
        return found
    svgf, bmfr = peak(SVGF, ["indirect_svgf_variance"]), peak(BMFR, BMFR_PASSES)
    # A ratio of 1.3 is a peak.
    verdict = above(svgf, 1.3, "SVGF's have none")
    if verdict[0] == "confirmed":
        verdict = above([-ratio for ratio in bmfr], -1.3, "BMFR's have one, too")
    return Found({"SVGF": svgf, "BMFR": bmfr}, *verdict)


NEW = "--bmfr-features 1,wx*wx,sqrt(nx),wz*wz,wx*ny,wy*wy,nx,nz,sqrt(ny),wx*wy"


@claim("f-features", "F: its own ten features change SSIM and RMSE by less than 0.001", "5.3, table 5.4",
       "flight through `atrium` with Koskela's features and its own; SSIM for VMAF, of which it claims 1 point more")
def f_features(lab):
    old, new = (lab.compared("flight", options + " --antialiasing none", 12, bounces=3) for options in [BMFR, f"{BMFR} {NEW}"])
    found = metric(old, "ssim"), metric(new, "ssim")
    return Found({"SSIM of Koskela's": found[0], "of its own": found[1]}, *holds(abs(mean(found[0]) - mean(found[1])) < 0.01, "more"))


@claim("f-static", "F: where nothing moves, BMFR flickers less than SVGF", "figure 5.8",
       "the figures of `scripts/study denoisers static`: change of display luminance from frame to frame in three scenes")
def f_static(lab):
    file = lab.out / "denoisers" / "static.json"
    if not file.is_file():
        return Found({}, "not testable", "`scripts/study denoisers static` has not run")
    rows = json.loads(file.read_text())["rows"].values()
    svgf, bmfr = ([row[f"paths, {name}"] for row in rows] for name in ["SVGF", "BMFR"])
    return Found({"SVGF": svgf, "BMFR": bmfr}, *holds(all(less < more for less, more in zip(bmfr, svgf)), "not in all scenes"))


# --- Meijer
MEIJER = "--preset meijer"


@claim("m-write", "M: writing all vertices of a 1080p frame to the map takes 1.5 ms", "5", "nothing: an RTX 2080 Ti")
def m_write(lab):
    return Found({}, "not testable", "no GPU here; scripts/study gpu-report measures `cells_insert` of `--preset meijer` where there is one")


@claim("m-bright", "M: nHPSF is too bright", "5.4", "`cornell-box`, 48 frames: mean over the reference's of 1 bounce and of 16", in_ci=True)
def m_bright(lab):
    equal, every = (metric(lab.compared("cornell-box", MEIJER, 48, bounces=bounces), "mean_ratio") for bounces in (1, 16))
    verdict = ("refuted", "it has further bounces, as it should: the reference of all bounces is no darker") if abs(mean(every) - 1) < 0.06 \
        else ("confirmed", "")
    return Found({"of 1 bounce": equal, "of 16": every}, *verdict)


def leaked(lab, scene, bits):
    options = f"{MEIJER} --filter hpsf --cells-width 64 --cells-normal-bits {bits}"
    return metric(lab.compared(scene, options, 24, bounces=1), "rmse")


@claim("m-edges", "M: normals in the key keep light out of shadows at edges", "5.3, figure 11",
       "the shaded side of a step on a lit floor: RMSE against the reference with 0 and 3 bits of the normal, cells of 64 px")
def m_edges(lab):
    without, with_bits = leaked(lab, "step", 0), leaked(lab, "step", 3)
    return Found({"without": without, "with": with_bits},
                 *holds(mean(with_bits) < 0.9 * mean(without), "they do not"))


@claim("m-wall", "M: normals in the key keep shadows, as shadowed areas have other normals", "6",
       "a shadow on a plane floor: the same", in_ci=True)
def m_wall(lab):
    without, with_bits = leaked(lab, "shadow", 0), leaked(lab, "shadow", 3)
    return Found({"without": without, "with": with_bits},
                 *holds(mean(with_bits) < 0.9 * mean(without), "on a plane all normals are one"))


@claim("m-width", "M: wider cells have less noise", "5.2, figure 9", "`cornell-box`, HPSF, one frame: RMSE with cells of 4 and 16 px")
def m_width(lab):
    of = lambda width: metric(lab.compared("cornell-box", f"{MEIJER} --filter hpsf --cells-width {width}", 1, bounces=1), "rmse")
    narrow, wide = of(4), of(16)
    return Found({"4 px": narrow, "16 px": wide}, *holds(mean(wide) < mean(narrow), "they have not"))


@claim("m-blocks", "M: above 32 px there is hardly any noise, but light is blurred over edges", "5.2, figure 9",
       "`cornell-box`, HPSF, 48 frames: RMSE with cells of 16 and 128 px")
def m_blocks(lab):
    of = lambda width: metric(lab.compared("cornell-box", f"{MEIJER} --filter hpsf --cells-width {width}", 48, bounces=1), "rmse")
    usual, wide = of(16), of(128)
    return Found({"16 px": usual, "128 px": wide}, *holds(mean(wide) > mean(usual), "it is not"))


@claim("m-rays", "M: a path of one bounce costs at most 4 rays, whatever the filter", "4, 5", "`cornell-box`: rays a pixel of HPSF and nHPSF",
       in_ci=True)
def m_rays(lab):
    width, height = map(int, lab.size.split("x"))
    of = lambda name: [report["summary"]["median"]["rays"] / (width * height)
                       for report in lab.reports("cornell-box", f"{MEIJER} --filter {name}", 4)]
    hpsf, nhpsf = of("hpsf"), of("nhpsf")
    return Found({"HPSF": hpsf, "nHPSF": nhpsf}, *holds(max(hpsf + nhpsf) <= 4, "more"))


@claim("m-albedo", "M: keeping the albedo apart is stabler", "4.1",
       "the figures of `scripts/study path-space albedo`: change from frame to frame over the mean light, filtered together and apart")
def m_albedo(lab):
    file = lab.out / "path-space" / "albedo.json"
    if not file.is_file():
        return Found({}, "not testable", "`scripts/study path-space albedo` has not run")
    rows = json.loads(file.read_text())["rows"].values()
    together, apart = ([row[name]["flicker"] for row in rows] for name in ["together", "apart"])
    return Found({"together": together, "apart": apart}, *holds(mean(apart) < 0.95 * mean(together), "both change alike"))