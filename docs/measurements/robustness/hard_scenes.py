"""Hard scenes, as Mitsuba XML with the files that they name: plain data for scene_faults.py."""

import struct
from dataclasses import dataclass, field

#: Films have this many pixels along each edge.
SIZE = 64


@dataclass
class Case:
    """A scene, and what a renderer should make of it."""

    name: str
    xml: str
    #: Further files of the scene.
    files: dict[str, bytes] = field(default_factory=dict)
    #: The case with the same picture, up to the factor `brightness`.
    same_as: str = ""
    brightness: float = 1.0
    #: The radiance of every pixel, where it is known.
    radiance: float | None = None
    #: Exit code 3 and this text are expected.
    message: str = ""
    #: Methods that cannot render the scene, such as light tracing for mirrors, or that are too noisy for a comparison.
    without: tuple[str, ...] = ()
    #: Why Mitsuba is no reference here; empty if it is one.
    no_mitsuba: str = ""
    #: Why the case is beyond a limit that docs/robustness.md names, and for which methods; differences are shown, and no faults.
    beyond: str = ""
    beyond_for: tuple[str, ...] = ("path", "light-trace", "photon-map", "rich-vpl", "rich-lightcuts")
    spp: int = 64


def rgb(name: str, value: str | float) -> str:
    return f'<rgb name="{name}" value="{value}"/>'


def number(name: str, value: float) -> str:
    return f'<float name="{name}" value="{value}"/>'


def bsdf(kind: str, *content: str) -> str:
    return f'<bsdf type="{kind}">{"".join(content)}</bsdf>'


def diffuse(value: str | float = 0.5) -> str:
    return bsdf("diffuse", rgb("reflectance", value))


def two_sided(inner: str) -> str:
    return bsdf("twosided", inner)


def glossy(alpha: float, kind: str = "roughconductor") -> str:
    """A material with GGX roughness `alpha`; the conductor is copper."""
    metal = rgb("eta", "0.2, 0.92, 1.1") + rgb("k", "3.9, 2.45, 2.14") if kind == "roughconductor" else ""
    base = rgb("diffuse_reflectance", "0.3, 0.1, 0.05") if kind == "roughplastic" else ""
    return bsdf(kind, number("alpha", alpha), '<string name="distribution" value="ggx"/>', metal, base)


def emitter(radiance: str | float) -> str:
    return f'<emitter type="area">{rgb("radiance", radiance)}</emitter>'


class Space:
    """Lengths and places under a scale, then a shift."""

    def __init__(self, scale: float = 1.0, shift: tuple[float, float, float] = (0, 0, 0)) -> None:
        self.scale, self.shift = scale, shift

    def point(self, *p: float) -> str:
        return ", ".join(f"{self.scale * x + d:.9g}" for x, d in zip(p, self.shift, strict=True))

    def shape(self, kind: str, to_world: str, *content: str) -> str:
        """`to_world` has steps before the scale of this space."""
        s, (x, y, z) = self.scale, self.shift
        placed = f'{to_world}<scale value="{s:.9g}"/><translate x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>'
        return f'<shape type="{kind}"><transform name="to_world">{placed}</transform>{"".join(content)}</shape>'

    def camera(self, origin: tuple, target: tuple, fov: float = 70, kind: str = "perspective", more: str = "") -> str:
        s = self.scale
        return f"""<sensor type="{kind}"><string name="fov_axis" value="x"/>{number("fov", fov)}
{number("near_clip", 1e-4 * s)}{number("far_clip", 1e4 * s)}{more}
<transform name="to_world"><lookat origin="{self.point(*origin)}" target="{self.point(*target)}" up="0, 1, 0"/></transform>
<sampler type="independent"/><film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
<string name="pixel_format" value="rgb"/><rfilter type="box"/></film></sensor>"""


def scene(*content: str, depth: int = 8) -> str:
    integrator = f'<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>'
    return '<scene version="3.0.0">\n' + "\n".join((integrator, *content)) + "\n</scene>\n"


def steps(*, scale: str = "", turn: str = "", move: str = "") -> str:
    found = f'<scale value="{scale}"/>' if scale else ""
    if turn:
        axis, angle = turn.split()
        found += f'<rotate {axis}="1" angle="{angle}"/>'
    return found + (f'<translate value="{move}"/>' if move else "")


#: The six walls of a room with x in [-1, 1], y in [0, 2], z in [-1, 1]; normals inwards.
WALLS = {
    "floor": steps(turn="x -90"),
    "ceiling": steps(turn="x 90", move="0, 2, 0"),
    "back": steps(move="0, 1, -1"),
    "front": steps(turn="y 180", move="0, 1, 1"),
    "left": steps(turn="y 90", move="-1, 1, 0"),
    "right": steps(turn="y -90", move="1, 1, 0"),
}
LAMP = steps(scale="0.3, 0.3, 1", turn="x 90", move="0, 1.98, 0")
VIEW = ((0.1, 1.0, 0.95), (0, 0.8, -1))


def walls(space: Space, materials: dict[str, str] | None = None, left_out: tuple[str, ...] = (), flip: bool = False) -> str:
    colors = {"left": "0.6, 0.1, 0.1", "right": "0.1, 0.5, 0.1"}
    materials = {name: diffuse(colors.get(name, 0.7)) for name in WALLS} | {"floor": glossy(0.3, "roughplastic")} | (materials or {})
    flipped = '<boolean name="flip_normals" value="true"/>' if flip else ""
    return "\n".join(space.shape("rectangle", place, materials[name], flipped) for name, place in WALLS.items() if name not in left_out)


def things(space: Space, ball: str = "", box: str = "") -> str:
    """A sphere, a box, and a pipe."""
    return "\n".join(
        (
            space.shape("sphere", steps(scale="0.35, 0.35, 0.35", move="-0.4, 0.35, -0.3"), ball or glossy(0.15, "roughplastic")),
            space.shape("cube", steps(scale="0.2, 0.4, 0.2", turn="y 25", move="0.45, 0.4, -0.35"), box or glossy(0.2)),
            space.shape("cylinder", steps(scale="0.08, 0.08, 0.6", turn="y 90", move="-0.3, 0.08, 0.3"), two_sided(diffuse("0.2, 0.3, 0.7"))),
        )
    )


def lamp(space: Space, radiance: str | float = "12, 11, 9") -> str:
    return space.shape("rectangle", LAMP, diffuse(0.2), emitter(radiance))


def room(space: Space | None = None, *, depth: int = 8, radiance: str | float = "12, 11, 9", more: str = "", **changes: str) -> str:
    """The glossy room, at any scale and place; `changes` replace `camera`, `walls`, `things` or `lamp`."""
    space = space or Space()
    parts = {"camera": space.camera(*VIEW), "walls": walls(space), "things": things(space), "lamp": lamp(space, radiance)} | changes
    return scene(*parts.values(), more, depth=depth)


def grid(n: int = 8) -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    """A floor of the room as 2 n² triangles."""
    corners = [(2 * i / n - 1, 0.0, 1 - 2 * j / n) for j in range(n + 1) for i in range(n + 1)]
    at = lambda i, j: j * (n + 1) + i  # noqa: E731
    cells = [(i, j) for j in range(n) for i in range(n)]
    triangles = [(at(i, j), at(i + 1, j), at(i + 1, j + 1)) for i, j in cells] + [(at(i, j), at(i + 1, j + 1), at(i, j + 1)) for i, j in cells]
    return corners, triangles


def obj(corners: list, triangles: list, normals: list | None = None) -> bytes:
    lines = ["v " + " ".join(f"{x:.9g}" for x in p) for p in corners] + ["vn " + " ".join(map(str, n)) for n in normals or []]
    corner = (lambda i: f"{i + 1}//{i + 1}") if normals else (lambda i: str(i + 1))
    return ("\n".join(lines + ["f " + " ".join(map(corner, t)) for t in triangles]) + "\n").encode()


def ply(corners: list, triangles: list, normals: list | None = None) -> bytes:
    columns = ["x", "y", "z"] + (["nx", "ny", "nz"] if normals else [])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(corners)}", *(f"property float {c}" for c in columns)]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = [(*p, *n) for p, n in zip(corners, normals or [()] * len(corners), strict=True)]
    body = b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)
    return "\n".join(header).encode() + body + b"".join(struct.pack("<B3i", 3, *t) for t in triangles)


def pfm(rows: list[list[float]]) -> bytes:
    """A grey image; rows from the top."""
    return f"Pf\n{len(rows[0])} {len(rows)}\n-1.0\n".encode() + b"".join(struct.pack(f"<{len(row)}f", *row) for row in reversed(rows))


def mesh(space: Space, name: str, *content: str) -> str:
    return space.shape(name.rsplit(".", 1)[1], "", f'<string name="filename" value="{name}"/>', *content)


def with_floor(name: str, data: bytes, *, material: str = "", **more: str) -> tuple[str, dict[str, bytes]]:
    """The room with a mesh in place of its floor."""
    space = Space()
    floor = mesh(space, name, material or glossy(0.3, "roughplastic"))
    return room(walls=walls(space, left_out=("floor",)) + floor, **more), {name: data}
