"""Decodes the Cryptomattes of an EXR file by the specification, and compares them with ids that Mitsuba 3 finds.

Usage: python cryptomatte.py FILE.exr [SCENE.xml]

Needs the Python packages OpenEXR, numpy and mmh3, and mitsuba with SCENE.xml. The file must have been rendered with `--filter box`
and without a crop to be compared: Mitsuba traces 64 stratified camera rays per pixel and looks up the id of the shape that each meets.
"""

import json
import sys

import mmh3
import numpy as np
import OpenEXR


def id_bits(name):
    """The bits of the id of a name, by the specification."""
    bits = mmh3.hash(name.encode(), signed=False)
    exponent = bits >> 23 & 255
    return bits ^ 1 << 23 if exponent in (0, 255) else bits


def read(path):
    """All mattes: {name of the layer: {name of the object: coverage}}."""
    part = OpenEXR.File(path, separate_channels=True).parts[0]
    channels = {name: np.asarray(channel.pixels) for name, channel in part.channels.items()}
    mattes = {}
    for attribute, layer in part.header.items():
        if not (attribute.startswith("cryptomatte/") and attribute.endswith("/name")):
            continue
        key = attribute.split("/")[1]
        text = lambda what: part.header[f"cryptomatte/{key}/{what}"]
        assert key == f"{mmh3.hash(layer.encode(), signed=False):08x}"[:7], "the key is a hash of the layer's name"
        assert (text("hash"), text("conversion")) == ("MurmurHash3_32", "uint32_to_float32")
        manifest = json.loads(text("manifest"))
        ids, coverages = [], []
        for level in range(3):
            channel = lambda c: channels[f"{layer}{level:02}.{c}"]
            ids += [channel("r").view(np.uint32), channel("b").view(np.uint32)]
            coverages += [channel("g"), channel("a")]
        ids, coverages = np.array(ids), np.array(coverages)
        total = coverages.astype(np.float64).sum(axis=0)
        assert coverages.min() >= 0 and total.max() <= 1, "coverages are fractions of a whole"
        assert (np.diff(coverages, axis=0) <= 0).all(), "ranks are sorted by coverage"
        assert set(np.unique(ids[coverages > 0])) <= {int(h, 16) for h in manifest.values()}, "all ids have names"
        mattes[layer] = {}
        for name, digits in manifest.items():
            assert int(digits, 16) == id_bits(name), f"{name} has the hash of its name"
            mattes[layer][name] = np.where(ids == int(digits, 16), coverages, 0).sum(axis=0)
        print(f"{layer}: {len(manifest)} names, coverage at most {total.max():.7f}, {np.mean(total > 0.999):.1%} of the pixels covered")
    return mattes


def mitsuba_coverage(scene_file, width, height, side=8):
    """Coverage by the id of the first shape along stratified camera rays: {id: array}."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(scene_file, optimize=False)
    registry = np.array(dr.reinterpret_array(mi.UInt32, scene.shapes_dr()))
    names = dict(zip(registry.tolist(), (shape.id() for shape in scene.shapes())))
    rng = np.random.default_rng(1)
    coverage = {}
    y, x = np.divmod(np.arange(width * height), width)
    for k in range(side * side):
        jitter = (np.array([k % side, k // side])[:, None] + rng.random((2, width * height))) / side
        at = mi.Point2f(((x + jitter[0]) / width).astype(np.float32), ((y + jitter[1]) / height).astype(np.float32))
        ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, at, mi.Point2f(0.5))
        found = scene.ray_intersect_preliminary(ray, False)
        hit = np.array(found.is_valid())
        shape = np.array(dr.reinterpret_array(mi.UInt32, found.shape))
        for i in np.unique(shape[hit]):
            image = coverage.setdefault(names[int(i)], np.zeros(width * height))
            image += (hit & (shape == i)) / (side * side)
    return {name: image.reshape(height, width) for name, image in coverage.items()}


def compare(mattes, expected):
    """Differences of coverage by name, and of the object that covers most of each pixel."""
    names = sorted(expected)
    missing = [name for name in names if name not in mattes]
    assert not missing, f"no mattes of {missing}"
    found = np.array([mattes[name] for name in names])
    wanted = np.array([expected[name] for name in names])
    clear = wanted.max(axis=0) > 0.75
    same = found.argmax(axis=0) == wanted.argmax(axis=0)
    print(f"{len(names)} objects: mean difference of coverage {np.abs(found - wanted).sum(axis=0).mean() / 2:.5f} of a pixel,"
          f" sums differ by at most {np.abs(found.sum(axis=(1, 2)) - wanted.sum(axis=(1, 2))).max():.2f} pixels")
    print(f"the largest object is the same in {same.mean():.3%} of the pixels,"
          f" in {same[clear].mean():.3%} of those with more than 75 % of one object ({clear.mean():.1%})")


def main(path, scene_file=None):
    mattes = read(path)
    if scene_file:
        objects = next(matte for layer, matte in mattes.items() if layer.endswith("CryptoObject"))
        height, width = next(iter(objects.values())).shape
        compare(objects, mitsuba_coverage(scene_file, width, height))


main(*sys.argv[1:])
