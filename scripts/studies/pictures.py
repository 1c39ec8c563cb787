"""Pictures as arrays for the studies: layers of an EXR in, figures and display values out.

Luminance is that of Rec. 709. A block counts if the reference's mean in it is above 2 % of that of its whole picture: in
darker ones ratios say nothing.
"""

import numpy as np
import OpenEXR

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
DARK = 0.02


def layer(picture, name):
    """A layer as height x width x 3."""
    for part in OpenEXR.File(str(picture)).parts:
        if part.name() == name:
            return part.channels["RGB"].pixels[..., :3].astype(np.float64)
    raise ValueError(f"{picture} has no layer {name}")


def first_layer(picture):
    """The first layer, of all light."""
    return OpenEXR.File(str(picture)).parts[0].channels["RGB"].pixels[..., :3].astype(np.float64)


def channels(picture, name):
    """The channels of a layer in alphabetic order, as height x width x channels."""
    for part in OpenEXR.File(str(picture), separate_channels=True).parts:
        if part.name() == name:
            return np.stack([part.channels[channel].pixels for channel in sorted(part.channels)], 2).astype(np.float64)
    raise ValueError(f"{picture} has no layer {name}")


def exposure(picture):
    """Stops that bring 95 % of a picture's luminances below 0.8."""
    return float(np.log2(0.8 / np.percentile(picture @ LUMINANCE, 95)))


def encoded(picture, stops):
    """sRGB, 0 to 1, of linear values."""
    linear = np.clip(picture * 2.0 ** stops, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def display(picture, stops):
    """sRGB, 8 bits, of linear values."""
    return (255 * encoded(picture, stops) + 0.5).astype(np.uint8)


def block_means(picture, side):
    """Mean luminances of whole blocks; what is left at the right and lower edge is not in them."""
    luminances = picture @ LUMINANCE
    height, width = (extent // side * side for extent in luminances.shape)
    return luminances[:height, :width].reshape(height // side, side, width // side, side).mean((1, 3))


def brightest_block(rendered, reference, side=8):
    """The greatest ratio of the means of a block: bright spots and leaks."""
    ours, theirs = block_means(rendered, side), block_means(reference, side)
    counted = theirs > DARK * theirs.mean()
    return float((ours[counted] / theirs[counted]).max())


def trimmed_relmse(rendered, reference):
    """The relMSE of `glowworm compare` over all pixels but the worst 0.1 %: one pixel may outweigh all others."""
    errors = ((rendered - reference) ** 2 / (reference ** 2 + 0.01)).mean(2).ravel()
    return float(np.sort(errors)[:int(0.999 * errors.size)].mean())


def pattern(rendered, reference, period=4):
    """How much a pattern of this period in pixels, as interleaving may leave it, stands out from the error around it.

    The power spectrum of the luminance of the error (after a Hann window, so that edges of the picture do not leak) is
    taken at the frequencies (f, 0), (0, f), (f, f) and (f, -f) with f = 1/period: the mean over 3 x 3 bins there. Each is
    divided by the mean of its neighbourhood, the bins within 10 % of f, without those 3 x 3. On an axis, where horizontal and
    vertical edges are, the neighbourhood is the strip of 3 bins along it. The result is the mean of the four: about 1 where
    there is no pattern (0.5 to 1.5: few bins tell).
    """
    error = (rendered - reference) @ LUMINANCE
    height, width = (extent // period * period for extent in error.shape)
    window = np.outer(np.hanning(height + 1)[:-1], np.hanning(width + 1)[:-1])
    error = error[:height, :width]
    power = np.abs(np.fft.fft2(window * (error - (window * error).sum() / window.sum()))) ** 2
    ratios = []
    for down, right in [(0, 1), (1, 0), (1, 1), (-1, 1)]:
        # Bins from the frequency in question.
        rows = [offset for offset in range(-height, height) if abs(offset) <= (0.1 * height / period if down else 1)]
        columns = [offset for offset in range(-width, width) if abs(offset) <= (0.1 * width / period if right else 1)]
        around = power[np.ix_([(down * height // period + offset) % height for offset in rows],
                              [(right * width // period + offset) % width for offset in columns])]
        centre = np.outer(np.abs(rows) <= 1, np.abs(columns) <= 1)
        ratios.append(around[centre].mean() / around[~centre].mean())
    return float(np.mean(ratios))


def block_energy(rendered, reference, side=32):
    """Energy of the magnitude of the error's gradient, the mean along each column and row, at the harmonics of a period of `side` pixels,
    over that two to four bins beside them: 1 where no edges of blocks are seen. Blocks that are few across are not looked at."""
    error = (rendered - reference) @ LUMINANCE
    ratios = []
    for lines in [error, error.T]:
        length = (lines.shape[1] - 1) // side * side
        blocks = length // side
        if blocks < 8:
            continue
        steps = np.abs(np.diff(lines, axis=1))[:, :length].mean(0)
        power = np.abs(np.fft.rfft(np.hanning(length + 1)[:-1] * (steps - steps.mean()))) ** 2
        bins = np.arange(1, side // 2) * blocks
        ratios.append(power[bins].sum() / np.mean([power[bins + offset].sum() for offset in [-4, -3, -2, 2, 3, 4]]))
    return float(np.mean(ratios))


def mottling(rendered, reference, stops, shortest=8, longest=64):
    """What is seen as clouds and spots: the error of display luminance at periods of so many pixels, root mean square, in
    steps of 8 bits (after a Hann window)."""
    error = (encoded(rendered, stops) - encoded(reference, stops)) @ LUMINANCE
    height, width = error.shape
    window = np.outer(np.hanning(height + 1)[:-1], np.hanning(width + 1)[:-1])
    power = np.abs(np.fft.fft2(window * error)) ** 2 / (error.size * (window ** 2).sum())
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width))
    return float(255 * np.sqrt(power[(frequency >= 1 / longest) & (frequency <= 1 / shortest)].sum()))


def flicker(picture, before):
    """Mean absolute change of the irradiance's luminance from the frame before, where both show the same surface point,
    over its mean: the temporal error of a moving picture."""
    at, same = seen_before(picture, before)
    now, then = (layer(file, "indirect") @ LUMINANCE for file in [picture, before])
    return float(np.abs(now - then[at])[same].mean() / now[same].mean())


def seen_before(picture, before):
    """Where each pixel's surface was in the frame before, as rows and columns, and whether it was seen there."""
    motion, position, depth = (channels(picture, name) for name in ["motion", "position", "depth"])
    height, width = depth.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    y = np.rint(rows - motion[..., 1] * height).astype(int)
    x = np.rint(columns - motion[..., 0] * width).astype(int)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    at = np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)
    moved = np.linalg.norm(position - channels(before, "position")[at], axis=2)
    return at, inside & (moved < 0.02 * depth[..., 0])


def frames_seen(pictures):
    """For each frame, how many frames before it have seen the surface of each pixel without a gap."""
    counts = [np.zeros(channels(pictures[0], "depth").shape[:2], int)]
    for picture, before in zip(pictures[1:], pictures):
        at, same = seen_before(picture, before)
        counts.append(np.where(same, counts[-1][at] + 1, 0))
    return counts


def steadiness(pictures, side=32):
    """Over pictures of several seeds, the worst block's spread (largest less smallest mean) and standard deviation, both
    over its mean, and the root mean square over the blocks of the latter."""
    means = np.stack([block_means(picture, side) for picture in pictures])
    mean = means.mean(0)
    counted = mean > DARK * mean.mean()
    spread = (means.max(0) - means.min(0))[counted] / mean[counted]
    deviation = means.std(0, ddof=1)[counted] / mean[counted]
    typical = np.sqrt((deviation ** 2).mean())
    return {"spread": float(spread.max()), "deviation": float(deviation.max()), "typical_deviation": float(typical)}
