#!/usr/bin/env python3
"""Path tracing by Mitsuba 3, called as `manylight render` is: for plans of `manylight study`, and to make their references.

    python3 mitsuba_path.py SCENE.xml --time 120s --size 640x360 --max-depth 12 --json --output OUT.exr
    python3 mitsuba_path.py SCENE.xml --spp 4096 --size 640x360 --max-depth 12 --output OUT.exr

OUT.exr has the channels R, G, B and the variance of these means, from batches that are independent of each other. The
filter is the box. Scenes are compiled before the clock starts. Needs `pip install mitsuba numpy`.
"""
import argparse
import json
import re
import sys
import time
from pathlib import Path

import numpy as np

import mitsuba as mi

#: Samples per pixel of a batch: large enough for the vector units, small enough to end near the time.
BATCH = 16
#: Batches at least, without which there is no variance.
LEAST_BATCHES = 4


def main():
    words = arguments()
    variant = choose_variant()
    scene = load(words.scene, words.size)
    integrator = mi.load_dict({"type": "path", "max_depth": words.max_depth})
    per_batch = BATCH if words.spp is None else max(1, min(BATCH, words.spp // LEAST_BATCHES))
    # Compiles everything; these samples are not used.
    render(scene, integrator, per_batch, words.seed + 1_000_000_007)

    start = time.monotonic()
    mean, squares, batches = 0.0, 0.0, 0
    while not is_done(words, batches, per_batch, time.monotonic() - start):
        image = render(scene, integrator, per_batch, words.seed + batches)
        image[~np.isfinite(image)] = 0.0
        batches += 1
        difference = image - mean
        mean = mean + difference / batches
        squares = squares + difference * (image - mean)
        if words.progress:
            print(f"{batches * per_batch} spp, {time.monotonic() - start:.0f} s", file=sys.stderr)
    seconds = time.monotonic() - start

    variance = squares / (batches - 1) / batches
    for path in words.output:
        write(path, mean, variance)
    if words.json:
        report = {
            "version": f"Mitsuba {mi.__version__}",
            "settings": {"variant": variant, "integrator": "path", "max_depth": words.max_depth},
            "stages": {"path": seconds},
            "counts": {"passes": batches * per_batch},
        }
        print(json.dumps(report))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    budget = parser.add_mutually_exclusive_group(required=True)
    budget.add_argument("--time", type=seconds_of, help="such as 90s or 2m")
    budget.add_argument("--spp", type=int)
    parser.add_argument("--size", required=True, type=lambda text: tuple(int(n) for n in text.split("x")))
    parser.add_argument("--max-depth", type=int, default=-1)
    parser.add_argument("--filter", choices=["box"], default="box")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", "-o", action="append", required=True, type=Path)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--progress", choices=["none", "plain"], default=None)
    words = parser.parse_args()
    words.progress = words.progress == "plain" and not words.quiet
    return words


def seconds_of(text):
    found = re.fullmatch(r"([0-9.]+)(s|m|h)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"found {text}, expected a time such as 90s or 2m")
    return float(found[1]) * {"s": 1, "m": 60, "h": 3600}[found[2]]


def choose_variant():
    """The fastest variant of the processor that works here."""
    for variant in ["llvm_ad_rgb", "scalar_rgb"]:
        try:
            mi.set_variant(variant)
            mi.render(mi.load_dict(mi.cornell_box()), spp=1)
            return variant
        except (ImportError, RuntimeError) as error:
            print(f"{variant}: {error}", file=sys.stderr)
    sys.exit("no variant of Mitsuba works here")


def load(path, size):
    """The scene with the box filter and the given size of the film."""
    text = path.read_text(encoding="utf-8", errors="replace")
    text = re.sub(r"<rfilter\b[^>]*?/>|<rfilter\b.*?</rfilter>", "", text, flags=re.S)
    text, films = re.subn(r"(<film\b[^>]*[^/]>)", r'\1<rfilter type="box"/>', text)
    if films == 0:
        sys.exit(f"{path}: found no film with settings; expected one to take the box filter")
    mi.file_resolver().append(str(path.resolve().parent))
    scene = mi.load_string(text)
    parameters = mi.traverse(scene.sensors()[0])
    parameters["film.size"] = list(size)
    parameters.update()
    return scene


def render(scene, integrator, spp, seed):
    image = mi.render(scene, integrator=integrator, spp=spp, seed=seed)
    return np.array(image)[:, :, :3].astype(np.float64)


def is_done(words, batches, per_batch, seconds):
    """Whether another batch would end farther from what is asked."""
    if batches < LEAST_BATCHES:
        return False
    if words.spp is not None:
        return batches * per_batch >= words.spp
    return seconds + 0.5 * seconds / batches > words.time


def write(path, mean, variance):
    if path.suffix != ".exr":
        picture = mi.Bitmap(mean.astype(np.float32))
        picture.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True).write(str(path))
        return
    channels = np.concatenate([mean, variance], axis=2).astype(np.float32)
    names = ["R", "G", "B", "variance.R", "variance.G", "variance.B"]
    mi.Bitmap(channels, mi.Bitmap.PixelFormat.MultiChannel, channel_names=names).write(str(path))


if __name__ == "__main__":
    main()
