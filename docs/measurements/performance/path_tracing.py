"""Times the path tracer beside Mitsuba 3's, in turns, on the same scene files.

Usage: python path_tracing.py MANYLIGHT [MANYLIGHT...] --scenes SCENE.xml... [--width 480] [--spp 64] [--runs 5]

Of both programs the shading counts: stage `shade` of `manylight render`, and Mitsuba's render call, which a first call has
compiled. Neither records layers beside the picture. Size, depth, Russian roulette and samples are equal. A table with the
medians and the ratio Mitsuba / manylight goes to stdout. Needs `pip install mitsuba`, and LLVM as DRJIT_LIBLLVM_PATH.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def ours(binary: str, scene: str, size: list[int], depth: list[int], args: argparse.Namespace) -> float:
    """Seconds of shading."""
    with tempfile.TemporaryDirectory() as folder:
        words = [binary, "render", scene, "-m", "path", "--spp", str(args.spp), "--size", "x".join(map(str, size))]
        words += ["--max-depth", str(depth[0]), "--json", "-q", "-o", f"{folder}/image.png"]
        done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"error: {' '.join(words)}:\n{done.stderr}")
    return json.loads(done.stdout)["stages"]["shade"]


class Rival:
    """A scene in Mitsuba, with its path tracer."""

    def __init__(self, path: str, width: int) -> None:
        import mitsuba as mi

        if not mi.variant():
            mi.set_variant("llvm_ad_rgb")
        self.mi = mi
        self.scene = mi.load_file(path)
        film = self.scene.sensors()[0].film()
        full = [int(x) for x in film.size()]
        self.size = [width, max(1, round(width * full[1] / full[0]))]
        sensor = mi.traverse(self.scene.sensors()[0])
        sensor["film.size"] = self.size
        sensor.update()

    def render(self, depth: list[int], spp: int, seed: int) -> float:
        """Seconds of a render."""
        import drjit as dr

        integrator = self.mi.load_dict({"type": "path", "max_depth": depth[0], "rr_depth": depth[1]})
        start = time.perf_counter()
        image = self.mi.render(self.scene, integrator=integrator, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return time.perf_counter() - start


def limits(binary: str, scene: str) -> list[int]:
    """Depth and Russian roulette of a scene, as both programs take them."""
    done = subprocess.run([binary, "info", scene, "--json"], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)["limits"]
    depth = found["max_depth"]
    return [-1 if depth is None or depth > 1 << 20 else depth, found["rr_depth"]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight", nargs="+", help="programs, as `cargo build --release` makes them")
    parser.add_argument("--scenes", nargs="+", required=True)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    logs: list[list[float]] = [[] for _ in args.manylight]
    print(f"| scene | Mitsuba, s |{''.join(f' {b}, s | ratio |' for b in args.manylight)}")
    print(f"|---|---|{'---|---|' * len(args.manylight)}")
    for scene in args.scenes:
        depth = limits(args.manylight[0], scene)
        rival = Rival(scene, args.width)
        rival.render(depth, args.spp, 0)
        times: list[list[float]] = [[] for _ in range(1 + len(args.manylight))]
        for run in range(args.runs):
            times[0].append(rival.render(depth, args.spp, run + 1))
            for of, binary in zip(times[1:], args.manylight):
                of.append(ours(binary, scene, rival.size, depth, args))
        medians = [statistics.median(of) for of in times]
        cells = ""
        for log, seconds in zip(logs, medians[1:]):
            log.append(math.log(medians[0] / seconds))
            cells += f" {seconds:.2f} | {medians[0] / seconds:.2f} |"
        print(f"| {Path(scene).parent.name} | {medians[0]:.2f} |{cells}", flush=True)
    print("geometric mean: " + ", ".join(f"{math.exp(statistics.mean(log)):.2f}" for log in logs))


if __name__ == "__main__":
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        print("note: DRJIT_LIBLLVM_PATH names no LLVM library", file=sys.stderr)
    main()
