"""Watches the memory, open files and threads of a long run.

Usage: python soak.py render MANYLIGHT SCENE [--minutes M] [-- OPTIONS OF RENDER]
       python soak.py library SCENE... [--minutes M]

`render` watches one render without end, with a checkpoint every half minute. A client opens the page of its preview, reads pictures, and leaves
without a word, again and again. `library` loads and renders scenes by the Python package in one process, by one method after the other, whole and
in parts.

A table goes to stdout: the largest values in each sixth of the time. The exit code is 1 if the second half of the time needs 2 % more
memory than the first, or 4 more files or threads. Needs Linux; `library` needs the package `manylight`.
"""

import argparse
import ctypes
import itertools
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROWS = 6
#: Largest relative growth of the memory.
MORE_MEMORY = 0.02
#: Largest growth of the numbers of open files and threads.
MORE_ITEMS = 4
METHODS = ["path", "light-trace", "photon-map", "vpl", "rich-vpl", "rich-lightcuts"]
OPTIONS = "-m rich-vpl --size 192x108"


@dataclass(frozen=True)
class Sample:
    """State of a process."""

    #: Fraction of the time that has passed, in [0, 1).
    when: float
    resident_mb: float
    files: int
    threads: int
    #: Processor time so far.
    cpu_seconds: float


def sample(process: int | str, when: float) -> Sample:
    folder = Path("/proc") / str(process)
    resident = re.search(r"VmRSS:\s*(\d+) kB", (folder / "status").read_text())
    fields = (folder / "stat").read_text().rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    return Sample(
        when=when,
        resident_mb=int(resident[1]) * 1024 / 1e6 if resident else 0.0,
        files=len(list((folder / "fd").iterdir())),
        threads=len(list((folder / "task").iterdir())),
        cpu_seconds=ticks / os.sysconf("SC_CLK_TCK"),
    )


def largest(samples: list[Sample]) -> tuple[float, int, int]:
    """The largest memory in MB, number of open files, and number of threads."""
    return max(s.resident_mb for s in samples), max(s.files for s in samples), max(s.threads for s in samples)


def report(samples: list[Sample], minutes: float) -> bool:
    """Prints the table; true if nothing has grown."""
    print("| minutes | largest memory, MB | open files | threads | processor, min |\n|---|---|---|---|---|")
    for row in range(ROWS):
        inside = [s for s in samples if row <= s.when * ROWS < row + 1]
        if inside:
            memory, files, threads = largest(inside)
            span = f"{row * minutes / ROWS:.0f} to {(row + 1) * minutes / ROWS:.0f}"
            print(f"| {span} | {memory:.1f} | {files} | {threads} | {inside[-1].cpu_seconds / 60:.1f} |", flush=True)
    first, second = ([s for s in samples if (s.when >= 0.5) == late] for late in (False, True))
    if not first or not second:
        return False
    before, after = largest(first), largest(second)
    return after[0] <= (1 + MORE_MEMORY) * before[0] and all(after[i] <= before[i] + MORE_ITEMS for i in (1, 2))


def time_passed(minutes: float) -> Iterator[float]:
    """Fractions of the time that has passed, until it is over."""
    start = time.monotonic()
    while (when := (time.monotonic() - start) / (60 * minutes)) < 1:
        yield when


def look(address: str, visits: list[int]) -> None:
    """Opens the page, reads pictures for a second, and leaves, until the server is gone; counts the visits in `visits[0]`."""
    for layer in itertools.cycle(["color", "albedo", "normal", "no-such-layer"]):
        try:
            urllib.request.urlopen(address, timeout=30).read()
            with urllib.request.urlopen(f"{address}events/{layer}", timeout=30) as events:
                end = time.monotonic() + 1
                while time.monotonic() < end and events.readline():
                    pass
        except urllib.error.HTTPError:
            pass
        except OSError:
            return
        visits[0] += 1


def soak_render(manylight: str, scene: str, options: list[str], minutes: float) -> list[Sample]:
    with tempfile.TemporaryDirectory() as folder:
        command = [manylight, "render", scene, *options, "-q", "--passes", "100000000", "--preview", "browser"]
        command += ["--checkpoint", f"{folder}/state.part", "--checkpoint-every", "30s", "-o", f"{folder}/image.exr"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            address = re.search(r"http://\S+", process.stderr.readline())
            if address is None:
                sys.exit("error: no address of the preview")
            visits = [0]
            threading.Thread(target=look, args=(address[0], visits), daemon=True).start()
            samples = []
            for when in time_passed(minutes):
                samples.append(sample(process.pid, when))
                time.sleep(0.25)
                if process.poll() is not None:
                    sys.exit(f"error: the program ended by itself, exit code {process.returncode}")
            process.terminate()
        print(f"{visits[0]} visits of the page", file=sys.stderr)
    return samples


def soak_library(scenes: list[str], minutes: float) -> list[Sample]:
    import manylight

    # The allocator keeps free memory, by an amount that depends on the order in which threads release it.
    give_back = getattr(ctypes.CDLL(None), "malloc_trim", lambda _: None)
    samples, renders = [], 0
    small = {"size": (32, 18), "passes": 1, "threads": 2}
    with tempfile.TemporaryDirectory() as folder:
        for when, (scene_file, method) in zip(time_passed(minutes), itertools.cycle(itertools.product(scenes, METHODS)), strict=False):
            scene = manylight.load_file(scene_file)
            manylight.render(scene, method, **small)
            part = f"{folder}/{method}.part"
            manylight.render_part(scene, part, shard=(1, 1), method=method, **small)
            manylight.merge([part])
            for _ in scene.passes(method, **small):
                break
            renders += 3
            del scene
            give_back(0)
            samples.append(sample("self", when))
    print(f"{renders} renders", file=sys.stderr)
    return samples


def main() -> None:
    own, _, options = " ".join(sys.argv[1:]).partition(" -- ")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["render", "library"])
    parser.add_argument("files", nargs="+", metavar="FILE", help="the program and a scene, or scenes")
    parser.add_argument("--minutes", type=float, default=60)
    args = parser.parse_args(own.split())
    if args.what == "render":
        if len(args.files) != 2:
            parser.error("`render` needs the program and one scene")
        samples = soak_render(*args.files, (options or OPTIONS).split(), args.minutes)
    else:
        samples = soak_library(args.files, args.minutes)
    sys.exit(not report(samples, args.minutes))


if __name__ == "__main__":
    main()
