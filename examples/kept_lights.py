"""The virtual lights of a room in 3D over its surfaces, and the light of the brightest glossy one.

python examples/kept_lights.py [SCENE] [OUT.png]
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import manylight as ml

BACKGROUND = "0.2"
SCENES = Path(__file__).resolve().parent.parent / "scenes"


def keep(scene: str, file: Path) -> list[ml.Lights]:
    """The lights of 8 passes."""
    words = ["render", scene, "--passes", "8", "--lights", "256", "--size", "96x54", "--quiet"]
    outputs = ["--lights-out", str(file), "--output", str(file.with_suffix(".png"))]
    subprocess.run([sys.executable, "-m", "manylight", *words, *outputs], check=True)
    return ml.read_lights(file)


def draw_in_space(axes: plt.Axes, scene: ml.Scene, lights: ml.Lights) -> None:
    """The surfaces that the camera sees, and the lights: their area grows with flux."""
    seen = ml.render(scene, "aov", aov="position", passes=1, size=(192, 108)).layers
    points, albedo = seen["position"].reshape(-1, 3), np.clip(seen["albedo"].reshape(-1, 3), 0, 1)
    axes.scatter(*points.T[[2, 0, 1]], c=albedo, s=1, depthshade=False)
    power = lights.flux.sum(axis=1)
    colors = lights.flux / np.maximum(lights.flux.max(axis=1, keepdims=True), 1e-30)
    axes.scatter(*lights.positions.T[[2, 0, 1]], c=colors, s=3 + 80 * power / power.max(), linewidths=0)
    extent = np.ptp(np.concatenate([points, lights.positions]), axis=0)
    axes.set_box_aspect(extent[[2, 0, 1]], zoom=1.2)
    axes.view_init(elev=25, azim=-60)
    axes.set_title(f"{len(lights)} lights, {power.sum() / 3:.3g} W", color="white")
    axes.set_facecolor(BACKGROUND)
    axes.set_axis_off()


def draw_table(axes: plt.Axes, lights: ml.Lights) -> None:
    """The radiant intensity of the light with the brightest glossy part, on the octahedral map."""
    light = int(np.argmax(np.where(lights.table_indices >= 0, lights.flux.sum(axis=1), 0)))
    table = lights.tables(lights.table_indices[light])[0]
    towards = ml.octahedral_directions(table.shape[0]) @ lights.normals[light]
    axes.imshow(np.clip(table / table.max(), 0, 1) ** (1 / 2.2), interpolation="nearest")
    axes.contour(towards, levels=[0.0], colors="white", linewidths=0.7)
    axes.set_title(f"light {light}: up to {table.max():.3g} W/sr", color="white")
    axes.set_axis_off()


def main() -> None:
    file = sys.argv[1] if len(sys.argv) > 1 else str(SCENES / "glossy-room" / "scene.xml")
    with tempfile.TemporaryDirectory() as folder:
        lights = keep(file, Path(folder) / "room.lights")[0]
    figure = plt.figure(figsize=(12, 6), layout="constrained", facecolor=BACKGROUND)
    draw_in_space(figure.add_subplot(1, 2, 1, projection="3d"), ml.load_file(file), lights)
    draw_table(figure.add_subplot(1, 2, 2), lights)
    figure.savefig(sys.argv[2] if len(sys.argv) > 2 else "kept_lights.png", dpi=120)


if __name__ == "__main__":
    main()
