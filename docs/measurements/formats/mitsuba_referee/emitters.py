"""Cases of emitters and of integrators."""

from collections.abc import Iterator

from notation import (
    CAMERA,
    FLOOR,
    LAMP,
    SKY,
    Case,
    bitmap,
    body,
    bsdf,
    checker,
    diffuse,
    each,
    emitter,
    integrator,
    lit,
    look,
    move,
    named,
    point,
    scale,
    scene,
    shape,
    transform,
    turn,
    vector,
)

GLOW = emitter("area", radiance=(4.0, 3.0, 2.0))
ABOVE = look((-1, 2, 1.5), (0, -0.5, 0))


def points() -> Iterator[Case]:
    places = [
        {"position": point((-1, 2, 1.5))},
        {"to_world": transform(move(x=-1, y=2, z=1.5))},
        {"to_world": transform(scale(value=2), move(x=-1, y=2, z=1.5))},
        {"intensity": 3.0, "position": point((0, 1, 1))},
        {},
    ]
    yield from each("point", lambda **p: lit(emitter("point", **p)), places, spp=32)
    aimed = {"intensity": (9.0, 8.0, 7.0), "to_world": transform(ABOVE)}
    spots = [
        {},
        {"cutoff_angle": 35.0},
        {"cutoff_angle": 35.0, "beam_width": 10.0},
        {"cutoff_angle": 35.0, "beam_width": 35.0},
        {"cutoff_angle": 80.0},
        {"texture": bitmap("chart.png"), "cutoff_angle": 35.0},
        {"texture": bitmap("wide.png"), "cutoff_angle": 35.0, "beam_width": 30.0},
        {"texture": checker(0.0, 1.0), "cutoff_angle": 40.0},
        {"to_world": transform(scale(value=3), ABOVE)},
        {"to_world": transform(scale(x=3, y=1, z=1), ABOVE), "cutoff_angle": 30.0},
        {"to_world": transform(scale(x=-1, y=1, z=1), ABOVE), "texture": bitmap("chart.png")},
        {"to_world": transform(scale(x=1, y=1, z=2), ABOVE), "cutoff_angle": 30.0},
        {"to_world": transform(turn(x=1, angle=-90), move(y=2)), "cutoff_angle": 40.0},
        {"intensity": 5.0},
    ]
    yield from each("spot", lambda **p: lit(emitter("spot", **(aimed | p))), spots, spp=32)
    suns = [
        {"direction": vector((1, -2, -1))},
        {"direction": vector((3, -6, -3))},
        {"to_world": transform(ABOVE)},
        {"to_world": transform(scale(value=2), ABOVE)},
        {"to_world": transform(scale(x=1, y=1, z=3), ABOVE)},
        {"to_world": transform(scale(x=3, y=1, z=1), ABOVE)},
        {"to_world": transform(ABOVE, move(x=9))},
        {"irradiance": (3.0, 2.0, 1.0), "direction": vector((0, -1, -1))},
    ]
    yield from each("directional", lambda **p: lit(emitter("directional", **p)), suns, spp=32)


def projectors() -> Iterator[Case]:
    rows = [
        {"irradiance": bitmap("chart.png")},
        {"irradiance": bitmap("wide.png")},
        {"irradiance": bitmap("chart.png"), "scale": 3.0},
        {"irradiance": bitmap("wide.png"), "fov_axis": "y"},
        {"irradiance": bitmap("wide.png"), "fov_axis": "diagonal"},
        {"irradiance": bitmap("wide.png"), "fov_axis": "smaller"},
        {"irradiance": (2.0, 3.0, 1.0)},
        {"irradiance": bitmap("chart.exr")},
        {"irradiance": bitmap("chart.png", raw=True)},
        {"irradiance": bitmap("chart.png"), "to_world": transform(scale(value=2), ABOVE)},
        {"irradiance": bitmap("chart.png"), "to_world": transform(scale(x=2, y=1, z=1), ABOVE)},
        {"irradiance": checker(0.0, 1.0)},
    ]
    aimed = {"fov": 50.0, "to_world": transform(ABOVE)}
    yield from each("projector", lambda **p: lit(emitter("projector", **(aimed | p))), rows, spp=32)
    focal = emitter("projector", irradiance=bitmap("chart.png"), focal_length="50mm", to_world=transform(ABOVE))
    yield Case("projector focal_length", lit(focal), 32)


def skies() -> Iterator[Case]:
    yield from each(
        "constant", lambda **p: lit(emitter("constant", **p)), [{}, {"radiance": (0.2, 0.5, 0.9)}, {"to_world": transform(scale(value=2))}]
    )
    maps = [
        "sky32x16.exr",
        "sky16x16.exr",
        "sky5x3.exr",
        "sky2x2.exr",
        "sky3x1.exr",
        "sky8x64.exr",
        "sky.hdr",
        "sky.png",
        "sky_half.exr",
        "chart.jpg",
        "chart.pfm",
        "alpha.exr",
        "gray.exr",
    ]
    yield from each("envmap", lambda **p: lit(emitter("envmap", **p)), ({"filename": name} for name in maps), spp=128)
    rows = {
        "scale": {"scale": 2.5},
        "turned about y": {"to_world": transform(turn(y=1, angle=70))},
        "turned about x": {"to_world": transform(turn(x=1, angle=90))},
        "turned twice": {"to_world": transform(turn(x=1, angle=90), turn(y=1, angle=30))},
        "scaled transform": {"to_world": transform(scale(value=2))},
        "mirrored transform": {"to_world": transform(scale(x=-1, y=1, z=1))},
        "mis_compensation": {"mis_compensation": True},
        "moved": {"to_world": transform(move(x=5))},
        "stretched transform": {"to_world": transform(scale(x=1, y=3, z=1))},
    }
    for words, given in rows.items():
        yield Case(f"envmap {words}", lit(emitter("envmap", filename="sky32x16.exr", **given)), 128)
    mirror = scene(CAMERA, shape("sphere", bsdf("conductor")), emitter("envmap", filename="sky32x16.exr"))
    yield Case("envmap in a mirror", mirror)


def suns() -> Iterator[Case]:
    place = {"sun_direction": vector((-1, 1, 1)), "to_world": transform(turn(x=1, angle=-90))}
    rows = [
        {},
        {"turbidity": 1.0},
        {"turbidity": 8.5},
        {"albedo": 0.8},
        {"albedo": (0.9, 0.1, 0.2)},
        {"sun_scale": 0.0},
        {"sky_scale": 0.0},
        {"sun_scale": 3.0, "sky_scale": 0.5},
        {"sun_aperture": 10.0},
        {"sun_direction": vector((-3, 0.3, 1))},
        {"to_world": transform(turn(x=1, angle=-90), turn(y=1, angle=60))},
        {"complex_sun": True},
    ]
    yield from each("sunsky", lambda **p: lit(emitter("sunsky", **(place | p))), rows, spp=128)
    upright = transform(turn(x=1, angle=-90))
    times = [
        {},
        {"hour": 9.0},
        {"latitude": -20.0, "month": 1},
        {"longitude": 100.0, "timezone": 7.0},
        {"year": 2024, "day": 3, "minute": 40.0, "second": 20.0},
    ]
    yield from each("sunsky at", lambda **p: lit(emitter("sunsky", to_world=upright, **p)), times, spp=128)
    yield Case("timed_sunsky", lit(emitter("timed_sunsky", to_world=upright)))
    yield Case(
        "directionalarea",
        body(
            shape(
                "rectangle", emitter("directionalarea", radiance=5.0), to_world=transform(scale(value=0.5), turn(x=1, angle=90), move(y=2))
            )
        ),
    )


def lamps() -> Iterator[Case]:
    """Shapes that emit light."""
    shapes = {
        "sphere": {"radius": 0.5},
        "disk": {},
        "rectangle": {},
        "cube": {},
        "cylinder": {"radius": 0.3},
        "ply": {"filename": "hill.ply"},
        "obj": {"filename": "hill.obj"},
    }
    placed = transform(scale(value=0.6), turn(x=1, angle=50), move(y=0.3))
    for flip in (False, True):
        for kind, params in shapes.items():
            words = f"lamp {kind}" + (" flip_normals" if flip else "")
            yield Case(words, scene(CAMERA, FLOOR, shape(kind, GLOW, flip_normals=flip, to_world=placed, **params), depth=3))
    stretched = transform(scale(x=1.2, y=0.5, z=0.8), turn(x=1, angle=50), move(y=0.3))
    for kind in ("disk", "rectangle", "cube", "ply", "sphere", "cylinder"):
        yield Case(f"lamp {kind} stretched", scene(CAMERA, FLOOR, shape(kind, GLOW, to_world=stretched, **shapes[kind]), depth=3))
    textured = emitter("area", radiance=bitmap("chart.png"))
    for kind, params in shapes.items():
        yield Case(f"lamp {kind} textured", scene(CAMERA, FLOOR, shape(kind, textured, to_world=placed, **params), depth=3))
    materials = {
        "white": diffuse((0.9, 0.9, 0.9)),
        "mirror": bsdf("conductor"),
        "glass": bsdf("dielectric"),
        "mask": bsdf("mask", diffuse(), opacity=0.5),
        "null": bsdf("null"),
        "twosided": bsdf("twosided", diffuse()),
        "mask checkerboard": bsdf("mask", diffuse(), opacity=checker(0.0, 1.0)),
    }
    yield from named("lamp of", lambda material: scene(CAMERA, FLOOR, SKY, shape("sphere", material, GLOW, radius=0.6)), materials)
    yield Case(
        "two lamps with one emitter",
        scene(CAMERA, FLOOR, *(shape("sphere", GLOW, radius=0.3, center=point((x, 0, 0))) for x in (-0.8, 0.8))),
    )
    yield Case(
        "sampling_weight", lit(emitter("point", position=point((-1, 2, 2)), sampling_weight=0.2), emitter("constant", sampling_weight=3.0))
    )


def integrators() -> Iterator[Case]:
    corner = (
        CAMERA,
        FLOOR,
        LAMP,
        SKY,
        shape("sphere", bsdf("plastic", diffuse_reflectance=(0.8, 0.7, 0.6))),
        shape("rectangle", bsdf("conductor"), to_world=transform(move(z=-1.5))),
    )
    rows = [{"max_depth": n} for n in (0, 1, 2, 3, 4, -1)] + [
        {"rr_depth": 1},
        {"rr_depth": 50, "max_depth": 30},
        {"hide_emitters": True},
        {"max_depth": 2, "hide_emitters": True},
    ]
    yield from each("path", lambda **p: scene(integrator("path", **p), *corner), rows, spp=128)
    kinds = {
        "direct": integrator("direct"),
        "direct samples": integrator("direct", emitter_samples=2, bsdf_samples=3),
        "direct hide_emitters": integrator("direct", hide_emitters=True),
        "volpath": integrator("volpath", max_depth=4),
        "volpathmis": integrator("volpathmis", max_depth=4),
        "ptracer": integrator("ptracer", max_depth=4),
        "moment": integrator("moment", integrator("path", max_depth=3)),
        "aov": integrator("aov", integrator("path", max_depth=3), aovs="dd.y:depth,nn:sh_normal"),
    }
    yield from named("integrator", lambda how: scene(how, *corner), kinds, spp=128)
    glass = scene(integrator("path", max_depth=8, hide_emitters=True), CAMERA, FLOOR, LAMP, SKY, shape("sphere", bsdf("dielectric")))
    yield Case("path hide_emitters behind glass", glass, 128)
    through = scene(
        integrator("path", max_depth=3, hide_emitters=True), CAMERA, FLOOR, LAMP, SKY, shape("sphere", bsdf("mask", diffuse(), opacity=0.4))
    )
    yield Case("path hide_emitters behind a mask", through, 128)
    for depth in (1, 2, 3):
        yield Case(
            f"path max_depth={depth} through null", scene(CAMERA, FLOOR, LAMP, SKY, shape("sphere", bsdf("null"), radius=1.2), depth=depth)
        )


def all_cases() -> Iterator[Case]:
    for cases in (points, projectors, skies, suns, lamps, integrators):
        yield from cases()
