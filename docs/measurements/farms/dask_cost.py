"""Measures a render on local Dask workers beside the command: seconds, and whether the bits agree.

Usage: python dask_cost.py SCENE [--repeats N]

Needs the Python package manylight with distributed. Measure on a machine that does nothing else.
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import distributed
import manylight as ml
import numpy as np
from manylight.distributed import render
from program import Table

SIZE, PASSES, BLOCK = (256, 256), 96, 8
#: Workers, and threads of each.
CLUSTERS = ((1, 2), (2, 1))


def cpu_seconds(who: int) -> float:
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def command(scene: str, output: str) -> tuple[float, float, float]:
    """Seconds, and CPU seconds of rendering and of everything else, by the command with two threads."""
    words = ["render", scene, "-m", "path", "--size", "x".join(map(str, SIZE)), "--passes", str(PASSES), "--block", str(BLOCK)]
    start, cpu = time.perf_counter(), cpu_seconds(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "manylight", *words, "-t", "2", "-q", "-o", output], check=True)
    return time.perf_counter() - start, cpu_seconds(resource.RUSAGE_CHILDREN) - cpu, 0.0


def cluster(scene: ml.Scene, workers: int, threads: int, expected: ml.Image) -> tuple[float, float, float]:
    """The same by a local cluster."""
    made = distributed.LocalCluster(n_workers=workers, threads_per_worker=threads, dashboard_address=":0", silence_logs=50)
    with made as local, distributed.Client(local) as client:
        before = sum(client.run(time.process_time).values())
        start, cpu = time.perf_counter(), time.process_time()
        image = render(scene, client=client, method="path", size=SIZE, passes=PASSES, block=BLOCK, progress=False)
        seconds, others = time.perf_counter() - start, time.process_time() - cpu
        rendering = sum(client.run(time.process_time).values()) - before
    if not np.array_equal(image, expected):
        sys.exit(f"error: {workers} workers give other bits than one run")
    return seconds, rendering, others


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="such as scenes/glossy-cornell/scene.xml")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    scene = ml.load_file(args.scene)
    expected = ml.render(scene, "path", size=SIZE, passes=PASSES, block=BLOCK)
    runs: dict[str, list[tuple[float, float, float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(args.repeats):
            runs.setdefault("`manylight render -t 2`", []).append(command(args.scene, f"{folder}/image.exr"))
            for workers, threads in CLUSTERS:
                name = f"workers: {workers}, threads of each: {threads}"
                runs.setdefault(name, []).append(cluster(scene, workers, threads, expected))
    table = Table(f"path, {SIZE[0]}x{SIZE[1]}, {PASSES} passes", "s", "CPU s of rendering", "CPU s of caller and scheduler")
    for name, rows in runs.items():
        table.row(name, *(f"{statistics.median(column):.1f}" for column in zip(*rows, strict=True)))


if __name__ == "__main__":
    main()
