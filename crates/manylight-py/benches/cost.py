"""Seconds and peak memory of a render by the package, beside the command of the package.

    python crates/manylight-py/benches/cost.py SCENE [--passes N] [--size WxH] [--runs N] [--method NAME]

Both are new processes, in turns. The package also takes the arrays of all layers and writes the EXR file, as the command does.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

BY_PACKAGE = """
import sys
import numpy as np
import manylight as ml
scene, method, passes, width, height, output = sys.argv[1:]
image = ml.render(scene, method, passes=int(passes), size=(int(width), int(height)))
picture, layers = np.asarray(image), image.layers
image.save(output)
"""


def run(command: list[str]) -> tuple[float, float]:
    """Seconds and peak memory in MB of a process."""
    start = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(command)}")
    return time.perf_counter() - start, usage.ru_maxrss / 1000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--method", default="rich-vpl")
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    width, height = args.size.split("x")
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "image.exr")
        by_package = [sys.executable, "-c", BY_PACKAGE, args.scene, args.method, str(args.passes), width, height, output]
        by_command = [sys.executable, "-m", "manylight", "render", args.scene, "-m", args.method, "--passes", str(args.passes)]
        by_command += ["--size", args.size, "-q", "-o", output]
        empty = [sys.executable, "-c", "import manylight"]
        results: dict[str, list[tuple[float, float]]] = {"command": [], "package": [], "import alone": []}
        for _ in range(args.runs):
            for name, command in (("command", by_command), ("package", by_package), ("import alone", empty)):
                results[name].append(run(command))
    medians = {name: [statistics.median(column) for column in zip(*rows)] for name, rows in results.items()}
    for name, (seconds, memory) in medians.items():
        print(f"{name:13} {seconds:8.2f} s {memory:8.0f} MB")
    time_ratio, memory_ratio = (package / command for package, command in zip(medians["package"], medians["command"]))
    print(f"package / command: time {time_ratio:.3f}, memory {memory_ratio:.3f}")
    print(json.dumps(results))


if __name__ == "__main__":
    main()
