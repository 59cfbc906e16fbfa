"""Renders small glTF files, each of which isolates a feature, by manylight and by Cycles, and compares the pictures.

Usage: python referee.py MANYLIGHT [--only PATTERN] [--keep FOLDER] [--jobs N] [--all]

A picture differs if its mean, or the mean of a block of 8 x 8 pixels, differs in a channel by more than 1 % and by more than 3.5 standard
errors, again with four times the samples. The standard error is that of both: of the variance layers of our picture, and of two renders
by Cycles with different seeds. It counts as a difference as well if our program refuses the file, or warns. `known.py` names the
causes of differences. The exit status is 1 if one has no named cause. Needs `pip install bpy==5.0.1 numpy OpenEXR`. Each job is one process
of Blender, and renders by one thread.
"""

import fnmatch
import json
import multiprocessing
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

# What this and the other comparison share stands beside their folders.
sys.path.append(str(Path(__file__).resolve().parents[1]))

import materials
import places
from known import KNOWN
from referee_table import DARK, MAX_Z, MORE, TOLERANCE, Outcome, Picture, arguments, report
from scenes import Case

#: Edge of a block in pixels.
BLOCK = 8
#: Radiances below this one are black. Panels and white environments make 0.01 to 1.
BLACK = 1e-4
#: A warning of scenes that panels light, which does not say that a feature is not read.
USUAL = "emitting surfaces alone light the scene"


def blocks(image: np.ndarray) -> np.ndarray:
    """The mean of the picture, and those of its blocks from the upper left on."""
    height, width, channels = image.shape
    tiles = image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean((1, 3))
    return np.concatenate([image.mean((0, 1))[None], tiles.reshape(-1, channels)])


def layers(path: Path) -> dict[str, np.ndarray]:
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.astype(float) for name, channel in file.channels().items()}


def color(channels: dict[str, np.ndarray], prefix: str = "") -> np.ndarray:
    return np.stack([channels[prefix + name] for name in "RGB"], -1)


def pixels_in(image: np.ndarray) -> np.ndarray:
    """The numbers of pixels of the picture and of its blocks."""
    height, width = image.shape[:2]
    return np.array([height * width] + [BLOCK * BLOCK] * (height * width // BLOCK**2))[:, None]


def ours(binary: str, case: Case, file: Path, more: int) -> tuple[Picture, list[str]] | str:
    """A picture and warnings, or why there is none."""
    output = file.with_suffix(".ours.exr")
    words = [binary, "render", str(file), "-m", "path", "--filter", "box", "-t", "1", "--progress", "none", "-o", str(output)]
    words += ["--size", "x".join(map(str, case.size)), "--spp", str(case.spp * more), "--seed", str(more), "--light-units", "lm"]
    words += ["--environment", "white"] if case.environment == "white" else []
    done = subprocess.run(words, capture_output=True, text=True)
    plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr)
    if done.returncode != 0:
        found = re.findall("^ *(?:×|error:) (.*)", plain, re.MULTILINE)
        return f"exit {done.returncode}: {(found or [plain.strip()[-100:]])[0]}"
    channels = layers(output)
    # Variances of pixels, and of the means of blocks of 8 x 8 pixels, whose samples may be correlated.
    count = pixels_in(color(channels))
    own = blocks(color(channels, "variance.")) / count
    shared = blocks(color(channels, "block_variance.")) * BLOCK**2 / count
    warnings = re.findall(r"^warning: (?:[^ ]*: )?(.*)", plain, re.MULTILINE)
    return Picture(blocks(color(channels)), np.maximum(own, shared)), [warning for warning in warnings if USUAL not in warning]


def theirs(case: Case, file: Path, more: int) -> Picture:
    """The mean of two renders. Half of the difference of a pixel is its standard deviation in the mean."""
    import by_cycles

    halves = []
    for seed in range(2):
        by_cycles.read(str(file), by_cycles.Settings(case.size, case.spp * more // 2, case.environment, 2 * more + seed, threads=1))
        output = file.with_suffix(f".cycles{seed}.exr")
        by_cycles.render(str(output))
        halves.append(color(layers(output)))
    spread = (halves[0] - halves[1]) / 2
    return Picture(blocks((halves[0] + halves[1]) / 2), blocks(spread**2) / pixels_in(spread))


def compared(case: Case, binary: str, folder: Path, more: int = 1) -> Outcome:
    file = folder / (re.sub(r"[^\w.+-]+", "_", case.name) + ".gltf")
    file.write_text(json.dumps(case.gltf))
    mine = ours(binary, case, file, more)
    if isinstance(mine, str):
        return Outcome(case.name, "refused", mine)
    picture, warnings = mine
    if case.rewritten:
        file = file.with_suffix(".rewritten.gltf")
        file.write_text(json.dumps(case.rewritten))
    other = theirs(case, file, more)
    off = picture.means - other.means
    # A black picture of theirs is compared with the mean of ours.
    floor = DARK * np.maximum(other.means[0].mean(), picture.means[0].mean())
    scale = np.maximum(np.abs(other.means), max(floor, BLACK))
    z = off / (np.sqrt(np.maximum(picture.variances + other.variances, 0)) + 1e-6 * scale)
    wrong = ~(np.abs(off) <= TOLERANCE * scale) & ~(np.abs(z) <= MAX_Z)
    if not wrong.any():
        return Outcome(case.name, "warns" if warnings else "agrees", "; ".join(warnings), picture.means[0].mean(), other.means[0].mean())
    if more == 1:
        return compared(case, binary, folder, MORE)
    # The mean of the picture says more than a block of it.
    worst = np.where(wrong, np.nan_to_num(np.abs(off) / scale, nan=1e3), -1)
    worst[0] *= 1e6
    part, channel = np.unravel_index(np.argmax(worst), z.shape)
    columns = case.size[0] // BLOCK
    where = ("mean" if part == 0 else f"block {(part - 1) // columns},{(part - 1) % columns}") + " " + "RGB"[channel]
    where += f"; warns: {'; '.join(warnings)}" if warnings else ""
    return Outcome(case.name, "differs", where, picture.means[part, channel], other.means[part, channel], z[part, channel])


def start_worker() -> None:
    """Prepares a process. Blender prints every step of a render."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def outcomes(cases: list[Case], binary: str, folder: Path, jobs: int) -> Iterator[Outcome]:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=start_worker) as pool:
        for task in [pool.submit(compared, case, binary, folder) for case in cases]:
            yield task.result()


def main() -> None:
    args = arguments(__doc__, "alpha*")
    every = [*materials.all_cases(), *places.all_cases()]
    cases = [case for case in every if fnmatch.fnmatchcase(case.name, args.only)]
    with tempfile.TemporaryDirectory() as temporary:
        folder = (args.keep or Path(temporary)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        report(outcomes(cases, args.manylight, folder, args.jobs), KNOWN, args.all)


if __name__ == "__main__":
    main()
