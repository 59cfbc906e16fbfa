"""Counts the instructions of fixed workloads with callgrind, and compares them with the numbers of the project.

Usage: python instructions.py MANYLIGHT [--only NAME]... [--write]

Instructions hardly depend on what else the machine does: a change of a percent is a change of the program. The AVX2 code and the
portable code are counted; Valgrind does not know AVX-512. `--write` replaces the numbers in instructions.json. Needs valgrind, and
Python's standard library.
"""

import argparse
import itertools
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
NUMBERS = Path(__file__).with_suffix(".json")
#: Smaller changes are those of other allocations and hash seeds.
NOTICEABLE = 0.005
#: Values of MANYLIGHT_SIMD.
SETS = ["avx2", "portable"]
#: Valgrind runs one thread at a time; a machine with more processors counts several workloads at once.
AT_ONCE = 2

LIGHTS = "-n 256 --photons 20000"
#: Arguments of `manylight`, each of about a second without Valgrind.
WORKLOADS = {
    "load": "info scenes/garage/scene.xml --json",
    "path": "render scenes/glossy-room/scene.xml -m path --size 96x54 --passes 8",
    "path, many emitters": "render scenes/garage/scene.xml -m path --size 64x36 --passes 8",
    "rich-vpl": f"render scenes/glossy-cornell/scene.xml -m rich-vpl {LIGHTS} --size 48x48 --passes 2",
    "rich-lightcuts": f"render scenes/kitchen/scene.xml -m rich-lightcuts {LIGHTS} --size 32x18 --passes 1",
    "photon-map": "render scenes/glossy-cornell/scene.xml -m photon-map --photons 50000 --size 48x48 --passes 2",
}


def count(binary: str, instruction_set: str, arguments: str) -> int:
    """Instructions of a run with one thread."""
    environment = os.environ | {"MANYLIGHT_SIMD": instruction_set}
    with tempfile.TemporaryDirectory() as folder:
        words = shlex.split(arguments)
        if words[0] == "render":
            words += ["--threads", "1", "-q", "-o", f"{folder}/image.exr"]
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        ended = subprocess.run([*valgrind, binary, *words], cwd=ROOT, env=environment, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", ended.stderr)
    if ended.returncode != 0 or found is None:
        sys.exit(f"error: manylight {arguments} ended with {ended.returncode}:\n{ended.stderr[-2000:]}")
    return int(found[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight", help="the program, as `cargo build --release` makes it")
    parser.add_argument("--only", action="append", choices=WORKLOADS, help="a workload; may be repeated")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    binary = str(Path(args.manylight).resolve())
    runs = list(itertools.product(SETS, args.only or WORKLOADS))
    known = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else {}
    print("| workload | instruction set | instructions in millions | before | change |\n|---|---|---|---|---|")
    with ThreadPoolExecutor(AT_ONCE) as pool:
        counts = pool.map(lambda run: count(binary, run[0], WORKLOADS[run[1]]), runs)
        for (instruction_set, name), found in zip(runs, counts, strict=True):
            of_set = known.setdefault(instruction_set, {})
            before = of_set.get(name)
            change = "new" if before is None else f"{found / before - 1:+.1%}" if abs(found / before - 1) > NOTICEABLE else "none"
            millions = "" if before is None else f"{before / 1e6:.0f}"
            print(f"| {name} | {instruction_set} | {found / 1e6:.0f} | {millions} | {change} |", flush=True)
            of_set[name] = found
    if args.write:
        NUMBERS.write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    main()
