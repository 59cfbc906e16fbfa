"""Compares the alpha of an EXR file with that of Mitsuba 3's path tracer.

Usage: python alpha.py FILE.exr SCENE.xml [--hide-emitters]

Needs the Python packages OpenEXR, numpy and mitsuba. The file must have been rendered with `--filter box` and without a crop, and with
`--hide-emitters` if it is given here; the camera must be a `perspective`.
"""

import sys

import mitsuba as mi
import numpy as np
import OpenEXR

SAMPLES = 256


def main(path, scene_file, *options):
    part = OpenEXR.File(path, separate_channels=True).parts[0]
    alpha = np.asarray(part.channels["A"].pixels)
    height, width = alpha.shape
    mi.set_variant("scalar_rgb")
    scene = mi.load_file(scene_file)
    parameters = mi.traverse(scene.sensors()[0])
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgba", "rfilter": {"type": "box"}}
    sensor = mi.load_dict({
        "type": "perspective",
        "fov": float(np.ravel(parameters["x_fov"])[0]),
        "fov_axis": "x",
        "to_world": parameters["to_world"],
        "film": film,
        "sampler": {"type": "independent", "sample_count": SAMPLES},
    })
    integrator = mi.load_dict({"type": "path", "max_depth": -1, "hide_emitters": "--hide-emitters" in options})
    expected = np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=SAMPLES))[..., 3]
    print(f"alpha: mean {alpha.mean():.4f}, Mitsuba's {expected.mean():.4f},"
          f" mean difference of pixels {np.abs(alpha - expected).mean():.4f}")


main(*sys.argv[1:])
