"""Renders small scenes, each of which isolates a plugin or a parameter, by manylight and by Mitsuba 3, and compares the pictures.

Usage: python referee.py MANYLIGHT [--only PATTERN] [--keep FOLDER] [--jobs N] [--all]

Both programs trace paths (or what the integrator of the scene says) on one thread per job. A picture differs if its mean, or the mean
of one of 3 x 3 parts of it, differs in a channel by more than 1 % and by more than 3.5 standard errors, again with four times the
samples. Other differences are: one of the programs refuses the scene, or ours warns. `known.py` names the causes of differences.
The exit status is 1 if a difference has no named cause. Needs `pip install mitsuba==3.9.1 numpy`; Mitsuba's variant is scalar_rgb.
"""

import fnmatch
import multiprocessing
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

import bsdfs
import cameras
import emitters
import shapes
import textures
from files import FILES, bytes_of, chart
from known import KNOWN
from notation import Case
from referee_table import DARK, MAX_Z, MORE, TOLERANCE, Outcome, Picture, arguments, report

#: Renders of Mitsuba with different seeds, for its standard error.
SEEDS = 8


def all_cases() -> list[Case]:
    return [case for family in (bsdfs, textures, emitters, shapes, cameras) for case in family.all_cases()]


def parts(image: np.ndarray) -> list[np.ndarray]:
    """The picture, and 3 x 3 parts of it."""
    return [image, *(part for band in np.array_split(image, 3) for part in np.array_split(band, 3, axis=1))]


def write_files(folder: Path) -> None:
    """The files that scenes name."""
    import mitsuba as mi

    formats = mi.Bitmap.PixelFormat
    channels = {1: formats.Y, 2: formats.YA, 3: formats.RGB, 4: formats.RGBA}
    (folder / "folder").mkdir(exist_ok=True)
    for name, content in {**FILES, "folder/inside.png": bytes_of(chart(4, 4))}.items():
        if isinstance(content, bytes):
            (folder / name).write_bytes(content)
        else:
            mi.Bitmap(np.ascontiguousarray(content), channels[content.shape[2]]).write(str(folder / name))
    for name, text in cameras.INCLUDED.items():
        (folder / name).write_text(text)


def ours(binary: str, scene: Path, spp: int, seed: int) -> tuple[Picture, list[str]] | str:
    """A picture and warnings, or why there is none."""
    import mitsuba as mi

    output = scene.with_suffix(".exr")
    words = [
        binary,
        "render",
        str(scene),
        "-m",
        "path",
        "-t",
        "1",
        "--spp",
        str(spp),
        "--seed",
        str(seed),
        "--progress",
        "none",
        "-o",
        str(output),
    ]
    done = subprocess.run(words, capture_output=True, text=True)
    plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr)
    if done.returncode != 0:
        found = re.findall("^ *(?:×|error:) (.*)", plain, re.MULTILINE)
        return f"exit {done.returncode}: {(found or [plain.strip()[-100:]])[0]}"
    bitmap = mi.Bitmap(str(output))
    names = [field.name for field in bitmap.struct_()]
    data = np.array(bitmap, dtype=np.float64)

    def layer(prefix: str) -> list[np.ndarray]:
        return parts(data[:, :, [names.index(prefix + channel) for channel in "RGB"]])

    # Variances of pixels, and of the means of blocks of 8 x 8 pixels, whose samples may be correlated.
    counts = [part.shape[0] * part.shape[1] for part in layer("")]
    own = [part.mean((0, 1)) / count for part, count in zip(layer("variance."), counts, strict=True)]
    shared = [part.mean((0, 1)) * 64 / count for part, count in zip(layer("block_variance."), counts, strict=True)]
    means = np.array([part.mean((0, 1)) for part in layer("")])
    return Picture(means, np.maximum(own, shared)), re.findall(r"^warning: (?:[^ ]*: )?(.*)", plain, re.MULTILINE)


def theirs(scene: Path, spp: int, seed: int) -> Picture | str:
    import drjit as dr
    import mitsuba as mi

    count = min(SEEDS, spp)
    try:
        loaded = mi.load_file(str(scene))
        # Mitsuba waits for ever for EXR files where there is one thread.
        dr.set_thread_count(1)
        renders = [np.array(mi.render(loaded, spp=max(spp // count, 1), seed=seed + index), dtype=np.float64) for index in range(count)]
    except Exception as error:  # noqa: BLE001
        return " ".join(str(error).split())[-160:]
    finally:
        dr.set_thread_count(2)
    means = np.array([[part.mean((0, 1)) for part in parts(image[:, :, :3])] for image in renders])
    return Picture(means.mean(0), means.var(0, ddof=1) / count)


def compared(case: Case, binary: str, folder: Path, more: int = 1) -> Outcome:
    scene = folder / (re.sub(r"[^\w.+-]+", "_", case.name) + ".xml")
    scene.write_text(case.xml)
    mine, other = ours(binary, scene, case.spp * more, more), theirs(scene, case.spp * more, 1000 * more)
    if isinstance(mine, str) or isinstance(other, str):
        verdict = "theirs refuses" if not isinstance(mine, str) else "ours refuses" if not isinstance(other, str) else "both refuse"
        return Outcome(case.name, verdict, mine if isinstance(mine, str) else str(other))
    picture, warnings = mine
    off = picture.means - other.means
    usual = np.nan_to_num(np.abs(other.means))
    # A black picture of theirs is compared with the mean of ours.
    scale = np.maximum(usual, max(DARK * usual[0].mean(), DARK * np.abs(picture.means[0]).mean(), 1e-12))
    error = np.sqrt(np.maximum(picture.variances + other.variances, 0)) + 1e-6 * scale + 1e-12
    z = off / error
    wrong = (np.abs(off) > TOLERANCE * scale) & (np.abs(z) > MAX_Z)
    finite = np.isfinite(z)
    wrong |= ~finite
    if not wrong.any():
        return Outcome(case.name, "warns" if warnings else "agrees", "; ".join(warnings), warnings=len(warnings))
    if more == 1:
        return compared(case, binary, folder, MORE)
    # The mean of the picture says more than a part of it.
    worst = np.where(wrong, np.where(finite, np.abs(off) / scale, 0) * np.where(np.arange(len(z)) == 0, 1e6, 1)[:, None], -1)
    part, channel = np.unravel_index(np.argmax(worst), z.shape)
    where = ("mean" if part == 0 else f"part {(part - 1) // 3},{(part - 1) % 3}") + " " + "RGB"[channel]
    where += f"; warns: {'; '.join(warnings)}" if warnings else ""
    return Outcome(case.name, "differs", where, picture.means[part, channel], other.means[part, channel], z[part, channel], len(warnings))


def start_worker() -> None:
    """Prepares a process."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    dr.set_thread_count(2)


def outcomes(cases: list[Case], binary: str, folder: Path, jobs: int) -> Iterator[Outcome]:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=start_worker) as pool:
        pool.submit(write_files, folder).result()
        tasks = [pool.submit(compared, case, binary, folder) for case in cases]
        for task in tasks:
            yield task.result()


def main() -> None:
    args = arguments(__doc__, "rough*")
    cases = [case for case in all_cases() if fnmatch.fnmatchcase(case.name, args.only)]
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        report(outcomes(cases, args.manylight, folder, args.jobs), KNOWN, args.all)


if __name__ == "__main__":
    main()
