"""A short notation for Mitsuba's XML, and the stages on which cases are shown.

`bsdf("plastic", int_ior=1.3, diffuse_reflectance=(0.2, 0.5, 0.8))` is an element with its parameters. The type of a value is the
type of the parameter: bool, int, float and str as they are; a tuple of three numbers is an `<rgb>`; an `Xml` is nested under the name.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial

#: Films have this many pixels along each edge unless a case says otherwise.
SIZE = 48


class Xml(str):
    """An XML element."""

    def named(self, name: str) -> "Xml":
        return Xml(re.sub(r"^<(\w+)", rf'<\1 name="{name}"', self, count=1))


@dataclass
class Case:
    """A scene that isolates one thing."""

    name: str
    xml: str
    #: Samples per pixel of each program.
    spp: int = 64


def numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.9g}" for value in values)


def parameter(name: str, value: object) -> Xml:
    match value:
        case Xml():
            return value.named(name)
        case bool():
            tag, text = "boolean", str(value).lower()
        case int() | float() | str():
            tag, text = {int: "integer", float: "float", str: "string"}[type(value)], str(value)
        case tuple():
            tag, text = "rgb", numbers(value)
        case _:
            raise TypeError(f"{name}: {value!r}")
    return Xml(f'<{tag} name="{name}" value="{text}"/>')


def element(tag: str, kind: str, *nested: str, id: str = "", **params: object) -> Xml:
    head = f'<{tag} type="{kind}"' + (f' id="{id}"' if id else "")
    return Xml(f"{head}>{''.join(nested)}{''.join(parameter(*item) for item in params.items())}</{tag}>")


def value(tag: str, text: object) -> Xml:
    return Xml(f'<{tag} value="{text if isinstance(text, str | int | float) else numbers(text)}"/>')


integrator, sensor, film, rfilter, sampler, shape, bsdf, texture, emitter, spectrum = (
    partial(element, tag)
    for tag in ("integrator", "sensor", "film", "rfilter", "sampler", "shape", "bsdf", "texture", "emitter", "spectrum")
)
rgb, point, vector = (partial(value, tag) for tag in ("rgb", "point", "vector"))


def ref(id: str) -> Xml:
    return Xml(f'<ref id="{id}"/>')


def step(tag: str, **attributes: object) -> str:
    texts = {name: text if isinstance(text, str | int | float) else numbers(text) for name, text in attributes.items()}
    return f"<{tag} " + " ".join(f'{name}="{text}"' for name, text in texts.items()) + "/>"


move, turn, scale, matrix = (partial(step, tag) for tag in ("translate", "rotate", "scale", "matrix"))


def look(origin: Iterable[float], target: Iterable[float] = (0, 0, 0), up: Iterable[float] = (0, 1, 0)) -> str:
    return step("lookat", origin=origin, target=target, up=up)


def transform(*steps: str) -> Xml:
    return Xml(f"<transform>{''.join(steps)}</transform>")


def bitmap(filename: str, **params: object) -> Xml:
    return texture("bitmap", filename=filename, **params)


def checker(low: object = 0.1, high: object = 0.8, **params: object) -> Xml:
    return texture("checkerboard", color0=low, color1=high, **params)


def diffuse(reflectance: object = (0.5, 0.5, 0.5)) -> Xml:
    return bsdf("diffuse", reflectance=reflectance)


def picture(width: int = SIZE, height: int = SIZE, *nested: str, **params: object) -> Xml:
    """A film; a box filter unless another one is nested."""
    filters = () if any(part.startswith("<rfilter") for part in nested) else (rfilter("box"),)
    return film("hdrfilm", *nested, *filters, width=width, height=height, pixel_format="rgb", **params)


CAMERA = sensor("perspective", picture(), fov=35.0, to_world=transform(look((0, 1, 5))))
#: Sees x and y in [-1, 1] from z = 4.
FRONT = sensor("orthographic", picture(), to_world=transform(look((0, 0, 4))))
FLOOR = shape("rectangle", diffuse((0.4, 0.3, 0.2)), to_world=transform(scale(value=3), turn(x=1, angle=-90), move(y=-1.2)))
LAMP = shape("rectangle", emitter("area", radiance=(9.0, 8.0, 7.0)), to_world=transform(scale(value=1.2), look((-3, 3, 2))))
SKY = emitter("constant", radiance=(0.3, 0.35, 0.4))
WHITE = emitter("constant", radiance=(1.0, 1.0, 1.0))


def scene(*content: str, depth: int = 6, how: str = "path", version: str = "3.0.0", **limits: object) -> str:
    """A scene; an integrator of that depth unless one is in `content`."""
    if not any(part.startswith("<integrator") for part in content):
        content = (integrator(how, max_depth=depth, **limits), *content)
    return f'<scene version="{version}">\n' + "\n".join(content) + "\n</scene>\n"


def ball(material: str) -> str:
    """A sphere of a material above a floor, under a lamp and a sky."""
    return scene(CAMERA, FLOOR, LAMP, SKY, shape("sphere", material))


def patch(material: str, light: str = WHITE) -> str:
    """A square of a material fills the film. Under the white sky a diffuse one shows its reflectance."""
    return scene(FRONT, light, shape("rectangle", material), depth=2)


def tile(reflectance: object) -> str:
    return patch(diffuse(reflectance))


def body(*shapes: str) -> str:
    """Shapes above a floor, under a lamp and a sky."""
    return scene(CAMERA, FLOOR, LAMP, SKY, *shapes)


def lit(*emitters: str) -> str:
    """A floor, a wall and a sphere under emitters; without inter-reflection."""
    wall = shape("rectangle", diffuse((0.6, 0.6, 0.5)), to_world=transform(scale(value=3), move(z=-2)))
    thing = shape("sphere", diffuse((0.3, 0.5, 0.7)), radius=0.5, center=point((0.3, -0.5, 0)))
    return scene(CAMERA, FLOOR, wall, thing, *emitters, depth=2)


def label(params: dict[str, object]) -> str:
    """The parameters of a case as words."""

    def words(given: object) -> str:
        if isinstance(given, Xml) and given.startswith("<transform"):
            steps = re.findall(r"<(\w+) ([^/]*)/>", given)
            return " ".join(tag if tag == "lookat" else f"{tag}({text.replace(chr(34), '')})" for tag, text in steps)
        if isinstance(given, Xml):
            return " ".join(re.findall(r'(?:type|value)="([^"]*)"', given))
        return ",".join(f"{x:g}" for x in given) if isinstance(given, tuple) else str(given)

    return ", ".join(f"{name} {words(given)}" for name, given in params.items())


def each(name: str, make: Callable[..., str], rows: Iterable[dict[str, object]], spp: int = 64) -> Iterator[Case]:
    """A case for each row of parameters."""
    for row in rows:
        yield Case(f"{name} {label(row)}".strip(), make(**row), spp)


def named(name: str, make: Callable[[str], str], rows: dict[str, object], spp: int = 64) -> Iterator[Case]:
    """A case for each labelled value."""
    for words, given in rows.items():
        yield Case(f"{name} {words}", make(given), spp)
