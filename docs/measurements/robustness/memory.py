"""Compares the estimated memory of renders with their peak.

Usage: python memory.py MANYLIGHT SCENE... [-- OPTIONS OF RENDER]

The estimate is that of the message which refuses a render above `--memory-limit`; the peak is `memory.peak_bytes` of `--json`, which
Linux reports. A table goes to stdout. The exit code is 1 if an estimate is off by more than 10 % of the peak. Needs Python's standard
library.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

#: Units of the message, in bytes.
UNITS = {"kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
#: Largest relative error of an estimate.
TOLERANCE = 0.1
OPTIONS = "-m rich-vpl --passes 2 --size 640x360"


def estimate(command: list[str]) -> dict[str, float]:
    """Bytes of each stage, by its name."""
    refused = subprocess.run([*command, "--memory-limit", "1k"], capture_output=True, text=True)
    listed = re.search(r"\((scene [^)]*)\)", refused.stderr)
    if listed is None:
        sys.exit(f"error: {' '.join(command)}: no estimate in\n{refused.stderr}")
    parts = (re.fullmatch(r"(.*) ([0-9.]+) (\w+)", part) for part in listed[1].split(", "))
    return {part[1]: float(part[2]) * UNITS[part[3]] for part in parts if part is not None}


def peak(command: list[str]) -> float:
    """Bytes of the process at its largest."""
    ended = subprocess.run([*command, "--json", "-q"], capture_output=True, text=True)
    if ended.returncode != 0:
        sys.exit(f"error: {' '.join(command)}:\n{ended.stderr}")
    return float(json.loads(ended.stdout)["memory"]["peak_bytes"])


def main() -> None:
    own, _, options = " ".join(sys.argv[1:]).partition(" -- ")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight", help="the program, as `cargo build --release` makes it")
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    args = parser.parse_args(own.split())
    worst = 0.0
    print("| scene | estimated, MB | peak, MB | estimate / peak | largest stage |\n|---|---|---|---|---|")
    for scene in args.scenes:
        with tempfile.TemporaryDirectory() as folder:
            command = [args.manylight, "render", scene, *(options or OPTIONS).split(), "-o", f"{folder}/image.exr"]
            stages = estimate(command)
            most = peak(command)
        total = sum(stages.values())
        worst = max(worst, abs(total / most - 1))
        largest = max(stages, key=lambda stage: stages[stage])
        name = f"{Path(scene).parent.name}/{Path(scene).name}"
        print(f"| {name} | {total / 1e6:.0f} | {most / 1e6:.0f} | {total / most:.2f} | {largest} {stages[largest] / 1e6:.0f} |", flush=True)
    sys.exit(worst > TOLERANCE)


if __name__ == "__main__":
    main()
