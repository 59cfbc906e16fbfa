"""Measures the flicker of walkthroughs, and the error of their frames, at equal time.

Usage: python flicker.py MANYLIGHT SCENE.xml [--frames 8] [--width 160] [--passes 8] [--depth 12] [--step 0.01] [--reference 1024 | --own-reference 32] [--keep FOLDER]

The camera of the scene moves to its side, by `--step` of the distance to what it sees in the middle. For each method:

* flicker: points that two successive frames see (the positions of both agree within a pixel) are compared. The error of a frame
  is its difference to the reference by Mitsuba's path tracer, or by `rich-vpl` where paths hardly find the light, so that reflections that move do not count. Flicker is the root of the mean
  squared change of this error, relative to radiance;
* relMSE: the mean of the squared error over squared radiance.

Squares are products of the differences to two references with independent noise, which therefore does not count. Both figures are
without the worst thousandth. `shared` is `rich-vpl --cameras`; `apart` the same with other lights for each frame;
the others are path tracing, and both denoised. Their passes are chosen so that all take the time of `shared`, denoised or not.
`steady` are frames averaged by `manylight steady`, whose time is counted.
Needs `pip install mitsuba==3.9.1 OpenEXR numpy`, and pyoidn for the denoised rows.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import OpenEXR

TRIMMED = 0.001


def channels(path):
    parts = OpenEXR.File(str(path), separate_channels=True).parts
    return {name: channel.pixels.astype(np.float64) for part in parts for name, channel in part.channels.items()}


def layer(content, names):
    return np.stack([content[name] for name in names], -1)


def trimmed_mean(values):
    values = np.sort(values)
    return values[: max(1, int(len(values) * (1 - TRIMMED)))].mean()


class Walk:
    """A camera that moves to its side."""

    def __init__(self, words):
        self.words = words
        mi.set_variant("llvm_ad_rgb")
        self.scene = mi.load_file(words.scene)
        sensor = self.scene.sensors()[0]
        start = np.array(sensor.world_transform().matrix, dtype=np.float64).reshape(4, 4)
        ray, _ = sensor.sample_ray(0, 0.5, mi.Point2f(0.5, 0.5), mi.Point2f(0.5, 0.5))
        distance = float(self.scene.ray_intersect(mi.Ray3f(ray)).t[0])
        middle = (words.frames - 1) / 2
        self.cameras = []
        for frame in range(words.frames):
            moved = start.copy()
            moved[:3, 3] += (frame - middle) * words.step * distance * start[:3, 0] / np.linalg.norm(start[:3, 0])
            self.cameras.append(moved)
        # Mitsuba keeps the horizontal angle.
        self.fov_x = np.tan(np.radians(float(np.array(mi.traverse(sensor)["x_fov"]).ravel()[0])) / 2)
        film = sensor.film().size()
        words.size = (words.width, round(words.width * film[1] / film[0]))

    def reference(self, frame, spp):
        """Radiance by path tracing, twice."""
        sensor = self.scene.sensors()[0]
        parameters = mi.traverse(sensor)
        parameters["film.size"] = list(self.words.size)
        parameters["to_world"] = mi.ScalarTransform4f(self.cameras[frame])
        parameters.update()
        integrator = mi.load_dict({"type": "path", "max_depth": self.words.depth})
        batches = [
            np.array(mi.render(self.scene, integrator=integrator, sensor=sensor, spp=spp // 2, seed=2 * frame + k))[:, :, :3]
            for k in range(2)
        ]
        return np.nan_to_num(np.array(batches, dtype=np.float64))

    def pixels_of(self, points, frame):
        """Film positions in pixels of world points (..., 3)."""
        inverse = np.linalg.inv(self.cameras[frame])
        local = points @ inverse[:3, :3].T + inverse[:3, 3]
        x, y = self.words.size
        scale = x / (2 * self.fov_x)
        return np.stack([x / 2 - local[..., 0] / local[..., 2] * scale, y / 2 - local[..., 1] / local[..., 2] * scale], -1), local[..., 2]


def sampled(image, at):
    """Bilinear values of an image at film positions."""
    height, width = image.shape[:2]
    x, y = np.clip(at[..., 0] - 0.5, 0, width - 1.001), np.clip(at[..., 1] - 0.5, 0, height - 1.001)
    i, j = x.astype(int), y.astype(int)
    u, v = (x - i)[..., None], (y - j)[..., None]
    row = lambda j: image[j, i] * (1 - u) + image[j, i + 1] * u
    return row(j) * (1 - v) + row(j + 1) * v


def flicker(walk, frames, positions, references):
    changes = []
    errors = [image - both for image, both in zip(frames, references, strict=True)]
    for frame in range(len(errors) - 1):
        here, there = positions[frame], positions[frame + 1]
        at, depth = walk.pixels_of(here, frame + 1)
        width = depth * 2 * walk.fov_x / walk.words.size[0]
        size = np.array(walk.words.size)
        seen = (at > 0.5).all(-1) & (at < size - 0.5).all(-1) & (np.linalg.norm(sampled(there, at) - here, axis=-1) < width)
        first, second = (sampled(then, at) - now for then, now in zip(errors[frame + 1], errors[frame], strict=True))
        change = (first * second).mean(-1)
        radiance = references[frame].mean((0, -1))
        changes.append((change / (radiance**2 + 0.01 * radiance.mean() ** 2))[seen])
    return float(np.sqrt(max(0, trimmed_mean(np.concatenate(changes)))))


def relmse(frames, references):
    errors = []
    for image, (first, second) in zip(frames, references, strict=True):
        reference = (first + second) / 2
        scale = reference**2 + 0.01 * reference.mean() ** 2
        errors.append(((image - first) * (image - second) / scale).mean(-1).ravel())
    return float(trimmed_mean(np.concatenate(errors)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight")
    parser.add_argument("scene")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--width", type=int, default=160)
    parser.add_argument("--passes", type=int, default=8)
    parser.add_argument("--depth", type=int, default=12)
    parser.add_argument("--step", type=float, default=0.01)
    parser.add_argument("--reference", type=int, default=1024)
    parser.add_argument("--own-reference", type=int, help="passes of each of two references by rich-vpl")
    parser.add_argument("--keep", type=Path, help="folder in which frames and references stay; references there are used again")
    words = parser.parse_args()
    folder = words.keep or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    walk = Walk(words)
    cameras = folder / "walk.json"
    cameras.write_text(json.dumps([camera.tolist() for camera in walk.cameras]))

    def render(name, *options):
        """Seconds of all frames."""
        size = "%dx%d" % words.size
        command = [words.manylight, "render", words.scene, "--cameras", str(cameras), "--size", size, "--filter", "box"]
        command += ["--max-depth", str(words.depth), "--aov", "position", "-q", "-o", str(folder / f"{name}.exr"), *options]
        return timed(command)

    def timed(command):
        start = time.monotonic()
        subprocess.run(command, check=True)
        return time.monotonic() - start

    def steady(name):
        return timed([words.manylight, "steady", str(folder / f"{name}.exr"), "-q", "-o", str(folder / f"{name}-steady.exr")])

    def frames_of(name):
        return [channels(folder / f"{name}.{frame + 1:04}.exr") for frame in range(words.frames)]

    render("aov", "-m", "aov", "--passes", "16")
    positions = [layer(frame, ["position.X", "position.Y", "position.Z"]) for frame in frames_of("aov")]
    print(f"{words.frames} frames of {words.size[0]}x{words.size[1]}")
    kept = folder / "references.npy"
    if kept.exists():
        references = list(np.load(kept))
    elif words.own_reference:
        batches = []
        for batch in range(2):
            for frame in range(words.frames):
                seed = 1000 + 2 * frame + batch
                render("reference", "-m", "rich-vpl", "--passes", str(words.own_reference), "--frames", str(frame + 1), "--seed", str(seed))
            batches.append([layer(frame, "RGB") for frame in frames_of("reference")])
        references = np.array(batches).swapaxes(0, 1)
    else:
        references = [walk.reference(frame, words.reference) for frame in range(words.frames)]
    np.save(kept, np.array(references))
    budget = {}
    for denoised in ([], ["--denoise", "oidn"]):
        tag = "-denoised" if denoised else ""
        seconds = render("shared" + tag, "-m", "rich-vpl", "--passes", str(words.passes), *denoised)
        budget["shared" + tag] = (seconds, words.passes)

        def path(passes, tag=tag, denoised=denoised):
            return render("path" + tag, "-m", "path", "--passes", str(passes), *denoised)

        def apart(passes, tag=tag, denoised=denoised):
            numbers = range(1, words.frames + 1)
            of_frame = ["-m", "rich-vpl", "--passes", str(passes), *denoised]
            return sum(render("apart" + tag, *of_frame, "--frames", str(k), "--seed", str(k)) for k in numbers)

        for name, method, few, many in (("apart", apart, 1, 3), ("path", path, 8, 200)):
            # Time is linear in the passes.
            a, b = method(few), method(many)
            passes = max(1, round(few + (seconds - a) * (many - few) / max(b - a, 1e-3)))
            budget[name + tag] = (method(passes), passes)
    for name in ("shared", "shared-denoised", "path-denoised"):
        seconds, passes = budget[name]
        budget[f"{name}-steady"] = (seconds + steady(name), passes)
    for name, (seconds, passes) in budget.items():
        pictures = [layer(frame, "RGB") for frame in frames_of(name)]
        moving, error = flicker(walk, pictures, positions, references), relmse(pictures, references)
        each = f"{passes:4} passes {seconds / words.frames:6.2f} s a frame"
        print(f"{name:22} {each}, flicker {moving:.4f}, relMSE {error:.5f}", flush=True)


if __name__ == "__main__":
    main()
