"""Renders hard scenes by manylight and by Mitsuba 3, and compares the pictures.

Usage: python scene_faults.py MANYLIGHT [--only TEXT]... [--methods NAME...] [--fields] [--large] [--keep FOLDER] [--wait COMMAND]

A table with a row per picture goes to stdout: ratio of means to the reference, how many standard errors that is, seconds, peak memory.
The reference is the known radiance, Mitsuba's path tracer, or without it our path tracer. `--fields` replaces every number of a scene by NaN,
infinities, 0, negative and huge values. `--large` renders the largest scenes instead. The exit code is 1 if anything is wrong. `--wait` is put
before commands that take processor time. Needs numpy and OpenEXR; with mitsuba, LLVM as DRJIT_LIBLLVM_PATH.
"""

import argparse
import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hard_cases import all_cases
from hard_fields import all_fields
from hard_scenes import SIZE, Case
from large_scenes import check_large

HERE = Path(__file__).parent
MANY = ["-n", "128", "--photons", "8192"]
#: Options of each method, and how far the mean may be off: bias that docs/many_light.md and docs/photon_map.md name.
METHODS: dict[str, tuple[list[str], float]] = {
    "path": ([], 0.004),
    "light-trace": ([], 0.01),
    "photon-map": (["--photons", "16384"], 0.03),
    "rich-vpl": (MANY, 0.015),
    "rich-lightcuts": (MANY, 0.03),
}
#: Samples of the case for one pass: passes have different cost and noise.
PER_PASS = {"light-trace": 1, "photon-map": 8, "rich-vpl": 8, "rich-lightcuts": 8}
#: Differences of means within as many standard errors are noise.
MAX_Z = 4.5
#: Renders of Mitsuba with different seeds, for the error of its mean.
SEEDS = 8


@dataclass
class Run:
    """A finished process."""

    code: int
    stdout: str
    stderr: str
    seconds: float
    peak_mb: float


@dataclass
class Picture:
    """Mean and variance of the mean over the film, and both for blocks of 8 x 8 pixels."""

    mean: float
    variance: float
    blocks: np.ndarray
    block_variance: np.ndarray


def run(words: list[str], limit: float = 300, wait: list[str] | None = None) -> Run:
    """Runs a command, after `wait` if that is given; code 124 says that it took longer than `limit` seconds."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.perf_counter()
        limited = [*(wait or []), "timeout", "--kill-after=5", str(limit), *words]
        child = subprocess.Popen(limited, stdout=out, stderr=err, env=os.environ | {"PYTHONPATH": str(HERE)})
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.perf_counter() - start
        out.seek(0), err.seek(0)
        found = Run(child.returncode, out.read(), err.read(), seconds, usage.ru_maxrss / 1024)
    if found.code == 0 and '"stages"' in found.stdout:
        # Without the time to wait.
        report = json.loads(found.stdout)
        found.seconds, found.peak_mb = sum(report["stages"].values()), report["memory"]["peak_bytes"] / 2**20
    return found


def blocks_of(image: np.ndarray) -> np.ndarray:
    return image.reshape(SIZE // 8, 8, SIZE // 8, 8).mean((1, 3))


def read_exr(path: Path) -> tuple[Picture, int]:
    """A picture of manylight, and the number of values that are not finite."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
        over_passes = [float(x) for x in str(file.header()["variance_of_mean"]).split()]
    grey = sum(channels[c] for c in "RGB") / 3
    # Channels have much of their noise in common. Pixels that share photons do, too: that noise is in the variance of blocks.
    variance, shared = (sum(channels[f"{layer}.{c}"] for c in "RGB") / 3 for layer in ("variance", "block_variance"))
    block_variance = np.maximum(blocks_of(variance) / 64, blocks_of(shared))
    bad = sum(int((~np.isfinite(x)).sum()) for name, x in channels.items() if not name.startswith(("depth", "variance", "block_variance")))
    return Picture(grey.mean(), sum(over_passes) / 3, blocks_of(grey), block_variance), bad


def not_finite(path: Path) -> int:
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        return sum(int((~np.isfinite(file.channels()[c].pixels)).sum()) for c in "RGB")


def mitsuba_worker(listed: Path) -> None:
    """Renders the scenes in a list, one JSON line each, with Mitsuba."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    for name, xml, spp, out in json.loads(listed.read_text()):
        start = time.perf_counter()
        try:
            loaded = mi.load_file(xml)
            images = [np.array(mi.render(loaded, spp=spp, seed=seed)).astype(np.float64).mean(2) for seed in range(SEEDS)]
            images = np.stack(images)
            np.save(out, np.stack([images.mean(0), images.var(0, ddof=1) / SEEDS]))
            means = images.mean((1, 2))
            found = {"mean": means.mean(), "variance": means.var(ddof=1) / SEEDS}
        except Exception as error:  # noqa: BLE001
            found = {"message": " ".join(str(error).split())[-160:]}
        print(json.dumps({"name": name, "seconds": time.perf_counter() - start} | found), flush=True)


def mitsuba_pictures(cases: list[tuple[Case, Path]], folder: Path, wait: list[str]) -> dict[str, dict]:
    """What Mitsuba makes of each scene; a crash is a message, too."""
    waiting, found = [c for c in cases if not c[0].no_mitsuba and not c[0].message], {}
    while waiting:
        listed = folder / "list.json"
        listed.write_text(json.dumps([(c.name, str(xml), max(c.spp // 2, 32), str(xml.with_suffix(".npy"))) for c, xml in waiting]))
        ended = run([sys.executable, __file__, "--worker", str(listed)], 3600, wait)
        lines = [json.loads(line) for line in ended.stdout.splitlines() if line.startswith("{")]
        found |= {line["name"]: line for line in lines}
        waiting = waiting[len(lines) :]
        if waiting and ended.code != 0:
            found[waiting.pop(0)[0].name] = {"message": f"ended with {ended.code}: {ended.stderr[-100:]}", "seconds": 0.0}
    return found


def reference_of(case: Case, rival: dict | None, npy: Path) -> Picture | None:
    if case.radiance is not None:
        level = np.full((SIZE // 8, SIZE // 8), case.radiance)
        return Picture(case.radiance, 0.0, level, 0 * level)
    if rival is None or "mean" not in rival or not math.isfinite(rival["mean"]):
        return None
    mean, variance = np.load(npy)
    return Picture(rival["mean"], rival["variance"], blocks_of(mean), blocks_of(variance) / 64)


def scaled(picture: Picture, factor: float) -> Picture:
    square = factor * factor
    return Picture(picture.mean * factor, picture.variance * square, picture.blocks * factor, picture.block_variance * square)


def compared(found: Picture, reference: Picture, tolerance: float) -> tuple[list[str], str]:
    """Cells with ratio, z and the worst block, and what is wrong."""
    if reference.mean == 0:
        return [f"{found.mean:.3g}", "", ""], "" if found.mean == 0 else "not black"
    ratio = found.mean / reference.mean
    # Products of small numbers would underflow.
    unit = 1 / abs(reference.mean)
    error = math.sqrt(max(found.variance, 0)) * unit, math.sqrt(max(reference.variance, 0)) * unit
    z = (ratio - 1) / max(math.hypot(*error), 1e-9)
    off = np.abs(found.blocks - reference.blocks) * unit
    noise = np.hypot(np.sqrt(np.maximum(found.block_variance, 0)) * unit, np.sqrt(np.maximum(reference.block_variance, 0)) * unit)
    # Blocks that differ by more than noise and by more than the method's bias, which is larger in small parts of a picture.
    allowed = np.maximum(12 * noise, 5 * tolerance * np.maximum(np.abs(reference.blocks) * unit, 0.2))
    # Variances in files are f32: those of tiny values are 0.
    worst = float(np.max(off / np.maximum(allowed, 1e-9))) if abs(reference.mean) > 1e-15 else 0.0
    wrong = "mean" if not (abs(z) < MAX_Z or abs(ratio - 1) < tolerance) else "a part" if not worst < 1 else ""
    if not math.isfinite(ratio):
        wrong = "not finite"
    return [f"{ratio:.4f}", f"{z:+.1f}", f"{worst:.2f}"], wrong


def write_case(case: Case, folder: Path) -> Path:
    place = folder / "".join(c if c.isalnum() or c in "-." else "_" for c in case.name)
    place.mkdir(parents=True, exist_ok=True)
    (place / "scene.xml").write_text(case.xml)
    for name, data in case.files.items():
        (place / name).write_bytes(data)
    return place / "scene.xml"


class Table:
    """Rows to stdout, and the count of those that are wrong."""

    def __init__(self) -> None:
        self.wrong = self.rows = 0
        print("| case | method | reference | ratio | z | worst block | s | MB | verdict |\n|---|---|---|---|---|---|---|---|---|")

    def row(self, case: str, method: str, cells: list[str], ended: Run | None, wrong: str, beyond: str = "") -> None:
        """`beyond` says why differences are expected; crashes and values that are not finite are none."""
        self.rows += 1
        if beyond and wrong in ("mean", "a part"):
            cost = f"{ended.seconds:.1f} | {ended.peak_mb:.0f}" if ended else " | "
            print("| " + " | ".join([case, method, *cells, cost, f"beyond the limit: {beyond}"]) + " |", flush=True)
            return
        self.wrong += bool(wrong)
        cost = [f"{ended.seconds:.1f}", f"{ended.peak_mb:.0f}"] if ended else ["", ""]
        print("| " + " | ".join([case, method, *cells, *cost, f"WRONG: {wrong}" if wrong else "right"]) + " |", flush=True)


def first_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return " ".join(lines)[:150].replace("|", "/") if lines else "no message"


def render(args: argparse.Namespace, case: Case, xml: Path, method: str) -> tuple[Run, Path]:
    options = ["--spp", str(case.spp * 2)] if method == "path" else METHODS[method][0] + ["--passes", str(case.spp // PER_PASS[method])]
    image = xml.with_name(f"{method}.exr")
    words = [str(args.manylight), "render", str(xml), "-m", method, *options, "-q", "--json", "-o", str(image), "-o", str(image.with_suffix(".png"))]
    return run(words, wait=args.wait), image


def check_case(args: argparse.Namespace, table: Table, case: Case, xml: Path, rival: dict | None, known: dict[str, Picture]) -> None:
    """One row per method. `known` has the reference pictures by case."""
    if case.message:
        ended, _ = render(args, case, xml, "path")
        said = case.message.lower() in ended.stderr.lower()
        table.row(case.name, "", [first_line(ended.stderr), "", "", ""], ended, "" if ended.code == 3 and said else f"exit {ended.code}")
        return
    reference, by = reference_of(case, rival, xml.with_suffix(".npy")), "Mitsuba" if case.radiance is None else "known"
    if case.same_as and case.same_as in known:
        same = scaled(known[case.same_as], case.brightness)
        if reference is not None and rival:
            cells, differs = compared(reference, same, METHODS["path"][1])
            print(f"| {case.name} | Mitsuba | {case.same_as} | {' | '.join(cells)} | {rival['seconds']:.1f} | | {'differs: ' + differs if differs else 'right'} |")
        reference, by = same, case.same_as
    elif rival and "message" in rival:
        print(f"| {case.name} | Mitsuba | {rival['message'].replace('|', '/')} | | | | {rival['seconds']:.1f} | | |")
    elif rival and reference is None:
        print(f"| {case.name} | Mitsuba | {rival.get('mean')} | | | | {rival['seconds']:.1f} | | |")
    for method in args.methods:
        if method in case.without:
            continue
        ended, image = render(args, case, xml, method)
        if ended.code != 0:
            table.row(case.name, method, [first_line(ended.stderr), "", "", ""], ended, f"exit {ended.code}")
            continue
        picture, bad = read_exr(image)
        if reference is None:
            reference, by = picture, "path"
            table.row(case.name, method, [f"none; mean {picture.mean:.4g}", "", "", ""], ended, "not finite" if bad else "")
            continue
        cells, wrong = compared(picture, reference, METHODS[method][1])
        table.row(case.name, method, [by, *cells], ended, f"{bad} values not finite" if bad else wrong, case.beyond if method in case.beyond_for else "")
    if reference is not None:
        known[case.name] = reference


def check_fields(args: argparse.Namespace, folder: Path) -> int:
    """Renders every scene with one number replaced. Right is a finite picture or one message with code 3 (6: a limit of memory)."""
    counts: dict[str, list[int]] = {}
    for name, place, text in all_fields():
        if args.only and not any(word in f"{name} {place}" for word in args.only):
            continue
        scene, image = folder / name, folder / "image.exr"
        scene.write_text(text)
        image.unlink(missing_ok=True)
        words = ["render", str(scene), "-m", "path", "--spp", "1", "--memory-limit", "2G", "-q", "-o", str(image)]
        # glTF files have no size.
        words += ["--size", "64x64"] if scene.suffix == ".gltf" else []
        ended = run([str(args.manylight), *words], 30, args.wait)
        wrong = ""
        if ended.code == 0:
            wrong = f"{bad} values not finite" if (bad := not_finite(image)) else ""
        elif ended.code != 3 and "memory" not in ended.stderr or len(ended.stderr) < 20 or "panicked" in ended.stderr:
            wrong = f"exit {ended.code}: {first_line(ended.stderr)}"
        count = counts.setdefault(name, [0, 0, 0])
        count[0 if ended.code == 0 else 1] += 1
        if wrong:
            count[2] += 1
            print(f"wrong: {name} {place}: {wrong}", file=sys.stderr)
    print("| scene | pictures | messages | wrong |\n|---|---|---|---|")
    for name, count in counts.items():
        print(f"| {name} | {' | '.join(map(str, count))} |")
    return sum(count[2] for count in counts.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight", type=Path, nargs="?", help="the program, as `cargo build --release` makes it")
    parser.add_argument("--only", action="append", default=[], help="cases with this text in their name, and those that they are compared with")
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=METHODS)
    parser.add_argument("--fields", action="store_true")
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--keep", type=Path, help="folder for scenes and pictures")
    parser.add_argument("--wait", type=lambda text: text.split(), default=[])
    parser.add_argument("--worker", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.worker:
        return mitsuba_worker(args.worker)
    if args.fields or args.large:
        with tempfile.TemporaryDirectory() as temporary:
            folder = (args.keep or Path(temporary)).resolve()
            folder.mkdir(parents=True, exist_ok=True)
            sys.exit((check_fields if args.fields else check_large)(args, folder) > 0)
    cases = [c for c in all_cases() if not args.only or any(text in c.name for text in args.only)]
    needed = {c.same_as for c in cases}
    cases = [c for c in all_cases() if c in cases or c.name in needed]
    with tempfile.TemporaryDirectory() as temporary:
        folder = (args.keep or Path(temporary)).resolve()
        placed = [(case, write_case(case, folder)) for case in cases]
        rivals: dict[str, dict] = {}
        if importlib.util.find_spec("mitsuba"):
            rivals = mitsuba_pictures(placed, folder, args.wait)
        else:
            print("note: mitsuba is not installed; our path tracer is the reference", file=sys.stderr)
        table, known = Table(), {}
        for case, xml in placed:
            check_case(args, table, case, xml, rivals.get(case.name), known)
    print(f"{table.rows} pictures and messages of {len(cases)} cases, {table.wrong} wrong", file=sys.stderr)
    sys.exit(table.wrong > 0)


if __name__ == "__main__":
    main()
