"""The largest scenes of scene_faults.py: many triangles, emitters, materials, textures, instances. Times and memory beside Mitsuba's."""

import base64
import json
import re
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from hard_scenes import Space, bsdf, diffuse, emitter, number, rgb, scene, steps, two_sided

HERE = Space()
VIEW = HERE.camera((0, 1.2, 2.2), (0, 0, 0), 50)
SKY = f'<emitter type="constant">{rgb("radiance", 0.5)}</emitter>'
FLOOR = HERE.shape("rectangle", steps(scale="3, 3, 1", turn="x -90", move="0, -0.2, 0"), diffuse())
#: Seconds after which a renderer is ended.
LIMIT = 280


def terrain(path: Path, triangles: int) -> None:
    """A wavy square of about this many triangles, as PLY."""
    n = round((triangles / 2) ** 0.5)
    x, z = np.meshgrid(np.linspace(-1, 1, n + 1, dtype="f4"), np.linspace(-1, 1, n + 1, dtype="f4"))
    y = 0.1 * np.sin(9 * x) * np.cos(7 * z) + 0.002 * np.sin(400 * x) * np.sin(300 * z)
    points = np.stack([x, y.astype("f4"), z], -1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel().astype("i4")
    faces = np.concatenate([np.stack([corner, corner + n + 1, corner + 1], 1), np.stack([corner + 1, corner + n + 1, corner + n + 2], 1)])
    table = np.zeros(len(faces), dtype=[("n", "u1"), ("i", "<i4", 3)])
    table["n"], table["i"] = 3, faces
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes() + table.tobytes())


def png(color: tuple[int, int, int]) -> bytes:
    """A PNG of 8 x 8 pixels."""
    rows = b"".join(b"\0" + bytes([*color, 255 - color[0], 128, color[2]] * 4) for _ in range(8))
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))  # noqa: E731
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 8, 8, 8, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def tiles(count: int, content: Callable[[int], str]) -> str:
    """Small squares on a grid, each with its own content."""
    edge = int(count**0.5) + 1
    place = lambda i: (2 * (i % edge) / edge - 1, 2 * (i // edge) / edge - 1)  # noqa: E731
    size = 0.8 / edge
    turned = lambda i: f'<scale x="{size:.5g}" y="{size:.5g}"/><rotate x="1" angle="-90"/><translate x="{place(i)[0]:.5g}" z="{place(i)[1]:.5g}"/>'  # noqa: E731
    shape = lambda i: f'<shape type="rectangle"><transform name="to_world">{turned(i)}</transform>{content(i)}</shape>'  # noqa: E731
    return "\n".join(map(shape, range(count)))


def triangles(folder: Path, count: int) -> str:
    terrain(folder / "ground.ply", count)
    return scene(VIEW, SKY, HERE.shape("ply", "", '<string name="filename" value="ground.ply"/>', two_sided(diffuse())))


def emitting_triangles(folder: Path, count: int) -> str:
    terrain(folder / "ground.ply", count)
    ground = HERE.shape("ply", "", '<string name="filename" value="ground.ply"/>', diffuse(), emitter(1))
    return scene(VIEW, ground, HERE.shape("rectangle", steps(scale="2, 1, 1", move="0, 0.5, -1.2"), two_sided(diffuse())))


def point_lights(_: Path, count: int) -> str:
    edge = int(count**0.5) + 1
    light = lambda i: (  # noqa: E731
        f'<emitter type="point"><point name="position" x="{2 * (i % edge) / edge - 1:.5g}" y="{0.1 + 0.1 * (i % 7):.3g}" '
        f'z="{2 * (i // edge) / edge - 1:.5g}"/><rgb name="intensity" value="{(1 + i % 5) / count:.5g}"/></emitter>'
    )
    return scene(VIEW, FLOOR, *map(light, range(count)))


def materials(_: Path, count: int) -> str:
    coat = lambda i: bsdf("roughplastic", number("alpha", 0.05 + 0.4 * i / count), number("int_ior", 1.5), rgb("diffuse_reflectance", f"{i % 97 / 100}, 0.3, {i % 89 / 100}"))  # noqa: E731
    return scene(VIEW, SKY, FLOOR, tiles(count, coat))


def textures(folder: Path, count: int) -> str:
    for i in range(count):
        (folder / f"{i}.png").write_bytes(png((i % 256, i // 256 % 256, 100)))
    image = lambda i: bsdf("diffuse", f'<texture type="bitmap" name="reflectance"><string name="filename" value="{i}.png"/></texture>')  # noqa: E731
    return scene(VIEW, SKY, FLOOR, tiles(count, image))


def instances(folder: Path, count: int) -> str:
    terrain(folder / "ground.ply", 20_000)
    mesh = '<shape type="ply"><string name="filename" value="ground.ply"/>' + two_sided(diffuse()) + "</shape>"
    group = f'<shape type="shapegroup" id="group">{mesh}</shape>'
    edge = int(count**0.5) + 1
    at = lambda i: f'<scale value="{0.9 / edge:.5g}"/><translate x="{2 * (i % edge) / edge - 1:.5g}" z="{2 * (i // edge) / edge - 1:.5g}"/>'  # noqa: E731
    use = lambda i: f'<shape type="instance"><ref id="group"/><transform name="to_world">{at(i)}</transform></shape>'  # noqa: E731
    return scene(VIEW, SKY, group, *map(use, range(count)))


def levels(folder: Path, depth: int) -> dict:
    """glTF nodes `depth` deep, four at each, with the same mesh at all ends."""
    n = 12
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
    points = np.stack([x, 0.2 * np.sin(3 * x), y], -1).reshape(-1, 3).astype("<f4")
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([corner, corner + n + 1, corner + 1], 1), np.stack([corner + 1, corner + n + 1, corner + n + 2], 1)]).astype("<u4")
    data = points.tobytes() + faces.tobytes()
    nodes: list[dict] = [{"camera": 0, "translation": [0, 1.2, 2.2], "rotation": [-0.25, 0, 0, 0.968]}]

    def node(level: int) -> int:
        index = len(nodes)
        nodes.append({})
        if level == depth:
            nodes[index] = {"mesh": 0, "scale": [0.8, 0.8, 0.8]}
            return index
        places = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
        for place in places:
            child = node(level + 1)
            nodes[child] |= {"translation": [place[0], 0.1, place[1]]}
            nodes[index].setdefault("children", []).append(child)
        nodes[index]["scale"] = [0.5, 0.5, 0.5]
        return index

    root = node(0)
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, root]}], "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01, "aspectRatio": 1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": points.nbytes}, {"buffer": 0, "byteOffset": points.nbytes, "byteLength": faces.nbytes}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }  # fmt: skip


SCENES: dict[str, tuple[Callable, int]] = {
    "10^7 triangles": (triangles, 10**7),
    "10^6 emitting triangles": (emitting_triangles, 10**6),
    "10^5 point lights": (point_lights, 10**5),
    "10^6 point lights": (point_lights, 10**6),
    "10^5 materials": (materials, 10**5),
    "10^4 textures": (textures, 10**4),
    "10^5 instances of 20000 triangles": (instances, 10**5),
    "glTF nodes 8 deep, 65536 meshes": (levels, 8),
}

RIVAL = """
import sys, time, mitsuba as mi, numpy as np
mi.set_variant("llvm_ad_rgb")
start = time.perf_counter()
mean = np.array(mi.render(mi.load_file(sys.argv[1]), spp=16)).mean()
print(time.perf_counter() - start, mean)
"""


def check_large(args, folder: Path) -> int:
    """One row per scene and method; the number of failures."""
    from scene_faults import first_line, run

    print("| scene | triangles | method | s | MB | Mitsuba, s | MB | mean, ours | Mitsuba's |\n|---|---|---|---|---|---|---|---|---|")
    wrong = 0
    for name, (make, count) in SCENES.items():
        if args.only and not any(text in name for text in args.only):
            continue
        place = folder / re.sub(r"\W", "_", name)
        place.mkdir(parents=True, exist_ok=True)
        made = make(place, count)
        path = place / ("scene.gltf" if isinstance(made, dict) else "scene.xml")
        path.write_text(json.dumps(made) if isinstance(made, dict) else made)
        size = "--size 64x64".split()
        found = run([str(args.manylight), "info", str(path), "--json"], LIMIT, args.wait)
        triangle_count = json.loads(found.stdout)["counts"]["triangles_with_instances"] if found.code == 0 else ""
        rival, of_rival = ["", ""], ""
        if path.suffix == ".xml":
            ended = run([sys.executable, "-c", RIVAL, str(path)], LIMIT, args.wait)
            rival = [f"{float(ended.stdout.split()[0]):.1f}", f"{ended.peak_mb:.0f}"] if ended.code == 0 else ["more than " + str(LIMIT) if ended.code == 124 else f"exit {ended.code}", ""]
            of_rival = f"{float(ended.stdout.split()[1]):.4f}" if ended.code == 0 else ""
        for method, options in (("path", ["--spp", "16"]), ("rich-vpl", ["-n", "256", "--passes", "4"])):
            words = ["render", str(path), "-m", method, *options, *size, "--filter", "box", "-q", "--json", "-o", str(place / f"{method}.pfm"), "-o", str(place / f"{method}.png")]
            ended = run([str(args.manylight), *words], LIMIT, args.wait)
            mean = first_line(ended.stderr)
            if ended.code == 0:
                values = np.frombuffer((place / f"{method}.pfm").read_bytes().split(b"\n", 3)[3], "<f4")
                mean = f"{values.mean():.4f}"
            wrong += ended.code != 0 or not np.isfinite(values).all()
            cells = [name, str(triangle_count), method, f"{ended.seconds:.1f}", f"{ended.peak_mb:.0f}", *(rival if method == "path" else ["", ""]), mean, of_rival]
            print("| " + " | ".join(cells) + " |", flush=True)
    return wrong
