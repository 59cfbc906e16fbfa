"""Cases of shapes, meshes and transforms."""

from collections.abc import Iterator

from notation import (
    Case,
    bitmap,
    body,
    bsdf,
    diffuse,
    each,
    look,
    matrix,
    move,
    named,
    point,
    ref,
    scale,
    shape,
    texture,
    transform,
    turn,
)

CHART = bsdf("twosided", diffuse(bitmap("chart.png")))
#: Turns the hill towards the camera and the lamp.
LEAN = (turn(x=1, angle=-35), move(y=0.1))
SHAPES = {"sphere": {}, "disk": {}, "rectangle": {}, "cube": {}, "cylinder": {}}


def placed(kind: str, *nested: str, steps: tuple[str, ...] = LEAN, material: str = CHART, **params: object) -> str:
    return body(shape(kind, material, *nested, to_world=transform(*steps), **params))


def analytic() -> Iterator[Case]:
    small = {
        "sphere": (scale(value=0.9),),
        "disk": (),
        "rectangle": (scale(value=0.8),),
        "cube": (scale(value=0.6),),
        "cylinder": (scale(value=0.6),),
    }
    for kind, steps in small.items():
        yield Case(f"shape {kind}", placed(kind, steps=(*steps, turn(y=1, angle=30), turn(x=1, angle=25))))
        yield Case(
            f"shape {kind} flip_normals",
            placed(kind, steps=(*steps, turn(y=1, angle=30), turn(x=1, angle=25)), flip_normals=True, material=diffuse()),
        )
        yield Case(
            f"shape {kind} mirrored",
            placed(
                kind, steps=(*steps, scale(x=-1, y=1, z=1), turn(y=1, angle=30), turn(x=1, angle=25)), material=diffuse(bitmap("chart.png"))
            ),
        )
        uneven = (scale(x=1.3, y=0.5, z=0.8), *steps, turn(y=1, angle=30), turn(x=1, angle=25))
        yield Case(f"shape {kind} stretched", placed(kind, steps=uneven))
        rough = bsdf("roughconductor", alpha_u=0.05, alpha_v=0.5)
        yield Case(f"shape {kind} anisotropic", placed(kind, steps=(*steps, turn(y=1, angle=30), turn(x=1, angle=25)), material=rough))
    yield from each(
        "sphere", lambda **p: placed("sphere", steps=(), **p), [{"radius": 0.5}, {"center": point((0.5, 0.3, 0)), "radius": 0.7}]
    )
    ends = [
        {"p0": point((-1, 0, 0)), "p1": point((1, 0.5, 0)), "radius": 0.4},
        {"p0": point((0, 1, 0)), "p1": point((0, -1, 0)), "radius": 0.7},
    ]
    yield from each("cylinder", lambda **p: placed("cylinder", steps=(), **p), ends)
    yield Case("cylinder one-sided", placed("cylinder", steps=(turn(x=1, angle=60),), material=diffuse(bitmap("chart.png"))))
    yield Case("shape without a bsdf", body(shape("sphere")))
    yield Case("face_normals of a sphere mesh", placed("cube", face_normals=True, steps=(scale(value=0.6), turn(y=1, angle=30))))


def meshes() -> Iterator[Case]:
    files = ["hill.ply", "big.ply", "text.ply", "st.ply", "points.ply", "smooth.ply", "mapped.ply", "quads.ply", "colors.ply"]
    files += ["hill.obj", "points.obj", "smooth.obj", "mapped.obj", "quads.obj", "negative.obj"]
    files += ["hill.serialized", "double.serialized", "plain.serialized", "colors.serialized", "faceted.serialized"]
    for name in files:
        yield Case(f"mesh {name}", placed(name.rsplit(".", 1)[1], filename=name))
    yield Case("mesh .ply.gz", placed("ply", filename="hill.ply.gz"))
    flags = [{"face_normals": True}, {"flip_normals": True}, {"flip_tex_coords": True}, {"flip_tex_coords": False}]
    for kind in ("ply", "obj", "serialized"):
        yield from each(
            f"mesh {kind}", lambda kind=kind, **p: placed(kind, filename=f"hill.{kind}", material=diffuse(bitmap("chart.png")), **p), flags
        )
    plastic = bsdf("roughplastic", alpha=0.1)
    yield from each("mesh glossy", lambda **p: placed("ply", filename="points.ply", material=plastic, **p), [{}, {"face_normals": True}])
    yield from each(
        "mesh without normals", lambda **p: placed("obj", filename="points.obj", material=plastic, **p), [{}, {"face_normals": True}]
    )
    for name, index in (
        ("many.serialized", 0),
        ("many.serialized", 1),
        ("many.serialized", 2),
        ("three.serialized", 0),
        ("three.serialized", 1),
    ):
        yield Case(f"mesh {name} shape_index={index}", placed("serialized", filename=name, shape_index=index))
    yield Case("mesh mirrored", placed("ply", filename="hill.ply", steps=(scale(x=-1, y=1, z=1), *LEAN), material=plastic))
    yield Case("mesh stretched", placed("ply", filename="hill.ply", steps=(scale(x=1.2, y=0.6, z=1.5), *LEAN), material=plastic))
    yield Case(
        "mesh mirrored without normals", placed("ply", filename="points.ply", steps=(scale(x=-1, y=1, z=1), *LEAN), material=plastic)
    )
    yield Case("mesh of glass", placed("ply", filename="hill.ply", material=bsdf("dielectric")))
    yield Case(
        "mesh bumpmap", placed("ply", filename="hill.ply", material=bsdf("bumpmap", bitmap("bumps.png", raw=True), plastic, scale=0.1))
    )
    normal = bsdf("normalmap", plastic, normalmap=bitmap("normals.png", raw=True))
    yield Case("mesh normalmap", placed("ply", filename="hill.ply", material=normal))
    yield Case(
        "mesh normalmap from behind",
        placed("ply", filename="hill.ply", steps=(turn(y=1, angle=180), *LEAN), material=bsdf("twosided", normal)),
    )
    yield Case("mesh anisotropic", placed("obj", filename="hill.obj", material=bsdf("roughconductor", alpha_u=0.05, alpha_v=0.5)))
    yield Case(
        "mesh anisotropic without uv", placed("obj", filename="smooth.obj", material=bsdf("roughconductor", alpha_u=0.05, alpha_v=0.5))
    )


def attributes() -> Iterator[Case]:
    def colored(file: str, name: str, *nested: str, **params: object) -> str:
        material = bsdf("twosided", diffuse(texture("mesh_attribute", name=name, **params)))
        return placed(file.rsplit(".", 1)[1], *nested, filename=file, material=material)

    rows = {
        "vertex r g b": colored("colors.ply", "vertex_color"),
        "vertex bytes": colored("bytes.ply", "vertex_color"),
        "scale": colored("colors.ply", "vertex_color", scale=0.5),
        "one value": colored("vertex_weight.ply", "vertex_weight"),
        "face r g b": colored("faces.ply", "face_color"),
        "face value": colored("face_weight.ply", "face_weight"),
        "serialized": colored("colors.serialized", "vertex_color"),
        "prefixed": colored("vertex_tint.ply", "vertex_vertex_tint_color"),
        "not prefixed": colored("plain_tint.ply", "vertex_tint_color"),
    }
    yield from named("mesh_attribute", str, rows)
    yield Case("texture nested in a shape", colored("hill.ply", "vertex_wood", bitmap("chart.png").named("vertex_wood")))
    weight = texture("mesh_attribute", name="vertex_weight")
    blend = bsdf("blendbsdf", diffuse((0.8, 0.1, 0.1)), bsdf("roughconductor", alpha=0.3), weight=weight)
    yield Case("mesh_attribute as weight", placed("ply", filename="vertex_weight.ply", material=blend))


def curves_and_groups() -> Iterator[Case]:
    for kind in ("linearcurve", "bsplinecurve"):
        yield Case(f"{kind}", placed(kind, filename="curves.txt", steps=()))
        yield Case(f"{kind} scaled", placed(kind, filename="curves.txt", steps=(scale(x=1.4, y=0.8, z=1),)))
        yield Case(f"{kind} plastic", placed(kind, filename="curves.txt", steps=(), material=bsdf("roughplastic", alpha=0.1)))
    group = shape(
        "shapegroup",
        shape("sphere", CHART, radius=0.4),
        shape("cube", diffuse((0.7, 0.2, 0.1)), to_world=transform(scale(value=0.3), move(x=0.7))),
        id="group",
    )
    places = {
        "moved": (move(x=-0.5, y=0.3),),
        "turned": (turn(y=1, angle=40), turn(x=1, angle=20)),
        "stretched": (scale(x=0.7, y=1.5, z=1),),
        "mirrored": (scale(x=-1, y=1, z=1),),
    }
    for words, steps in places.items():
        yield Case(f"instance {words}", body(group, shape("instance", ref("group"), to_world=transform(*steps))))
    pair = [shape("instance", ref("group"), to_world=transform(scale(value=0.6), move(y=y))) for y in (-0.5, 0.6)]
    yield Case("instance twice", body(group, *pair))
    inner = shape("shapegroup", shape("ply", bsdf("roughplastic", alpha=0.1), filename="hill.ply", to_world=transform(*LEAN)), id="group")
    yield Case(
        "instance of a mesh",
        body(inner, shape("instance", ref("group"), to_world=transform(scale(x=1.3, y=0.7, z=1), turn(z=1, angle=20)))),
    )
    yield Case(
        "merge",
        body(
            shape(
                "merge",
                shape("ply", CHART, filename="hill.ply", to_world=transform(*LEAN)),
                shape("cube", diffuse(), to_world=transform(scale(value=0.3), move(y=-0.8))),
            )
        ),
    )


def transforms() -> Iterator[Case]:
    base = scale(x=0.5, y=0.4, z=0.3)
    rows = {
        "translate then rotate": (base, move(x=0.6), turn(z=1, angle=50)),
        "rotate then translate": (base, turn(z=1, angle=50), move(x=0.6)),
        "rotate about x": (base, turn(x=1, angle=30)),
        "rotate about -y": (base, turn(y=-1, angle=30)),
        "rotate about a diagonal": (base, turn(x=0.6, y=0.8, angle=70)),
        "axis that is no unit vector": (base, turn(x=1, y=1, angle=30)),
        "rotate by value": (base, turn(value="0, 0, 1", angle=50)),
        "scale one axis": (base, scale(y=2)),
        "scale by one value": (base, scale(value=1.5)),
        "scale by three values": (base, scale(value="1.5, 1, 0.7")),
        "translate by value": (base, move(value="0.3, 0.2, 0.1")),
        "translate one axis": (base, move(y=0.4)),
        "lookat": (base, look((0.3, 0.2, 0), (2, 1, 1))),
        "lookat then scale": (base, look((0.3, 0.2, 0), (2, 1, 1), (0, 0, 1)), scale(value=0.7)),
        "matrix": (base, matrix(value="0.8 0.3 0 0.2  -0.3 0.8 0.1 0.1  0 0.2 1 0  0 0 0 1")),
        "matrix 3x3": (base, matrix(value="0.8 0.3 0  -0.3 0.8 0.1  0 0.2 1")),
        "nothing": (),
    }
    yield from named("transform", lambda steps: placed("cube", steps=steps), rows, spp=32)


def all_cases() -> Iterator[Case]:
    for cases in (analytic, meshes, attributes, curves_and_groups, transforms):
        yield from cases()
