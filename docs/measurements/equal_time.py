#!/usr/bin/env python3
"""Errors at equal time, as rendered and denoised, beside Mitsuba's path tracer and Cycles.

    python3 equal_time.py MANYLIGHT REFERENCES SCENES -o FOLDER [--time 20] [--seeds 3] [--only NAME ...]
    python3 equal_time.py MANYLIGHT --own -o FOLDER --time 30 --rivals mitsuba cycles

REFERENCES has a NAME.exr with the layer `variance` beside a NAME.json with the `file` of the scene in SCENES, `size` and
`max_depth`. --own takes the five scenes of paper/plan.json instead, and one seed of each rival. Every picture stays in FOLDER, and is not made again.
Error: relMSE over pixels whose reference is known to a tenth, without the worst thousandth, less the noise of the reference;
with --all-pixels over all.
Mitsuba is filtered by Open Image Denoise with features of 256 samples of ours; as ours, after its time. Cycles filters inside
its time, and clamps indirect light to 10, as Blender does. Seeds and programs take turns; a figure is the median over seeds.
Needs: pip install mitsuba==3.9.1 pyoidn==2.5.1.0 OpenEXR numpy, and for Cycles bpy==5.0.1 in the Python of --blender-python.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR

HERE = Path(__file__).resolve().parent
RIVALS = HERE / "paper" / "rivals"
OWN = {"cbox": ("glossy-cornell", 12), "u-shape": ("u-shape", 24), "kitchen": ("kitchen", 16), "garage": ("garage", 12), "disco": ("disco", 12)}


def main() -> None:
    args = arguments()
    args.output /= "own" if args.own else "shared"
    args.output.mkdir(parents=True, exist_ok=True)
    names = [*args.methods, *args.rivals]
    print("| scene |", " | ".join(f"{name}, denoised | as rendered | mean" for name in names), "|")
    print("|---|" + "---|" * 3 * len(names))
    table = {}
    for scene in own_scenes() if args.own else shared_scenes(args):
        if args.only and scene["name"] not in args.only:
            continue
        rows = {name: [] for name in names}
        for seed in range(1, args.seeds + 1):
            for name in names:
                if not args.own or name in args.methods or seed == 1:
                    rows[name].append(measured(args, scene, name, seed))
        table[scene["name"]] = {name: np.median(rows[name], axis=0) for name in names}
        cells = [f"{d:.2g} | {r:.2g} | {m:.4f}" for d, r, m in table[scene["name"]].values()]
        print("|", scene["name"], "|", " | ".join(cells), "|", flush=True)
    for rival in args.rivals:
        for method in args.methods:
            ratios = np.array([row[rival][:2] / row[method][:2] for row in table.values()])
            mean, least = np.exp(np.log(ratios).mean(0)), ratios.min(0)
            print(f"{rival} over {method}: denoised {mean[0]:.2f}, least {least[0]:.2f}; as rendered {mean[1]:.2f}, least {least[1]:.2f}")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight")
    parser.add_argument("references", type=Path, nargs="?")
    parser.add_argument("scenes", type=Path, nargs="?")
    parser.add_argument("--own", action="store_true")
    parser.add_argument("--all-pixels", action="store_true")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--time", type=float, default=20)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--methods", nargs="+", default=["auto", "path"])
    parser.add_argument("--rivals", nargs="*", default=["mitsuba"], choices=["mitsuba", "cycles"])
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--blender-python", default=sys.executable)
    return parser.parse_args()


def own_scenes():
    for name, (folder, depth) in OWN.items():
        size = [240, 240] if name == "cbox" else [320, 180]
        file = HERE.parent.parent / "scenes" / folder / "scene.xml"
        reference = HERE / "paper" / "references" / "quick" / f"{name}.exr"
        yield {"name": name, "file": file, "size": size, "max_depth": depth, "reference": reference}


def shared_scenes(args):
    for file in sorted(args.references.glob("*.json")):
        scene = json.loads(file.read_text())
        yield {**scene, "name": file.stem, "file": args.scenes / scene["file"], "reference": file.with_suffix(".exr")}


def measured(args, scene: dict, name: str, seed: int) -> tuple[float, float, float]:
    """Error of the denoised picture, error as rendered, mean over that of the reference. Cycles has a denoised picture alone."""
    path = args.output / f"{scene['name']}.{name}.{args.time:g}s.{seed}.exr"
    common = ["--size", "x".join(map(str, scene["size"])), "--filter", "box", "--max-depth", str(scene["max_depth"])]
    time = ["--time", f"{args.time:g}s", "--seed", str(seed), "-o", str(path)]
    if not path.exists():
        if name == "mitsuba":
            run(sys.executable, RIVALS / "mitsuba_path.py", scene["file"], *common, *time)
        elif name == "cycles":
            cycles = [RIVALS / "cycles_path.py", scene["file"], "--denoise", "--clamp-indirect", "10"]
            run(args.blender_python, *cycles, *common, *time)
        else:
            run(args.manylight, "render", scene["file"], "-m", name, *common, *time, "-q", "--denoise", "oidn")
    reference, picture = channels(scene["reference"]), channels(path)
    truth, variance = rgb(reference), rgb(reference, "variance.")
    denoised = rgb(picture)
    noisy = rgb(picture, "noisy.") if "noisy.R" in picture else denoised
    if name == "mitsuba":
        sys.path.insert(0, str(RIVALS))
        from mitsuba_path import denoise

        guides = features(args, scene, common)
        denoised = denoise(noisy, rgb(guides, "albedo."), rgb(guides, "normal.", "XYZ"))
    error = error_of_all if args.all_pixels else error_of_known
    return error(denoised, truth, variance), error(noisy, truth, variance), noisy.mean() / truth.mean()


def features(args, scene: dict, common: list[str]) -> dict:
    path = args.output / f"{scene['name']}.features.exr"
    if not path.exists():
        run(args.manylight, "render", scene["file"], "-m", "aov", "--spp", "256", *common[:4], "-q", "-o", path)
    return channels(path)


def run(*words) -> None:
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def channels(path: Path) -> dict:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: np.asarray(channel.pixels, np.float64) for part in file.parts for name, channel in part.channels.items()}


def rgb(picture: dict, layer: str = "", names: str = "RGB") -> np.ndarray:
    return np.stack([picture[layer + name] for name in names], -1)


def error_of_all(picture: np.ndarray, truth: np.ndarray, variance: np.ndarray) -> float:
    """relMSE of all pixels, less the noise of the reference."""
    scale = truth**2 + 0.01 * truth.mean() ** 2
    return float((((picture - truth) ** 2 - variance) / scale).mean())


def error_of_known(picture: np.ndarray, truth: np.ndarray, variance: np.ndarray) -> float:
    """relMSE where the reference is known, without the worst thousandth, less the noise of the reference."""
    mean = truth.mean()
    scale = truth**2 + 0.01 * mean**2
    known = np.sqrt(variance.mean(-1)) < 0.1 * (truth.mean(-1) + 0.1 * mean)
    squares, noise = (((picture - truth) ** 2 / scale).mean(-1)[known], (variance / scale).mean(-1)[known])
    kept = np.argsort(squares)[: int(len(squares) * 0.999)]
    return max(squares[kept].mean() - noise[kept].mean(), 0.1 * noise[kept].mean(), 1e-6)


if __name__ == "__main__":
    main()
