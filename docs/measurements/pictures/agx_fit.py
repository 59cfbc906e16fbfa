"""Fits the constants of manylight's AgX view (`crates/manylight-io/src/image/agx.rs`) to Blender's OpenColorIO configuration.

Usage: python agx_fit.py [CONFIG.ocio]

Needs the Python packages opencolorio, numpy and scipy. CONFIG.ocio is that of Blender, by default the one in the Python package bpy.
Prints the fitted matrices, rounded as in the program, and the differences of sRGB values (0 to 1) on other random colors.
"""

import importlib.util
import pathlib
import sys

import numpy as np
import PyOpenColorIO as ocio
from scipy.optimize import least_squares

GRAY, BELOW, ABOVE, SLOPE, EXPONENT, ENCODING = 0.18, 10.0, 6.5, 2.4, 1.5, 2.4
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def blender(colors, config):
    transform = ocio.DisplayViewTransform(src="Linear Rec.709", display="sRGB", view="AgX")
    values = np.ascontiguousarray(colors, dtype=np.float32)
    config.getProcessor(transform).getDefaultCPUProcessor().applyRGB(values)
    return values.astype(float)


def random_colors(count, seed):
    """Colors of all saturations, some with channels of 0, over 16 stops."""
    rng = np.random.default_rng(seed)
    colors = rng.random((count, 3)) ** rng.choice([0.5, 1, 2, 4], size=(count, 1))
    colors /= colors.max(axis=1, keepdims=True)
    colors[rng.random((count, 3)) < 0.12] = 0
    return colors * 2.0 ** rng.uniform(-10, 6, (count, 1))


def curve(v):
    """The sigmoid in the encoding of exponent 2.4, linear in and out."""
    x0, y0 = BELOW / (BELOW + ABOVE), GRAY ** (1 / ENCODING)
    x = np.clip((np.log2(np.maximum(v / GRAY, 1e-30)) + BELOW) / (BELOW + ABOVE), 0, 1) - x0
    reach, rise = np.where(x < 0, x0, 1 - x0), np.where(x < 0, y0, 1 - y0)
    line = SLOPE * reach
    scale = line / ((line / rise) ** EXPONENT - 1) ** (1 / EXPONENT)
    t = SLOPE * np.abs(x) / scale
    y = y0 + np.sign(x) * scale * t / (1 + t**EXPONENT) ** (1 / EXPONENT)
    return np.clip(y, 0, 1) ** ENCODING


def hue(c):
    """In sixths of a turn."""
    high, spread = c.max(axis=-1), np.ptp(c, axis=-1)
    r, g, b = np.moveaxis(c / np.where(spread > 0, spread, 1)[..., None], -1, 0)
    return np.where(c[..., 0] == high, g - b, np.where(c[..., 1] == high, 2 + b - r, 4 + r - g))


def with_hue(c, h):
    high, low = c.max(axis=-1), c.min(axis=-1)
    k = (np.array([5.0, 3.0, 1.0]) + h[..., None]) % 6
    return high[..., None] - (high - low)[..., None] * np.clip(np.minimum(k, 4 - k), 0, 1)


def brightness(c):
    complement = c.max(axis=-1, keepdims=True) - c
    return complement.max(axis=-1) - complement @ LUMINANCE + c @ LUMINANCE


def without_negatives(c):
    raised = c + np.maximum(-c.min(axis=-1, keepdims=True), 0)
    wanted, found = np.maximum(brightness(c), 0), brightness(raised)
    return raised * np.where(found > wanted, wanted / np.maximum(found, 1e-9), 1)[..., None]


def matrix(off_diagonal):
    """Rows sum to 1, so that gray stays gray."""
    m = np.zeros((3, 3))
    m[~np.eye(3, dtype=bool)] = off_diagonal
    return m + np.diag(1 - m.sum(axis=1))


def agx(colors, q):
    inset = colors @ matrix(q[:6]).T
    curved = curve(inset)
    before, after = hue(inset), hue(curved)
    turned = with_hue(curved, after + q[12] * ((before - after + 3) % 6 - 3))
    v = np.clip(without_negatives(turned @ matrix(q[6:12]).T), 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def main(config=None):
    if config is None:
        package = pathlib.Path(importlib.util.find_spec("bpy").origin).parent
        config = next(package.glob("**/colormanagement/config.ocio"))
    config = ocio.Config.CreateFromFile(str(config))
    colors = random_colors(12000, 1)
    expected = blender(colors, config)
    start = [0.36, 0.08, 0.14, 0.11, 0.09, 0.17, -0.8, -0.1, -0.3, -0.02, -0.16, -0.23, 0.5]
    fit = least_squares(lambda q: (agx(colors, q) - expected).ravel(), start, loss="soft_l1", f_scale=0.01)
    q = np.append(np.round(fit.x[:12], 4), np.round(fit.x[12], 2))
    print("inset", matrix(q[:6]).round(4).tolist())
    print("outset", matrix(q[6:12]).round(4).tolist())
    print("hue kept", q[12])
    colors = random_colors(20000, 2)
    error = np.abs(agx(colors, q) - blender(colors, config))
    quantiles = " ".join(f"{p:.1%} {np.quantile(error, p):.4f}" for p in (0.5, 0.9, 0.99, 0.999))
    print(f"differences: {quantiles}, largest {error.max():.4f}, root of the mean square {np.sqrt((error**2).mean()):.4f}")


main(*sys.argv[1:])
