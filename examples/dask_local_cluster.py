"""A render on two worker processes of this machine, with the bits of one run.

python examples/dask_local_cluster.py [SCENE]
"""

import os
import sys
import time
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster

import manylight as ml
from manylight.distributed import Report, render

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def say(report: Report) -> None:
    print(f"{report.passes} passes in {len(report.shares)} shares: {report.seconds:.1f} s")


def main() -> None:
    scene = ml.load_file(sys.argv[1] if len(sys.argv) > 1 else str(SCENES / "glossy-cornell" / "scene.xml"))
    settings = {"passes": 32, "block": 8, "size": (128, 128), "lights": 512, "photons": 50_000}
    threads = max(1, (os.cpu_count() or 2) // 2)
    # A worker is a process. All its threads render one share.
    with LocalCluster(n_workers=2, threads_per_worker=threads) as cluster, Client(cluster) as client:
        print(f"dashboard: {client.dashboard_link}")
        image = render(scene, client=client, report=say, **settings)

    start = time.monotonic()
    alone = ml.render(scene, **settings)
    print(f"in this process: {time.monotonic() - start:.1f} s, the same bits: {np.array_equal(image, alone)}")
    image.save("dask_local_cluster.exr")
    image.save("dask_local_cluster.png")


# Workers import this file anew.
if __name__ == "__main__":
    main()
