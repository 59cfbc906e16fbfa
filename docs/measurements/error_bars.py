#!/usr/bin/env python3
"""How much of the truth lies within the error bars: pictures of many seeds beside references.

    python3 error_bars.py MANYLIGHT REFERENCES SCENES [--seeds 20] [--passes 16] [--methods path rich-vpl auto] [--only NAME ...]

REFERENCES has a NAME.exr with the layer `variance` beside a NAME.json with the `file` of the scene in SCENES, `size` and
`max_depth`. Pictures and references have half of that size: means over 2x2 pixels of a reference are what a box filter gives.
For every scene and method: percent of pixels and of 8x8 blocks within the bars, as rendered and denoised; the stated error of
a pixel over the true one (root mean squares; the true one is known up to the noise of the reference); percent of seeds whose
true error is at most what is stated with 95 % confidence.
Needs: pip install OpenEXR numpy, and Open Image Denoise.
"""
import argparse
import json
import math
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import OpenEXR


def halved(path: Path, out: Path) -> None:
    """Means over 2x2 pixels of the picture and of its variances."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: np.asarray(channel.pixels, np.float64) for name, channel in file.channels().items()}
    means = {}
    for name in [*"RGB", *(f"variance.{c}" for c in "RGB")]:
        height, width = (n // 2 for n in channels[name].shape)
        mean = channels[name][: 2 * height, : 2 * width].reshape(height, 2, width, 2).mean((1, 3))
        means[name] = (mean / 4 if "." in name else mean).astype(np.float32)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, means).write(str(out))


def compare(manylight: str, image: Path, reference: Path) -> dict:
    command = [manylight, "compare", str(image), str(reference), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["images"][0]


def measured(args, scene: dict, reference: Path, method: str, seed: int, folder: Path) -> list[list[float]]:
    """Of one seed, as rendered and denoised: coverage of pixels and blocks, stated over true error, and whether it is within the bound."""
    rows = []
    for denoise in ([], ["--denoise", "oidn"]):
        image = folder / f"{reference.stem}.{method}.{seed}.exr"
        size = "x".join(str(n // 2) for n in scene["size"])
        command = [args.manylight, "render", str(args.scenes / scene["file"]), "-m", method, "--size", size, "--filter", "box"]
        command += ["--max-depth", str(scene["max_depth"]), "--passes", str(args.passes), "--seed", str(seed), "--threads", "1"]
        done = subprocess.run([*command, "-o", str(image), "-q", "--json", *denoise], check=True, capture_output=True, text=True)
        error, found = json.loads(done.stdout)["error"], compare(args.manylight, image, reference)
        if error is None:
            rows.append([math.nan] * 4)
            continue
        true = math.sqrt(max(found["relmse"] - found["reference_noise"]["relmse"], 1e-12))
        inside = found["within_bars"]
        rows.append([inside["pixels"], inside["blocks"], error["pixels"] / true, float(true <= error["pixels_at_most"])])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight")
    parser.add_argument("references", type=Path)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--methods", nargs="+", default=["path", "rich-vpl", "auto"])
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--jobs", type=int, default=2, help="renders at once, of one thread each")
    args = parser.parse_args()
    print("| scene | method | pixels | blocks | stated/true | in bound | denoised: pixels | blocks | stated/true | in bound |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(args.jobs) as pool:
        folder = Path(name)
        for file in sorted(args.references.glob("*.json")):
            if args.only and file.stem not in args.only:
                continue
            scene, reference = json.loads(file.read_text()), folder / f"{file.stem}.exr"
            halved(file.with_suffix(".exr"), reference)
            for method in args.methods:
                seeds = range(1, args.seeds + 1)
                one = lambda seed: measured(args, scene, reference, method, seed, folder)
                values = np.array(list(pool.map(one, seeds))).transpose(1, 0, 2)
                cells = []
                for inside_pixels, inside_blocks, ratio, bound in (of.T for of in values):
                    means = [f"{100 * part.mean():.1f}" for part in (inside_pixels, inside_blocks)]
                    cells += [*means, f"{np.exp(np.log(ratio).mean()):.2f}", f"{100 * bound.mean():.0f}"]
                print("|", " | ".join([file.stem, method, *cells]), "|", flush=True)


if __name__ == "__main__":
    main()
