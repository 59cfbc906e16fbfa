"""Opens an EXR file of manylight by OpenEXR's own library and checks windows, attributes, alpha and positions.

Usage: python check_exr.py FILE.exr

Needs the Python packages OpenEXR and numpy. With the layers of `-m aov` or `--aov position,object`, the positions are projected by
`worldToNDC`: they must fall on their own pixels.
"""

import sys

import numpy as np
import OpenEXR


def main(path):
    parts = OpenEXR.File(path, separate_channels=True).parts
    assert len(parts) == 1, "one part"
    header = parts[0].header
    channels = {name: np.asarray(channel.pixels) for name, channel in parts[0].channels.items()}
    low, high = (np.array(v) for v in header["dataWindow"])
    full_low, full_high = (np.array(v) for v in header["displayWindow"])
    size = full_high - full_low + 1
    print(f"display window {size[0]} x {size[1]}, data window {low} to {high}")
    assert (low >= full_low).all() and (high <= full_high).all(), "the data window lies in the display window"
    for name in ("colorInteropID", "software", "scene", "scene.sha256", "command", "samples", "capDate", "utcOffset"):
        print(f"{name}: {header[name]}")
    assert header["colorInteropID"] == "lin_rec709_scene"
    layers = {}
    for name in channels:
        layer, _, channel = name.rpartition(".")
        layers.setdefault(layer, []).append(channel)
    for layer, names in sorted(layers.items()):
        print(f"  {layer or '(image)'}: {' '.join(sorted(names))}")

    prefix = "ViewLayer.Combined." if "ViewLayer.Combined.R" in channels else ""
    alpha = channels[prefix + "A"]
    assert alpha.min() >= 0 and alpha.max() <= 1, "alpha is in [0, 1]"
    print(f"alpha: mean {alpha.mean():.6f}, {np.mean(alpha == 0):.2%} empty, {np.mean(alpha == 1):.2%} covered")
    if not prefix:
        check_empty_pixels(channels, alpha)
    position = "ViewLayer.Position." if prefix else "position."
    if position + "X" in channels:
        check_positions(header, channels, position, low, full_low, size)


def check_empty_pixels(channels, alpha):
    """Premultiplied: nothing shines where nothing is."""
    light = np.max([np.abs(channels[c]) for c in "RGB"], axis=0)
    print(f"largest value where alpha is 0: {light[alpha == 0].max(initial=0)}")


def check_positions(header, channels, name, low, full_low, size):
    """Projects the positions of pixels that surfaces cover as a whole."""
    matte = "ViewLayer.CryptoObject0" if "ViewLayer.CryptoObject00.g" in channels else "CryptoObject0"
    if matte + "0.g" not in channels:
        return print("positions: no mattes, which tell covered pixels")
    # One object only: edges between near and far surfaces have positions in between.
    whole = channels[matte + "0.g"] > 0.9999
    points = np.stack([channels[name + c][whole] for c in "XYZ"] + [np.ones(whole.sum())], axis=-1)
    # Row vectors, as in Imath.
    projected = points.astype(np.float64) @ np.asarray(header["worldToNDC"], np.float64).reshape(4, 4)
    pixels = projected[:, :2] / projected[:, 3:] * size + full_low
    rows, columns = np.nonzero(whole)
    centers = np.stack([columns, rows], axis=-1) + low + 0.5
    error = np.abs(pixels - centers).max(axis=1)
    camera = points.astype(np.float64) @ np.asarray(header["worldToCamera"], np.float64).reshape(4, 4)
    print(f"positions of {len(points)} pixels: off their centers by {np.median(error):.3f} (median),"
          f" {np.quantile(error, 0.99):.3f} pixels (99 %)")
    assert np.median(error) < 0.5 and (camera[:, 2] > 0).all(), "positions project to their pixels, in front of the camera"


main(*sys.argv[1:])
