#!/usr/bin/env python3
"""How much of the truth lies within the error bars: pictures of many seeds beside references.

    python3 error_bars.py MANYLIGHT REFERENCES SCENES [--seeds 20] [--passes 16] [--methods path rich-vpl auto] [--only NAME ...] [--rows FILE]

REFERENCES has a NAME.exr with the layer `variance` beside a NAME.json with the `file` of the scene in SCENES, `size` and
`max_depth`. Pictures and references have half of that size: means over 2x2 pixels of a reference are what a box filter gives.
For every scene and method: percent of pixels and of 8x8 blocks within the bars, as rendered and denoised; the stated error of
a pixel over the true one (root mean squares; the true one is known up to the noise of the reference); percent of seeds whose
true error is at most what is stated with 95 % confidence.
With `--rows`, what one seed gave is a line of FILE, and is not rendered again.
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


def answer(*command: object) -> dict:
    """The JSON object that a command prints."""
    return json.loads(subprocess.run([*map(str, command), "--json"], check=True, capture_output=True, text=True).stdout)


def measured(args, scene: dict, reference: Path, method: str, seed: int, folder: Path) -> list[list[float]]:
    """Of one seed, as rendered and denoised: coverage of pixels and blocks, stated over true error, and whether it is within the bound."""
    part, image = (folder / f"{reference.stem}.{method}.{seed}{end}" for end in (".part", ".exr"))
    size = "x".join(str(n // 2) for n in scene["size"])
    film = ["--size", size, "--filter", "box", "--max-depth", scene["max_depth"], "--threads", 1]
    answer(args.manylight, "render", args.scenes / scene["file"], "-m", method, *film, "--passes", args.passes, "--seed", seed, "--shard", "1/1", "-q", "-o", part)
    rows = []
    for denoise in ([], ["--denoise", "oidn"]):
        error = answer(args.manylight, "merge", part, "-q", "-o", image, *denoise)["error"]
        if error is None:
            rows.append([math.nan] * 4)
            continue
        found = answer(args.manylight, "compare", image, reference)["images"][0]
        true = math.sqrt(max(found["relmse"] - found["reference_noise"]["relmse"], 1e-12))
        inside = found["within_bars"]
        rows.append([inside["pixels"], inside["blocks"], error["pixels"] / true, float(true <= error["pixels_at_most"])])
    part.unlink()
    image.unlink(missing_ok=True)
    return rows


def cells(rows: list[list[list[float]]]) -> list[str]:
    """Means over the seeds of one scene and method, as rendered and denoised."""
    words = [str(len(rows))]
    for inside_pixels, inside_blocks, ratio, bound in (of.T for of in np.array(rows).transpose(1, 0, 2)):
        words += [f"{100 * part.mean():.1f}" for part in (inside_pixels, inside_blocks)]
        words += [f"{np.exp(np.log(ratio).mean()):.2f}", f"{100 * bound.mean():.0f}"]
    return words


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
    parser.add_argument("--rows", type=Path)
    args = parser.parse_args()
    scenes = {file.stem: json.loads(file.read_text()) for file in sorted(args.references.glob("*.json"))}
    scenes = {name: scene for name, scene in scenes.items() if not args.only or name in args.only}
    found: dict[tuple, list] = {}
    if args.rows and args.rows.exists():
        found = {(scene, method, seed): rows for scene, method, seed, rows in map(json.loads, args.rows.read_text().splitlines())}
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(args.jobs) as pool:
        folder = Path(name)
        for scene in scenes:
            halved(args.references / f"{scene}.exr", folder / f"{scene}.exr")

        def one(key: tuple[str, str, int]) -> None:
            scene, method, seed = key
            found[key] = measured(args, scenes[scene], folder / f"{scene}.exr", method, seed, folder)
            if args.rows:
                with args.rows.open("a") as file:
                    file.write(json.dumps([*key, found[key]]) + "\n")

        keys = [(scene, method, seed) for seed in range(1, args.seeds + 1) for scene in scenes for method in args.methods]
        list(pool.map(one, (key for key in keys if key not in found)))
    print("| scene | method | seeds | pixels | blocks | stated/true | in bound | denoised: pixels | blocks | stated/true | in bound |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for scene in scenes:
        for method in args.methods:
            print("|", " | ".join([scene, method, *cells([found[key] for key in keys if key[:2] == (scene, method)])]), "|")


if __name__ == "__main__":
    main()
