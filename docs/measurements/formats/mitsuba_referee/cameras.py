"""Cases of sensors and films, and of the language: references, defaults, includes, old versions."""

from collections.abc import Iterator

from notation import (
    CAMERA,
    FLOOR,
    FRONT,
    LAMP,
    SKY,
    Case,
    Xml,
    bitmap,
    bsdf,
    diffuse,
    each,
    emitter,
    film,
    look,
    move,
    named,
    picture,
    point,
    ref,
    rfilter,
    sampler,
    scale,
    scene,
    sensor,
    shape,
    transform,
    turn,
)

VIEW = transform(look((0.5, 1, 5)))
WALL = shape("rectangle", diffuse(bitmap("chart.png")), to_world=transform(scale(value=2), move(z=-1)))
THING = shape("sphere", diffuse((0.8, 0.4, 0.2)), radius=0.6)


def seen(camera: str) -> str:
    """A chart behind a sphere, under a white sky."""
    return scene(camera, WALL, THING, emitter("constant", radiance=(1.0, 0.8, 0.6)), depth=2)


def through(kind: str, *nested: str, **params: object) -> str:
    nested = nested if any("<film" in part for part in nested) else (*nested, picture(60, 40))
    return seen(sensor(kind, *nested, **({"fov": 40.0, "to_world": VIEW} | params)))


def sensors() -> Iterator[Case]:
    rows = [{"fov": 20.0}, {"fov": 90.0}, *({"fov_axis": axis} for axis in ("x", "y", "diagonal", "smaller", "larger"))]
    rows += [{"principal_point_offset_x": 0.2}, {"principal_point_offset_y": 0.2}, {"near_clip": 5.0}, {"far_clip": 5.5}]
    rows += [{"to_world": transform(scale(value=2), look((0.5, 1, 5)))}, {"to_world": transform(scale(x=-1, y=1, z=1), look((0.5, 1, 5)))}]
    rows += [{"to_world": transform(look((0.5, 1, 5), (0, 0, 0), (1, 1, 0)))}, {"shutter_open": 0.0, "shutter_close": 1.0}]
    yield from each("perspective", lambda **p: through("perspective", **p), rows, spp=32)
    tall = [{"fov_axis": axis} for axis in ("x", "y", "diagonal", "smaller", "larger")]
    yield from each("perspective tall", lambda **p: through("perspective", picture(40, 60), **p), tall, spp=32)
    lengths = [{"focal_length": text} for text in ("50mm", "28mm", "100mm")] + [{"focal_length": "50mm", "fov_axis": "x"}, {}]
    yield from each(
        "perspective without fov", lambda **p: seen(sensor("perspective", picture(60, 40), to_world=VIEW, **p)), lengths, spp=32
    )
    lenses = [
        {"focus_distance": 5.0},
        {"focus_distance": 3.0},
        {"focus_distance": 5.0, "aperture_radius": 0.5},
        {"focus_distance": 8.0, "fov_axis": "y"},
        {},
    ]
    yield from each("thinlens", lambda **p: through("thinlens", **({"aperture_radius": 0.2} | p)), lenses)
    yield Case(
        "thinlens scaled",
        through("thinlens", aperture_radius=0.2, focus_distance=4.0, to_world=transform(scale(value=2), look((0.5, 1, 5)))),
    )
    flat = {
        "look": (look((0, 1, 4)),),
        "scaled": (scale(value=1.7), look((0, 1, 4))),
        "stretched": (scale(x=2, y=1, z=1), look((0, 1, 4))),
        "mirrored": (scale(x=-1, y=1, z=1), look((0, 1, 4))),
    }
    for words, steps in flat.items():
        yield Case(f"orthographic {words}", seen(sensor("orthographic", picture(60, 40), to_world=transform(*steps))), 32)
    yield from each(
        "orthographic",
        lambda **p: seen(sensor("orthographic", picture(), to_world=transform(scale(value=2), look((0, 1, 4))), **p)),
        [{"near_clip": 3.6}, {"far_clip": 4.2}],
        spp=32,
    )


def films() -> Iterator[Case]:
    crops = [
        {"crop_offset_x": 10, "crop_offset_y": 5, "crop_width": 30, "crop_height": 20},
        {"crop_width": 30, "crop_height": 20},
        {"crop_offset_y": 8, "crop_height": 32},
    ]
    yield from each("film", lambda **p: through("perspective", picture(60, 40, **p)), crops, spp=32)
    yield Case("film of one pixel row", through("perspective", picture(60, 3)), 128)
    yield from each(
        "film",
        lambda **p: through("perspective", picture(60, 40, **p)),
        [{"component_format": "float32"}, {"compensate": True}, {"sample_border": True}],
        spp=32,
    )
    yield Case(
        "film pixel_format rgba", through("perspective", film("hdrfilm", rfilter("box"), width=60, height=40, pixel_format="rgba")), 32
    )
    filters = {
        "box": rfilter("box"),
        "tent": rfilter("tent"),
        "tent 2": rfilter("tent", radius=2.0),
        "gaussian": rfilter("gaussian"),
        "gaussian 1": rfilter("gaussian", stddev=1.0),
        "mitchell": rfilter("mitchell"),
        "mitchell B C": rfilter("mitchell", B=0.8, C=0.1),
        "catmullrom": rfilter("catmullrom"),
        "lanczos": rfilter("lanczos"),
        "lanczos 2": rfilter("lanczos", lobes=2),
    }
    yield from named("rfilter", lambda of: through("perspective", picture(30, 20, of)), filters, spp=128)
    yield Case("rfilter absent", through("perspective", film("hdrfilm", width=30, height=20, pixel_format="rgb")), 128)
    samplers = ("independent", "stratified", "multijitter", "orthogonal", "ldsampler")
    yield from each(
        "sampler",
        lambda kind: through("perspective", sampler(kind, sample_count=16), picture(60, 40)),
        ({"kind": kind} for kind in samplers),
        spp=32,
    )


OLD = """<scene version="0.6.0"><integrator type="path"><integer name="maxDepth" value="4"/></integrator>
<sensor type="perspective"><float name="fov" value="35"/><string name="fovAxis" value="y"/>
<transform name="toWorld"><lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="48"/><rfilter type="box"/></film></sensor>
<emitter type="constant"><rgb name="radiance" value="0.3, 0.35, 0.4"/></emitter>
<emitter type="point"><point name="position" x="-2" y="3" z="2"/><rgb name="intensity" value="20, 18, 15"/></emitter>
{}</scene>
"""


def old_versions() -> Iterator[Case]:
    red = (0.8, 0.2, 0.1)
    tilted = transform(scale(value=0.6), turn(x=1, y=1, angle=40))
    materials = {
        "diffuse": bsdf("diffuse", reflectance=red),
        "srgb": bsdf("diffuse", reflectance=Xml('<srgb value="#c08040"/>')),
        "roughplastic": bsdf("roughplastic", alpha=0.2, intIOR=1.4, diffuseReflectance=red),
        "roughconductor": bsdf("roughconductor", material="Cu", alphaU=0.1, alphaV=0.3),
        "dielectric": bsdf("dielectric", intIOR="water", specularTransmittance=(0.5, 0.9, 0.7)),
        "spectrum": bsdf("diffuse", reflectance=Xml('<spectrum value="0.3"/>')),
        "bitmap": diffuse(bitmap("chart.png", uscale=2.0, voffset=0.3)),
        "mask": bsdf("mask", diffuse(), opacity=0.4),
    }
    bodies = {words: shape("sphere", material) for words, material in materials.items()}
    bodies["flip_normals"] = shape("cube", bsdf("twosided", diffuse()), flipNormals=True)
    bodies["rotation"] = shape("cube", diffuse(), toWorld=tilted)
    yield from named("version 0.6", OLD.format, bodies)


def language() -> Iterator[Case]:
    red = bsdf("diffuse", reflectance=(0.8, 0.2, 0.1), id="red")
    lights = (CAMERA, FLOOR, LAMP, SKY)
    again = shape("cube", ref("red"), to_world=transform(scale(value=0.4), move(x=0.8)))
    wood = bitmap("chart.png").replace("<texture", '<texture id="wood"', 1)
    rows = {
        "ref": scene(*lights, red, shape("sphere", ref("red"), radius=0.7), again),
        "ref before": scene(*lights, shape("sphere", ref("red"), radius=0.7), red, again),
        "ref to a nested": scene(*lights, shape("sphere", red, radius=0.7), again),
        "ref to a texture": scene(*lights, wood, shape("sphere", diffuse(ref("wood")))),
        "alias": scene(*lights, red, '<alias id="red" as="rot"/>', shape("sphere", ref("rot"))),
        "default": scene(
            *lights,
            '<default name="grey" value="0.3"/>',
            shape("sphere", bsdf("diffuse", reflectance=Xml('<rgb value="$grey, 0.5, $grey"/>'))),
        ),
        "longest default": scene(
            *lights,
            '<default name="a" value="0.9"/><default name="ab" value="0.2"/>',
            shape("sphere", bsdf("diffuse", reflectance=Xml('<rgb value="$ab"/>'))),
        ),
        "default in a type": scene(*lights, '<default name="kind" value="plastic"/>', shape("sphere", bsdf("$kind"))),
        "include of a scene": scene(*lights, '<include filename="red_scene.xml"/>', shape("sphere", ref("red"))),
        "include of a bsdf": scene(*lights, '<include filename="red_bsdf.xml"/>', shape("sphere", ref("red"))),
        "include with a default": scene(
            *lights, '<default name="grey" value="0.7"/><include filename="grey_scene.xml"/>', shape("sphere", ref("grey"))
        ),
        "path": scene(*lights, '<path value="folder"/>', shape("sphere", diffuse(bitmap("inside.png")))),
        "comment": scene(*lights, "<!-- nothing -->", shape("sphere", diffuse())),
        "two emitters": scene(*lights, emitter("point", position=point((0, 2, 2))), shape("sphere", diffuse())),
        "two sensors": scene(CAMERA, FRONT, FLOOR, LAMP, SKY, shape("sphere", diffuse())),
        "spaces in numbers": scene(*lights, shape("sphere", diffuse(Xml('<rgb value="  0.2,0.4 ,0.6  "/>')))),
        "point by value": scene(*lights, shape("sphere", diffuse(), radius=0.6, center=Xml('<point value="0.4, 0.2, 0.1"/>'))),
        "point by x y z": scene(*lights, shape("sphere", diffuse(), radius=0.6, center=Xml('<point x="0.4" y="0.2" z="0.1"/>'))),
        "exponents": scene(*lights, shape("sphere", diffuse((2e-1, 0.5, 7.5e-1)))),
        "version 2.1": scene(*lights, shape("sphere", bsdf("roughplastic", alpha=0.2)), version="2.1.0"),
    }
    yield from named("language", str, rows, spp=32)


#: Further scene files, which cases include.
INCLUDED = {
    "red_scene.xml": '<scene version="3.0.0">' + bsdf("diffuse", reflectance=(0.8, 0.2, 0.1), id="red") + "</scene>",
    "red_bsdf.xml": bsdf("diffuse", reflectance=(0.8, 0.2, 0.1), id="red").replace("<bsdf", '<bsdf version="3.0.0"', 1),
    "grey_scene.xml": '<scene version="3.0.0"><default name="grey" value="0.2"/>'
    + bsdf("diffuse", reflectance=Xml('<rgb value="$grey"/>'), id="grey")
    + "</scene>",
}


def all_cases() -> Iterator[Case]:
    for cases in (sensors, films, old_versions, language):
        yield from cases()
