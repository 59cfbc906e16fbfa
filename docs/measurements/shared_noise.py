#!/usr/bin/env python3
"""Noise that neighboring pixels share, layer by layer.

    python3 shared_noise.py MANYLIGHT SCENE ... [--size 256x144] [--seeds 6] [--passes 8] [-- OPTIONS OF RENDER]

For every scene and layer: the share of the layer in the variance of the picture, and the variance of means of 8x8 pixels times
64 over the variance of pixels: 1 if pixels are independent. Variances are those over seeds, without the hundredth of the blocks
in which a layer varies most. Needs: pip install OpenEXR numpy.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

LAYERS = ["emission", "direct", "virtual_lights", "compensation", "caustics"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight")
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--size", default="256x144")
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--passes", type=int, default=8)
    at = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    args, options = parser.parse_args(sys.argv[1:at]), sys.argv[at + 1 :]
    print("| scene |", " | ".join(LAYERS), "|\n|---|" + "---|" * len(LAYERS))
    for scene in args.scenes:
        pictures = [rendered(args, scene, seed, options) for seed in range(1, args.seeds + 1)]
        found = {layer: variances(np.stack([picture[layer] for picture in pictures])) for layer in LAYERS}
        total = sum(pixels for pixels, _ in found.values())
        cells = [f"{blocks / pixels:.1f} ({100 * pixels / total:.0f} %)" if pixels > 0 else "" for pixels, blocks in found.values()]
        print("|", scene.parent.name, "|", " | ".join(cells), "|", flush=True)


def rendered(args, scene: Path, seed: int, options: list[str]) -> dict:
    """The layers of a picture, in blocks: [block row, block column, pixel, color]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        command = [args.manylight, "render", scene, "-m", "rich-vpl", "--size", args.size, "--filter", "box", "--passes", args.passes]
        subprocess.run([str(word) for word in [*command, "--seed", seed, "-q", "-o", path, *options]], check=True, stderr=subprocess.DEVNULL)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(channel.pixels, np.float64) for name, channel in file.channels().items()}
    return {layer: blocks(np.stack([channels[f"{layer}.{c}"] for c in "RGB"], -1)) for layer in LAYERS if f"{layer}.R" in channels}


def blocks(picture: np.ndarray) -> np.ndarray:
    rows, columns = picture.shape[0] // 8, picture.shape[1] // 8
    tiled = picture[: 8 * rows, : 8 * columns].reshape(rows, 8, columns, 8, 3)
    return tiled.transpose(0, 2, 1, 3, 4).reshape(rows, columns, 64, 3)


def variances(seeds: np.ndarray) -> tuple[float, float]:
    """Of pixels, and of means of blocks times 64."""
    pixels = seeds.var(0, ddof=1).mean((-1, -2)).ravel()
    means = 64 * seeds.mean(3).var(0, ddof=1).mean(-1).ravel()
    kept = np.argsort(pixels)[: int(0.99 * len(pixels))]
    return pixels[kept].mean(), means[kept].mean()


if __name__ == "__main__":
    main()
