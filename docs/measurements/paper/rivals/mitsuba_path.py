#!/usr/bin/env python3
"""Path tracing by Mitsuba 3, called as `manylight render` is: for plans of `manylight study`, and to make their references.

    python3 mitsuba_path.py SCENE.xml --time 120s --size 640x360 --max-depth 12 [--denoise] --json --output OUT.exr
    python3 mitsuba_path.py SCENE.xml --spp 4096 --size 640x360 --max-depth 12 --output OUT.exr

OUT.exr has the channels R, G, B and, if it is not denoised, the variance of these means, from batches that are
independent of each other. The filter is the box. Scenes are compiled before the clock starts. --denoise is Open Image
Denoise with albedo and normal of the first surface; their samples and the denoising are inside the time. Needs
`pip install mitsuba numpy OpenEXR`, and pyoidn to denoise.
"""
import re
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import program

try:
    import mitsuba as mi
except ImportError:
    program.unavailable("Mitsuba is not installed: pip install mitsuba")

#: Samples per pixel of a batch: large enough for the vector units, small enough to end near the time.
BATCH = 16
#: Batches at least, without which there is no variance.
LEAST_BATCHES = 4
#: Samples per pixel of albedo and normal.
FEATURE_SAMPLES = 64


def main():
    parser = program.parser(__doc__)
    parser.add_argument("--denoise", action="store_true")
    words = parser.parse_args()
    variant = choose_variant()
    scene = load(words.scene, words.size)
    integrator = mi.load_dict({"type": "path", "max_depth": words.max_depth})
    per_batch = BATCH if words.spp is None else max(1, min(BATCH, words.spp // LEAST_BATCHES))
    # Compiles everything; these samples are not used.
    image = render(scene, integrator, per_batch, words.seed + 1_000_000_007)
    denoising = Denoising(scene, image, words) if words.denoise else None

    start = time.monotonic()
    features = denoising.features(words.seed) if denoising else None
    begun = time.monotonic()
    left = None if words.time is None else words.time - (begun - start) - (denoising.seconds if denoising else 0.0)
    mean, squares, batches = 0.0, 0.0, 0
    while not is_done(words, left, batches, per_batch, time.monotonic() - begun):
        image = render(scene, integrator, per_batch, words.seed + batches)
        image[~np.isfinite(image)] = 0.0
        batches += 1
        difference = image - mean
        mean = mean + difference / batches
        squares = squares + difference * (image - mean)
        if words.progress == "plain" and not words.quiet:
            print(f"{batches * per_batch} spp, {time.monotonic() - begun:.0f} s", file=sys.stderr)
    tracing = time.monotonic() - start
    variance = squares / (batches - 1) / batches
    if denoising:
        mean, variance = denoise(mean, *features), None
    seconds = time.monotonic() - start

    for path in words.output:
        program.write(path, mean, variance)
    if words.json:
        settings = {"variant": variant, "integrator": "path", "max_depth": words.max_depth, "denoiser": words.denoise}
        stages = {"path": tracing, "denoise": seconds - tracing} if denoising else {"path": seconds}
        program.report(f"Mitsuba {mi.__version__}", settings, stages, {"passes": batches * per_batch})


class Denoising:
    """Albedo and normal, and how long the denoiser takes. `image` is any image of the scene."""

    def __init__(self, scene, image, words):
        self.scene = scene
        self.integrator = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"})
        features = self.features(words.seed)
        denoise(image, *features)
        start = time.monotonic()
        denoise(image, *features)
        self.seconds = time.monotonic() - start

    def features(self, seed):
        image = mi.render(self.scene, integrator=self.integrator, spp=FEATURE_SAMPLES, seed=seed + 1_000_000_009)
        channels = np.array(image)
        return channels[:, :, -6:-3], channels[:, :, -3:]


def denoise(image, albedo, normal):
    """The image by Open Image Denoise."""
    try:
        import pyoidn
    except ImportError:
        program.unavailable("Open Image Denoise is not installed: pip install pyoidn")
    single = lambda values, low, high: np.ascontiguousarray(np.clip(values, low, high), np.float32)
    features = {"albedo": single(albedo, 0, 1), "normal": single(normal, -1, 1), "clean_aux": True}
    return pyoidn.denoise(single(image, 0, None), hdr=True, quality="high", **features).astype(np.float64)


def choose_variant():
    """The fastest variant of the processor that works here."""
    for variant in ["llvm_ad_rgb", "scalar_rgb"]:
        try:
            mi.set_variant(variant)
            mi.render(mi.load_dict(mi.cornell_box()), spp=1)
            return variant
        except (ImportError, RuntimeError) as error:
            print(f"{variant}: {error}", file=sys.stderr)
    return program.unavailable("no variant of Mitsuba works here")


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


def is_done(words, left, batches, per_batch, seconds):
    """Whether another batch would end farther from what is asked."""
    if batches < LEAST_BATCHES:
        return False
    if words.spp is not None:
        return batches * per_batch >= words.spp
    return seconds + 0.5 * seconds / batches > left


if __name__ == "__main__":
    main()
