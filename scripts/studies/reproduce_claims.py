"""The claims of scripts/study reproduce, but those of reproduce_path_claims: what each says, how it is measured, and the bounds by which its verdict follows from the figures."""

import math
import random
import statistics
from dataclasses import dataclass, field
from typing import Callable


@dataclass
class Found:
    figures: dict
    verdict: str
    why: str = ""


@dataclass
class Claim:
    text: str
    section: str
    ran: str
    measure: Callable = field(repr=False)
    in_ci: bool = False


CLAIMS = {}


def claim(name, text, section, ran, in_ci=False):
    def add(measure):
        CLAIMS[name] = Claim(text, section, ran, measure, in_ci)
        return measure
    return add


def holds(condition, why=""):
    return ("confirmed", "") if condition else ("refuted", why)


def above(values, bound, why=""):
    """Whether they are above a bound, as far as their spread tells."""
    spread = statistics.stdev(values) if len(values) > 1 else 0
    if abs(statistics.fmean(values) - bound) < spread:
        return "not testable", "its distance to the bound is within the spread on this machine"
    return holds(statistics.fmean(values) > bound, why)


def mean(values):
    return statistics.fmean(values)


def times(reports, passes=None):
    """Milliseconds of a frame, or of some passes of it, a list over the seeds."""
    of = lambda figures: figures["total_ms"] if passes is None else sum(figures["passes"].get(name, 0) for name in passes)
    return [of(report["summary"]["median"]) for report in reports]


def ratios(above, below):
    return [a / b for a, b in zip(above, below)]


def metric(errors, name):
    return [one[name] for one in errors]


TONNA = "--preset tonna"
STAGES = ["indirect_shadows", "indirect_shading", "indirect_reprojection"]
FIVE = {"cornell-box": ("Cornell box", 9.9), "atrium": ("Sponza", 13.1), "atrium-drapery": ("Crytek Sponza", 9.5),
        "cathedral": ("Sibenik", 11.3), "meeting-room": ("Conference", 7.5)}


def speed_up(scene, thesis):
    def measure(lab):
        one = lab.reports(scene, TONNA + " --temporal-sets 1", 2)
        many = lab.reports(scene, TONNA + " --temporal-sets 16", 16)
        stages = ratios(times(one, STAGES), times(many, STAGES))
        rays = ratios(*([report["summary"]["median"]["shadow_rays"] for report in reports] for reports in (one, many)))
        verdict, why = above(stages, 0.5 * thesis, "less than half of it")
        return Found({"stages of indirect light": stages, "rays": rays}, verdict, why)
    return measure


for scene, (title, thesis) in FIVE.items():
    claim(f"t-speed-{scene}", f"T: 16 sets make {title} {thesis} times faster than one", "figure 24",
          f"`{scene}`, T = 1 and 16: time of indirect light, and its rays")(speed_up(scene, thesis))


@claim("t-speed-moving", "T: the speed-up holds while the camera moves", "6.2", "flight through `atrium`, T = 1 and 16")
def t_speed_moving(lab):
    one = lab.reports("flight", TONNA + " --temporal-sets 1", 2)
    many = lab.reports("flight", TONNA + " --temporal-sets 16", 16)
    found = ratios(times(one, STAGES), times(many, STAGES))
    return Found({"stages of indirect light": found}, *above(found, 6, "less than 6"))


@claim("t-larger", "T: more than 16 sets gain little (T = 32 over 16: 1.09 to 1.3 times)", "figure 24",
       "`cornell-box`, T = 16 and 32: whole frames")
def t_larger(lab):
    sixteen = lab.reports("cornell-box", TONNA + " --temporal-sets 16", 32)
    more = lab.reports("cornell-box", TONNA + " --temporal-sets 32", 64)
    found = ratios(times(sixteen), times(more))
    return Found({"frame": found}, *above([-ratio for ratio in found], -1.5, "it gains more"))


def quality(scene):
    def measure(lab):
        one = lab.compared(scene, TONNA + " --temporal-sets 1", 2, layer="indirect")
        many = lab.compared(scene, TONNA + " --temporal-sets 16", 16, layer="indirect")
        alone = [metric(lab.compared(scene, f"{TONNA} --temporal-sets {sets} --interleave 1", sets, layer="indirect"), "ssim")
                 for sets in (1, 16)]
        with_sets, without = metric(many, "ssim"), metric(one, "ssim")
        why = "sets alone cost nothing, but a class of 2 VPLs in each set is mixed worse than one of 32"
        verdict, why = holds(abs(mean(with_sets) - mean(without)) < 0.01, why)
        return Found({"SSIM with": with_sets, "without": without, "FLIP with": metric(many, "flip"), "without ": metric(one, "flip"),
                      "SSIM not interleaved, with": alone[1], "without  ": alone[0]}, verdict, why)
    return measure


for scene, title in [("cornell-box", "the Cornell box"), ("atrium", "Sponza")]:
    claim(f"t-quality-{scene}", f"T: once converged, sets cost no quality in {title}", "figures 28 to 30",
          f"`{scene}`, T = 1 and 16 against the reference; SSIM and FLIP for HDR-VDP-2", in_ci=scene == "cornell-box")(quality(scene))


@claim("t-half-fps", "T: without sets 0.5 frames a second", "7", "its own figure 24: milliseconds at T = 1", in_ci=True)
def t_half_fps(lab):
    fps = [1000 / ms for ms in [271.948, 554.105, 489.522, 464.277, 453.456]]
    return Found({"frames a second by figure 24": f"{min(fps):.1f} to {max(fps):.1f}"},
                 *holds(min(fps) < 0.6, "the same thesis measured 1.8 to 3.7"))


@claim("t-fps", "T: 26 frames a second in the mean, 40 in the Cornell box", "6.2, 7", "nothing: an RX Vega 56 at 1024x1024")
def t_fps(lab):
    return Found({}, "not testable", "no GPU here; scripts/study gpu-report measures it where there is one")


@claim("t-reference", "T: pictures differ from the reference renderer's as VPLs go elsewhere", "6.3",
       "`cornell-box`, 256 to 4096 VPLs gathered without a bound: mean and RMSE against the reference", in_ci=True)
def t_reference(lab):
    options = TONNA + " --clamp 0 --temporal-sets 1 --interleave 1 --vpls "
    few, many = (lab.compared("cornell-box", options + vpls, 1, layer="indirect") for vpls in ["256", "4096"])
    mean_ratio, rmse = metric(many, "mean_ratio"), (metric(few, "rmse"), metric(many, "rmse"))
    same = abs(mean(mean_ratio) - 1) < 0.04 and mean(rmse[1]) < 0.6 * mean(rmse[0])
    verdict = ("refuted", "as many VPLs lead to the reference's picture: it was their number") if same else ("confirmed", "")
    return Found({"mean ratio": mean_ratio, "RMSE of 256": rmse[0], "of 4096": rmse[1]}, *verdict)


@claim("t-holes", "T: too low a cut-off leaves holes in motion", "figure 19", "flight through `atrium`, cut-offs of 0.0001 and 0.02 of the depth")
def t_holes(lab):
    low, usual = (lab.compared("flight", f"{TONNA} --position-cutoff {cutoff}", 24, layer="indirect") for cutoff in ["0.0001", "0.02"])
    found = metric(low, "mean_ratio"), metric(usual, "mean_ratio")
    return Found({"mean ratio at 0.0001": found[0], "at 0.02": found[1]}, *holds(mean(found[0]) < 0.8 * mean(found[1]), "no darker"))


@claim("t-ghosts", "T: too high a cut-off leaves after-images in motion", "figure 19", "the same at 0.02 and 0.5")
def t_ghosts(lab):
    usual, high = (lab.compared("flight", f"{TONNA} --position-cutoff {cutoff}", 24, layer="indirect") for cutoff in ["0.02", "0.5"])
    found = metric(usual, "ssim"), metric(high, "ssim")
    return Found({"SSIM at 0.02": found[0], "at 0.5": found[1]}, *above([a - b for a, b in zip(*found)], 0, "no worse"))


@claim("t-dark", "T: surfaces that come into view stay dark until their sets come round", "figures 18, 27",
       "fast flight through `atrium`, T = 32: left dark, and made up for by the sets that saw the surface")
def t_dark(lab):
    dark, scaled = (lab.compared("flight:1", f"{TONNA} --temporal-sets 32 --missing-sets {missing}", 24, layer="indirect")
                    for missing in ["dark", "scale"])
    found = metric(dark, "mean_ratio"), metric(scaled, "mean_ratio")
    return Found({"mean ratio": found[0], "made up for": found[1]}, *holds(mean(found[0]) < mean(found[1]) - 0.02, "as bright"))


# --- Granja: extensions, one after the other
PLAIN = ("--preset granja --antialiasing none --svgf-history-clamp none --svgf-widened false --svgf-separable false "
         "--svgf-reinhard false")
CLAMPED = PLAIN.replace("clamp none", "clamp clamp")
WIDENED = CLAMPED.replace("widened false", "widened true")
SEPARABLE = WIDENED.replace("separable false", "separable true")
REINHARD = SEPARABLE.replace("reinhard false", "reinhard true")
IMAGE_BASED = f"{PLAIN} --second-reflections split-sum"
ROUGH = "mirror:0.3:still"


def reflected(lab, options, scene=ROUGH, name="ssim"):
    return metric(lab.compared(scene, options, 16, bounces=1, layer="reflected"), name)


def shadowed(lab, options, scene="penumbra:10:still", name="ssim"):
    return metric(lab.compared(scene, options, 16, bounces=0, layer="shadow"), name)


def extension(name, title, before, after, verdict, of=reflected):
    def measure(lab):
        found = of(lab, before), of(lab, after)
        return Found({"SSIM before": found[0], "after": found[1]}, *verdict(mean(found[1]) - mean(found[0])))
    what = "boxes above a mirror of roughness 0.3, reflections alone" if of is reflected \
        else "boxes under a sun of half angle 10 degrees, shadows alone"
    claim(name, title[0], title[1], f"{what}, the extensions before it on", in_ci=name == "g-clamp")(measure)


extension("g-clamp", ("G: clamping history costs SSIM at roughness 0.1 to 0.4", "5.2.1"), PLAIN, CLAMPED,
          lambda change: holds(change < -0.001, "it does not"))
extension("g-widened", ("G: adapting the blur to roughness leaves SSIM as it was", "5.2.2"), CLAMPED, WIDENED,
          lambda change: holds(abs(change) < 0.01, "it changes it"))
extension("g-separable", ("G: a separable blur leaves SSIM as it was", "5.2.3"), WIDENED, SEPARABLE,
          lambda change: holds(abs(change) < 0.01, "it changes it"))
extension("g-reinhard", ("G: averaging by Reinhard's curve costs little SSIM", "5.2.4"), SEPARABLE, REINHARD,
          lambda change: holds(abs(change) < 0.01, "it changes it more"))


extension("g-clamp-shadows", ("G: clamping history costs SSIM in wide penumbrae", "5.2.1"), PLAIN, CLAMPED,
          lambda change: holds(change < -0.001, "it does not"), shadowed)
extension("g-widened-shadows", ("G: adapting the blur to penumbrae leaves SSIM as it was", "5.2.2"), CLAMPED, WIDENED,
          lambda change: holds(abs(change) < 0.01, "it changes it"), shadowed)
extension("g-separable-shadows", ("G: a separable blur leaves SSIM of shadows as it was", "5.2.3"), WIDENED, SEPARABLE,
          lambda change: holds(abs(change) < 0.01, "it changes it"), shadowed)


@claim("g-clip", "G: clipping history is as good as clamping it", "figure 3.10",
       "boxes above a mirror of roughness 0.3, strafing, reflections alone")
def g_clip(lab):
    found = [reflected(lab, options, "mirror:0.3:camera") for options in [CLAMPED, CLAMPED.replace("clamp clamp", "clamp clip")]]
    return Found({"SSIM clamped": found[0], "clipped": found[1]}, *holds(abs(mean(found[1]) - mean(found[0])) < 0.01, "it is not"))


@claim("g-tests", "G: history needs the tests of instance, normal and depth", "figure 3.9",
       "boxes under a sun of half angle 4 degrees, strafing fast, shadows alone, each test left out by itself: RMSE")
def g_tests(lab):
    of = lambda tests: shadowed(lab, " ".join([PLAIN, *(f"--reprojection-{test} false" for test in tests)]), "penumbra:4:fast-camera", "rmse")
    tests = ["instance", "normal", "depth"]
    every, none = of([]), of(tests)
    without = {f"without {test}": of([test]) for test in tests}
    needed = sum(mean(found) > 1.01 * mean(every) for found in without.values())
    return Found({"all": every} | without | {"without any": none},
                 *holds(needed == 3, f"{needed} of 3: what one rejects the others do, too"))


@claim("g-iterations", "G: no iteration of the blur in a mirror, and one up to roughness 0.05, are sharper than four", "figure 3.12",
       "boxes and a wall of metal under the sky above a mirror of roughness 0 and 0.05, image-based light at second hits: SSIM")
def g_iterations(lab):
    figures, better = {}, []
    for roughness, levels in [("0", 0), ("0.05", 1)]:
        four, few = (reflected(lab, f"{IMAGE_BASED} --reflections-svgf-levels {count}", f"metals:{roughness}:still") for count in [4, levels])
        figures |= {f"roughness {roughness}, 4": four, f"{levels}" + " " * levels: few}
        better.append(mean(few) > mean(four) + 0.001)
    return Found(figures, *holds(all(better), "they are alike"))


@claim("g-image-based", "G: image-based light at second hits is untrue, so it is off", "3.4",
       "boxes and a wall of metal under the sky above a mirror of roughness 0, still, reflections alone: rays at second hits, and the split sum")
def g_image_based(lab):
    rays, sums = (lab.compared("metals:0:still", options, 16, bounces=1, layer="reflected") for options in [PLAIN, IMAGE_BASED])
    ratios, found = [metric(of, "mean_ratio") for of in [rays, sums]], [metric(of, "ssim") for of in [rays, sums]]
    return Found({"mean ratio by rays": ratios[0], "by the split sum": ratios[1], "SSIM by rays": found[0], "by the sum": found[1]},
                 *holds(mean(found[1]) < mean(found[0]) - 0.001, "it is as good"))


@claim("g-roughness", "G: SSIM is lowest in sharp mirrors and above 0.94 beyond (cubes, still)", "tables 5.3 to 5.8",
       "boxes above a mirror of roughness 0, 0.2, 0.6; plain SVGF")
def g_roughness(lab):
    found = {f"SSIM at {r}": reflected(lab, PLAIN, f"mirror:{r}:still") for r in ["0", "0.2", "0.6"]}
    sharp, *rough = map(mean, found.values())
    return Found(found, *holds(sharp < min(rough), "sharp mirrors are the easiest: their rays have no noise"))


@claim("g-motion", "G: a moving camera costs SSIM in rough mirrors", "table 5.19", "boxes above a mirror of roughness 0.2, still and strafing")
def g_motion(lab):
    still, moving = reflected(lab, PLAIN, "mirror:0.2:still"), reflected(lab, PLAIN, "mirror:0.2:camera")
    return Found({"SSIM still": still, "moving": moving}, *holds(mean(moving) < mean(still), "it costs nothing"))


@claim("g-ghosts", "G: clamping helps in sharp mirrors in motion", "5.2.1", "the same, roughness 0, strafing, without and with the clamp")
def g_ghosts(lab):
    found = reflected(lab, PLAIN, "mirror:0:camera"), reflected(lab, CLAMPED, "mirror:0:camera")
    return Found({"SSIM before": found[0], "after": found[1]}, *holds(mean(found[1]) > mean(found[0]) + 1e-4, "it does not"))


ATROUS = ["soft_shadows_svgf_atrous", "reflections_svgf_atrous"]


@claim("g-separable-speed", "G: a separable blur is 1.6 to 2 times faster", "5.3", "the a-trous passes of both effects, before and after")
def g_separable_speed(lab):
    whole, separable = (times(lab.reports(ROUGH, options, 16), ATROUS) for options in [WIDENED, SEPARABLE])
    found = ratios(whole, separable)
    return Found({"times faster": found}, *above(found, 1.4, "less"))


def reflected_of_white(printed, samples=200_000, roughness=0.4, cosine=0.2):
    """What its estimator makes of a white surface: with its density, or with the one of its sampling."""
    q, sine = roughness**2, math.sqrt(1 - cosine**2)
    lambda_of = lambda c: 0.5 * (math.sqrt(1 + (q if printed else q * q) * (1 / c**2 - 1)) - 1)
    rng, total = random.Random(1), 0.0
    for _ in range(samples):
        x1, x2 = rng.random(), rng.random()
        h_cos = math.sqrt((1 - x2) / (1 + (q * q - 1) * x2))
        v_h = cosine * h_cos + sine * math.sqrt(1 - h_cos**2) * math.cos(2 * math.pi * x1)
        l_cos = 2 * v_h * h_cos - cosine
        if l_cos <= 0 or v_h <= 0:
            continue
        g = 1 / (1 + lambda_of(cosine) + lambda_of(l_cos))
        total += g / h_cos if printed else g * v_h / (cosine * h_cos)
    return total / samples


@claim("g-energy", "G: reflection rays are an estimate of the GGX lobe", "3.4",
       "its estimator as printed and a right one, in closed form: a white surface, roughness 0.4, n.v = 0.2", in_ci=True)
def g_energy(lab):
    printed, right = reflected_of_white(True), reflected_of_white(False)
    return Found({"of the light": f"{printed:.2f}", "right": f"{right:.2f}"},
                 *holds(abs(printed / right - 1) < 0.05, "its density has n.v for v.h, and its shadowing term q for its square"))


@claim("g-fps", "G: more than 30 frames a second in all scenes", "5.4", "nothing: an RTX 2080 at 1920x1057")
def g_fps(lab):
    return Found({}, "not testable", "no GPU here; scripts/study gpu-report measures `--preset granja` where there is one")
