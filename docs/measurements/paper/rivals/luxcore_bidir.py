#!/usr/bin/env python3
"""Bidirectional path tracing by LuxCore, called as `manylight render` is, for plans of `manylight study`.

    python3 luxcore_bidir.py SCENE.xml --time 30s --size 240x240 --max-depth 12 [--engine BIDIRVMCPU] --json --output OUT.exr

The engine is BIDIRCPU, or with --engine BIDIRVMCPU the same with vertex merging. Meshes, cameras, area lights, diffuse
materials and conductors (Schlick's distribution with the square of alpha is GGX) mean the same; a rough plastic
is LuxCore's glossy2, which is another model. Spot lights are not translated. Needs `pip install pyluxcore OpenEXR`.
"""
import functools
import importlib.util
import math
import os
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import microfacets
import program
import scene_xml

#: Seconds between two looks at the clock.
POLL = 0.05


def main():
    parser = program.parser(__doc__)
    parser.add_argument("--engine", choices=["BIDIRCPU", "BIDIRVMCPU", "PATHCPU"], default="BIDIRCPU")
    words = parser.parse_args()
    preload_allocator()
    source = read(words)
    with program.output_to_stderr():
        import pyluxcore

        pyluxcore.Init()
        scene = build(pyluxcore, source, words.size)
        image, seconds, samples = render(pyluxcore, scene, words)
    for path in words.output:
        program.write(path, image)
    if words.json:
        settings = {"engine": words.engine, "max_depth": words.max_depth}
        program.report(f"LuxCore {pyluxcore.Version()}", settings, {"path": seconds}, {"passes": samples})


def preload_allocator():
    """Starts Python again with LuxCore's allocator, which cannot replace that of a running process: it aborts."""
    found = importlib.util.find_spec("pyluxcore")
    if found is None:
        program.unavailable("LuxCore is not installed: pip install pyluxcore")
    libraries = Path(found.origin).parent.parent / "pyluxcore.libs"
    allocator = next(iter(libraries.glob("libtbbmalloc_proxy*.so*")), None)
    if allocator is None or str(allocator) in os.environ.get("LD_PRELOAD", ""):
        return
    environment = {**os.environ, "LD_PRELOAD": str(allocator)}
    os.execve(sys.executable, [sys.executable, *sys.argv], environment)


def read(words):
    """The scene to translate. Refused before LuxCore writes its first line, so that the reason is the first."""
    try:
        source = scene_xml.read_scene(words.scene, words.size)
    except scene_xml.Unsupported as reason:
        program.unavailable(f"not translated: {reason}")
    if source.spots:
        program.unavailable("not translated: spot lights, which have another falloff")
    return source


def build(pyluxcore, source, size):
    """The scene of LuxCore."""
    scene = pyluxcore.Scene()
    scene.Parse(properties(pyluxcore, camera(source.camera, size)))
    materials = {}
    for index, shape in enumerate(source.shapes):
        key = (shape.material, shape.radiance)
        if key not in materials:
            materials[key] = f"material{len(materials)}"
            found = material(materials[key], source.materials[shape.material], shape.radiance)
            scene.Parse(properties(pyluxcore, found))
        define_mesh(scene, f"mesh{index}", shape)
        found = {f"scene.objects.object{index}.shape": f"mesh{index}",
                 f"scene.objects.object{index}.material": materials[key]}
        scene.Parse(properties(pyluxcore, found))
    return scene


def properties(pyluxcore, values):
    """Properties from a dictionary of values and lists of values."""
    found = pyluxcore.Properties()
    for name, value in values.items():
        found.Set(pyluxcore.Property(name, list(value) if isinstance(value, (tuple, list, np.ndarray)) else value))
    return found


def define_mesh(scene, name, shape):
    tuples = lambda values: None if values is None else [tuple(map(float, row)) for row in values]
    triangles = [tuple(map(int, row)) for row in shape.triangles]
    uvs = None if shape.uvs is None else shape.uvs * [1, -1] + [0, 1]
    scene.DefineMesh(name, tuples(shape.vertices), triangles, tuples(shape.normals), tuples(uvs), None, None)


def camera(source, size):
    """LuxCore's field of view belongs to the longer edge of the image, from -1 to 1 in its screen window."""
    width, height = size
    x, y = width / max(size), height / max(size)
    # Its images are one row too low.
    row = 2 * y / height
    own, longer = (width if source.is_horizontal else height), max(width, height)
    fov = 2 * math.degrees(math.atan(math.tan(source.fov / 2) * longer / own))
    return {
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": [float(x) for x in source.position],
        "scene.camera.lookat.target": [float(x) for x in source.position + source.direction],
        "scene.camera.up": [float(x) for x in source.up],
        "scene.camera.fieldofview": fov,
        "scene.camera.screenwindow": [-x, x, -y - row, y - row],
        "scene.camera.lensradius": 0.0,
        "scene.camera.autofocus.enable": False,
        "scene.camera.cliphither": 1e-3,
    }


# Materials


def material(name, source, radiance):
    """Properties of a material. Emitters reflect nothing, as in the scenes."""
    if radiance is not None:
        start = f"scene.materials.{name}"
        emission = {f"{start}.emission": radiance, f"{start}.emission.theta": 90.0}
        return {f"{start}.type": "matte", f"{start}.kd": (0.0, 0.0, 0.0), **emission}
    make = {"diffuse": diffuse, "roughplastic": plastic, "roughconductor": conductor, "dielectric": glass, "blendbsdf": blend}
    return make[source.kind](name, source)


def color(name, value):
    """The value of a property, and the properties of the texture it may need."""
    if not isinstance(value, scene_xml.Texture):
        return [float(x) for x in value], {}
    start = f"scene.textures.{name}"
    texture = {f"{start}.type": "imagemap", f"{start}.file": str(value.path), f"{start}.gamma": 1.0 if value.raw else 2.2}
    return name, texture


def diffuse(name, source):
    value, texture = color(f"{name}_kd", source.color)
    return {**texture, f"scene.materials.{name}.type": "matte", f"scene.materials.{name}.kd": value}


def plastic(name, source):
    """A layer over a diffuse base that is as bright as Mitsuba's seen from the normal, about."""
    start = f"scene.materials.{name}"
    value, texture = color(f"{name}_kd", source.color)
    share, normal = base(source.alpha, source.ior), ((source.ior - 1) / (source.ior + 1)) ** 2
    scale = f"scene.textures.{name}_base"
    scaled = {f"{scale}.type": "scale", f"{scale}.texture1": value, f"{scale}.texture2": share}
    rough = {f"{start}.uroughness": source.alpha, f"{start}.vroughness": source.alpha}
    return {**texture, **scaled, f"{start}.type": "glossy2", f"{start}.kd": f"{name}_base", f"{start}.ks": [normal] * 3, **rough}


base = functools.cache(microfacets.plastic_base)


def conductor(name, source):
    """The tint multiplies by way of k, as in `cycles_path.conductor`, but with the whole tint."""
    start, fresnel = f"scene.materials.{name}", f"scene.textures.{name}_fresnel"
    eta, k = scene_xml.tinted(source.eta, source.k, source.tint)
    constants = {f"{fresnel}.type": "fresnelconst", f"{fresnel}.n": eta.tolist(), f"{fresnel}.k": k.tolist()}
    rough = {f"{start}.uroughness": source.alpha, f"{start}.vroughness": source.alpha}
    return {**constants, f"{start}.type": "metal2", f"{start}.fresnel": f"{name}_fresnel", **rough}


def glass(name, source):
    start = f"scene.materials.{name}"
    white = [1.0, 1.0, 1.0]
    return {f"{start}.type": "glass", f"{start}.kr": white, f"{start}.kt": white, f"{start}.interiorior": source.ior}


def blend(name, source):
    start = f"scene.materials.{name}"
    parts = [material(f"{name}_{i}", part, None) for i, part in enumerate(source.parts)]
    value, texture = color(f"{name}_amount", source.weight)
    amount = {f"{start}.amount": value if texture else value[0]}
    pair = {f"{start}.material1": f"{name}_0", f"{start}.material2": f"{name}_1"}
    return {**parts[0], **parts[1], **texture, f"{start}.type": "mix", **amount, **pair}


# Rendering


def render(pyluxcore, scene, words):
    """The image, the seconds from the start of the session to its end, and the samples per pixel."""
    width, height = words.size
    depth = 1024 if words.max_depth < 0 else words.max_depth
    config = {
        "renderengine.type": words.engine,
        "renderengine.seed": words.seed + 1,
        "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0,
        "film.width": width,
        "film.height": height,
        "film.filter.type": "NONE",
        "film.imagepipelines.0.0.type": "NOP",
        "path.maxdepth": depth,
        "path.pathdepth.total": depth,
        "path.pathdepth.diffuse": depth,
        "path.pathdepth.glossy": depth,
        "path.pathdepth.specular": depth,
        "light.maxdepth": depth,
        "path.clamping.variance.maxvalue": 0.0,
    }
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties(pyluxcore, config), scene))
    start = time.monotonic()
    session.Start()
    samples = 0.0
    while True:
        time.sleep(POLL)
        session.UpdateStats()
        samples = session.GetStats().Get("stats.renderengine.pass").GetFloat()
        if (words.time is not None and time.monotonic() - start >= words.time) or (words.spp and samples >= words.spp):
            break
    session.Stop()
    seconds = time.monotonic() - start
    values = np.zeros(width * height * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    return values.reshape(height, width, 3)[::-1].astype(float), seconds, int(samples)


if __name__ == "__main__":
    main()
