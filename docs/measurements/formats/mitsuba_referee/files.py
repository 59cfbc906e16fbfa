"""The files that cases name: pictures, meshes, curves and spectra, made from formulas."""

import gzip
import struct
import zlib

import numpy as np

#: Points along an edge of the mesh.
EDGE = 9


def chart(width: int = 8, height: int = 8, channels: int = 3) -> np.ndarray:
    """Colors without any symmetry, in [0.05, 0.95]."""
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(channels), indexing="ij")
    return 0.5 + 0.45 * np.sin(1.7 * x + 2.9 * y * y + 2.1 * c + 0.4 * x * y)


def bumps() -> np.ndarray:
    """Heights in [0, 1]."""
    y, x = np.mgrid[0:32, 0:32] / 32
    return 0.5 + 0.5 * np.sin(2 * np.pi * (2 * x + 0.5 * y)) * np.cos(2 * np.pi * y)


def normals() -> np.ndarray:
    """A normal map that leans towards +u and, by half as much, towards +v."""
    y, x = np.mgrid[0:16, 0:16] / 16
    n = np.stack([0.5 + 0.2 * np.sin(2 * np.pi * x), 0.25 + 0.2 * np.cos(2 * np.pi * y), np.ones_like(x)], -1)
    return 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)


def sky(width: int, height: int) -> np.ndarray:
    """An environment with a bright side."""
    return 0.2 + 1.5 * chart(width, height) ** 2


def bytes_of(image: np.ndarray, deep: bool = False) -> np.ndarray:
    """Values in [0, 1] as integers of 8 or 16 bits."""
    return np.round(image * (65535 if deep else 255)).astype(np.uint16 if deep else np.uint8)


def tga(image: np.ndarray, footer: bytes = b"\0" * 8 + b"TRUEVISION-XFILE.\0") -> bytes:
    """A true-color file of 24 bits; rows from the bottom. Files of version 1 have no footer."""
    height, width, _ = image.shape
    return struct.pack("<BBB5xHHHHBB", 0, 0, 2, 0, 0, width, height, 24, 0) + image[::-1, :, ::-1].tobytes() + footer


def bmp(image: np.ndarray) -> bytes:
    """24 bits; rows from the bottom. The width must be a multiple of 4."""
    height, width, _ = image.shape
    pixels = image[::-1, :, ::-1].tobytes()
    return struct.pack("<2sIIIIiiHHIIiiII", b"BM", 54 + len(pixels), 0, 54, 40, width, height, 1, 24, 0, len(pixels), 0, 0, 0, 0) + pixels


class Hill:
    """A grid over x and y in [-1, 1] with a hill, its normals, texture coordinates and colors."""

    def __init__(self) -> None:
        v, u = np.mgrid[0:EDGE, 0:EDGE] / (EDGE - 1)
        x, y = 2 * u - 1, 2 * v - 1
        z = 0.8 * np.exp(-2 * ((x - 0.2) ** 2 + y**2))
        slope = np.stack([4 * (x - 0.2) * z, 4 * y * z, np.ones_like(z)], -1)
        self.points = np.stack([x, y, z], -1).reshape(-1, 3)
        self.normals = (slope / np.linalg.norm(slope, axis=-1, keepdims=True)).reshape(-1, 3)
        self.uvs = np.stack([u, v], -1).reshape(-1, 2)
        self.colors = np.stack([0.2 + 0.6 * u, 0.7 - 0.5 * v, 0.3 + 0 * u], -1).reshape(-1, 3)
        corner = np.arange(EDGE * EDGE).reshape(EDGE, EDGE)
        self.quads = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], -1).reshape(-1, 4)
        self.triangles = np.concatenate([self.quads[:, [0, 1, 2]], self.quads[:, [0, 2, 3]]])


HILL = Hill()


def ply(order: str = "<", columns: str = "xyz n uv", quads: bool = False, uv: str = "u v", more: str = "", faces: str = "") -> bytes:
    """The hill. `order` is `<`, `>` or `ascii`; `columns` chooses among points, normals and texture coordinates.

    `more` names a further property of vertices: `r g b`, `red green blue` (integers), or anything with one to three floats.
    `faces` does so for faces.
    """
    table, header = [HILL.points], ["property float x", "property float y", "property float z"]
    if " n" in columns:
        table, header = [*table, HILL.normals], header + [f"property float n{axis}" for axis in "xyz"]
    if "uv" in columns:
        table, header = [*table, HILL.uvs], header + [f"property float {name}" for name in uv.split()]
    kind = "uchar" if more.startswith("red") else "float"
    if more:
        colors = HILL.colors[:, : len(more.split())]
        table, header = (
            [*table, bytes_of(colors) if kind == "uchar" else colors],
            header + [f"property {kind} {name}" for name in more.split()],
        )
    corners = HILL.quads if quads else HILL.triangles
    of_face = [f"property float {name}" for name in faces.split()]
    shade = np.linspace(0.1, 0.9, len(corners))
    names = {"<": "binary_little_endian", ">": "binary_big_endian", "ascii": "ascii"}
    head = ["ply", f"format {names[order]} 1.0", f"element vertex {len(HILL.points)}", *header]
    head += [f"element face {len(corners)}", "property list uchar int vertex_indices", *of_face, "end_header", ""]
    lines = []
    for parts in zip(*table, strict=True):
        values = [float(x) if not isinstance(x, np.integer) else int(x) for part in parts for x in part]
        code = "".join("B" if isinstance(x, int) else "f" for x in values)
        lines.append(" ".join(map(str, values)) + "\n" if order == "ascii" else struct.pack(order + code, *values))
    for face, grey in zip(corners, shade, strict=True):
        values = [len(face), *map(int, face), *[float(grey)] * len(of_face)]
        code = f"B{len(face)}i{len(of_face)}f"
        lines.append(" ".join(map(str, values)) + "\n" if order == "ascii" else struct.pack(order + code, *values))
    body = "".join(lines).encode() if order == "ascii" else b"".join(lines)
    return "\n".join(head).encode() + body


def obj(columns: str = "vt vn", quads: bool = False, negative: bool = False) -> bytes:
    """The hill, with texture coordinates and normals if `columns` says so; `negative` counts from the last vertex."""
    lines = ["# hill"] + [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in HILL.points]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in HILL.uvs] if "vt" in columns else []
    lines += [f"vn {x:.7f} {y:.7f} {z:.7f}" for x, y, z in HILL.normals] if "vn" in columns else []
    pattern = {"": "{0}", "vt": "{0}/{0}", "vn": "{0}//{0}", "vt vn": "{0}/{0}/{0}"}[columns]
    first = -len(HILL.points) if negative else 1
    lines += ["f " + " ".join(pattern.format(first + i) for i in face) for face in (HILL.quads if quads else HILL.triangles)]
    return ("\n".join(lines) + "\n").encode()


def serialized(version: int = 4, columns: str = "n uv", double: bool = False, lift: tuple[float, ...] = (0.0,)) -> bytes:
    """A mesh for each height in `lift`: the hill, moved up by it."""
    result, starts = b"", []
    for height in lift:
        starts.append(len(result))
        flags = 0x0001 * ("n" in columns) | 0x0002 * ("uv" in columns) | 0x0008 * ("colors" in columns)
        flags |= 0x0010 * ("faces" in columns) | (0x2000 if double else 0x1000)
        data = struct.pack("<I", flags) + (b"hill\0" if version == 4 else b"") + struct.pack("<QQ", len(HILL.points), len(HILL.triangles))
        tables = [HILL.points + (0, 0, height)]
        tables += [HILL.normals] * ("n" in columns) + [HILL.uvs] * ("uv" in columns) + [HILL.colors] * ("colors" in columns)
        data += b"".join(table.astype("<f8" if double else "<f4").tobytes() for table in tables)
        data += HILL.triangles.astype("<u4").tobytes()
        result += struct.pack("<HH", 0x041C, version) + zlib.compress(data)
    places = b"".join(struct.pack("<Q" if version == 4 else "<I", start) for start in starts)
    return result + places + struct.pack("<I", len(starts))


def curves() -> bytes:
    """Two arcs and a straight line, with radii that change."""
    lines = []
    for place, bend in ((-0.6, 0.8), (0.0, 0.0), (0.6, -0.5)):
        for t in np.linspace(-1, 1, 7):
            lines.append(f"{place + bend * 0.3 * t * t:.5f} {t:.5f} {0.3 * bend * t:.5f} {0.12 + 0.05 * t:.5f}")
        lines.append("")
    return "\n".join(lines).encode()


def spectrum_text(values: dict[float, float]) -> bytes:
    return "".join(f"{wavelength} {value}\n" for wavelength, value in values.items()).encode()


def grid_volume() -> bytes:
    """A file of Mitsuba's grid volumes: three channels on 2 x 2 x 2 points."""
    data = chart(2, 4).reshape(2, 2, 2, 3).astype("<f4")
    return b"VOL\x03" + struct.pack("<iiiii6f", 1, 2, 2, 2, 3, -1, -1, -1, 1, 1, 1) + data.tobytes()


#: Content by file name. Mitsuba writes the arrays as pictures.
FILES: dict[str, bytes | np.ndarray] = {
    "chart.png": bytes_of(chart()),
    "wide.png": bytes_of(chart(12, 6)),
    "deep.png": bytes_of(chart(), deep=True),
    "gray.png": bytes_of(chart(channels=1)),
    "alpha.png": bytes_of(chart(channels=4)),
    "gray_alpha.png": bytes_of(chart(channels=2)),
    "texel.png": bytes_of(np.full((1, 1, 3), (0.2, 0.5, 0.7))),
    "chart.jpg": bytes_of(np.kron(chart(4, 4), np.ones((8, 8, 1)))),
    "chart.tga": tga(bytes_of(chart())),
    "version1.tga": tga(bytes_of(chart()), b""),
    "chart.bmp": bmp(bytes_of(chart())),
    "chart.exr": chart().astype(np.float32),
    "half.exr": chart().astype(np.float16),
    "gray.exr": chart(channels=1).astype(np.float32),
    "alpha.exr": chart(channels=4).astype(np.float32),
    "chart.hdr": chart().astype(np.float32),
    "chart.pfm": chart().astype(np.float32),
    "gray.pfm": chart(channels=1).astype(np.float32),
    "bumps.png": bytes_of(bumps()[:, :, None]),
    "bumps.exr": bumps()[:, :, None].astype(np.float32),
    "normals.png": bytes_of(normals()),
    "normals.exr": normals().astype(np.float32),
    **{f"sky{w}x{h}.exr": sky(w, h).astype(np.float32) for w, h in ((32, 16), (16, 16), (5, 3), (2, 2), (3, 1), (8, 64))},
    "sky.hdr": sky(32, 16).astype(np.float32),
    "sky.png": bytes_of(chart(32, 16)),
    "sky_half.exr": sky(32, 16).astype(np.float16),
    "hill.ply": ply(),
    "big.ply": ply(">"),
    "text.ply": ply("ascii"),
    "st.ply": ply(uv="s t"),
    "points.ply": ply(columns="xyz"),
    "smooth.ply": ply(columns="xyz n"),
    "mapped.ply": ply(columns="xyz uv"),
    "quads.ply": ply(quads=True),
    "colors.ply": ply(more="r g b"),
    "bytes.ply": ply(more="red green blue"),
    "vertex_weight.ply": ply(more="weight_x"),
    "vertex_tint.ply": ply(more="vertex_tint_r vertex_tint_g vertex_tint_b"),
    "plain_tint.ply": ply(more="tint_r tint_g tint_b"),
    "faces.ply": ply(faces="r g b"),
    "face_weight.ply": ply(faces="weight_x"),
    "hill.obj": obj(),
    "points.obj": obj(""),
    "smooth.obj": obj("vn"),
    "mapped.obj": obj("vt"),
    "quads.obj": obj(quads=True),
    "negative.obj": obj(negative=True),
    "hill.serialized": serialized(),
    "three.serialized": serialized(3, lift=(0.0, 0.4)),
    "many.serialized": serialized(lift=(-0.3, 0.0, 0.5)),
    "double.serialized": serialized(double=True),
    "plain.serialized": serialized(columns=""),
    "colors.serialized": serialized(columns="n uv colors"),
    "faceted.serialized": serialized(columns="n uv faces"),
    "curves.txt": curves(),
    "band.spd": spectrum_text({400: 0.1, 500: 0.3, 600: 0.8, 700: 0.6}),
    "narrow.spd": spectrum_text({500: 0.2, 550: 0.9, 600: 0.4}),
    "grid.vol": grid_volume(),
    "hill.ply.gz": gzip.compress(ply()),
}
