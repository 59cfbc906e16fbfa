"""Cases of textures and spectra."""

from collections.abc import Iterator

from notation import (
    FRONT,
    Case,
    Xml,
    bitmap,
    bsdf,
    checker,
    diffuse,
    each,
    emitter,
    lit,
    matrix,
    move,
    named,
    patch,
    rgb,
    scale,
    scene,
    shape,
    spectrum,
    texture,
    tile,
    transform,
    turn,
    vector,
)

TO_UV = {
    "scale": transform(scale(value=3)),
    "scale u": transform(scale(x=3, y=1)),
    "scale below 1": transform(scale(x=0.3, y=0.6)),
    "translate": transform(move(x=0.3, y=0.1)),
    "rotate": transform(turn(z=1, angle=30)),
    "mirrored": transform(scale(x=-1, y=1)),
    "translate then scale": transform(move(x=0.25), scale(value=2)),
    "scale then translate": transform(scale(value=2), move(x=0.25)),
    "rotate then scale": transform(turn(z=1, angle=40), scale(x=2, y=0.7)),
    "matrix 4x4": transform(matrix(value="1.2 0.4 0 0.3  -0.2 0.8 0 0.1  0 0 1 0  0 0 0 1")),
    "matrix 3x3": transform(matrix(value="1.2 0.4 0.3  -0.2 0.8 0.1  0 0 1")),
}


def bitmaps() -> Iterator[Case]:
    files = [
        "chart.png",
        "wide.png",
        "deep.png",
        "gray.png",
        "alpha.png",
        "gray_alpha.png",
        "texel.png",
        "chart.jpg",
        "chart.tga",
        "version1.tga",
        "chart.bmp",
    ]
    files += ["chart.exr", "half.exr", "gray.exr", "alpha.exr", "chart.hdr", "chart.pfm", "gray.pfm"]
    yield from each("bitmap", lambda **p: tile(bitmap(**p)), ({"filename": name} for name in files), spp=32)
    options = [{"raw": True}, {"filter_type": "nearest"}, {"format": "fp16"}, {"format": "auto"}, {"accel": False}]
    yield from each("bitmap", lambda **p: tile(bitmap("chart.png", **p)), options, spp=32)
    yield from each("bitmap gray", lambda **p: tile(bitmap("gray.png", **p)), [{"raw": True}, {"filter_type": "nearest"}], spp=32)
    outside = transform(scale(value=3), move(x=-0.8, y=-1.1))
    for mode in ("repeat", "mirror", "clamp"):
        for kind in ("bilinear", "nearest"):
            yield Case(f"bitmap {mode} {kind}", tile(bitmap("chart.png", wrap_mode=mode, filter_type=kind, to_uv=outside)), 32)
    yield from named("bitmap to_uv", lambda to_uv: tile(bitmap("wide.png", to_uv=to_uv)), TO_UV, spp=32)
    yield from named("checkerboard to_uv", lambda to_uv: tile(checker((0.9, 0.2, 0.1), (0.1, 0.3, 0.6), to_uv=to_uv)), TO_UV, spp=32)
    yield from each(
        "checkerboard",
        lambda **p: tile(texture("checkerboard", **p)),
        [{}, {"color0": (0.9, 0.1, 0.1)}, {"color1": 0.7}, {"color0": bitmap("chart.png")}],
        spp=32,
    )


def uses() -> Iterator[Case]:
    """A texture where a number, a color or an emission is expected."""
    raw, srgb = bitmap("chart.png", raw=True), bitmap("chart.png")
    materials = {
        "coloured alpha": bsdf("roughconductor", alpha=raw),
        "coloured alpha, sRGB": bsdf("roughconductor", alpha=srgb),
        "coloured weight": bsdf("blendbsdf", diffuse(), bsdf("conductor"), weight=srgb),
        "gray weight, sRGB": bsdf("blendbsdf", diffuse(), bsdf("conductor"), weight=bitmap("gray.png")),
        "coloured roughness": bsdf("principled", roughness=srgb, metallic=1.0),
        "exr alpha": bsdf("roughconductor", alpha=bitmap("chart.exr")),
        "alpha of rgb": bsdf("principled", roughness=(0.2, 0.4, 0.9)),
    }
    yield from named("texture as", patch, materials)
    lamps = {"bitmap": srgb, "raw": raw, "exr": bitmap("chart.exr"), "checkerboard": checker((0.9, 0.6, 0.3), 0.2)}
    for words, radiance in lamps.items():
        yield Case(f"texture as radiance {words}", scene(FRONT, shape("rectangle", emitter("area", radiance=radiance)), depth=1), 32)
    volumes = {
        "constvolume": Xml('<volume type="constvolume"><rgb name="value" value="0.8, 0.3, 0.2"/></volume>'),
        "gridvolume": Xml('<volume type="gridvolume"><string name="filename" value="grid.vol"/></volume>'),
    }
    yield from named("volume texture", lambda volume: tile(texture("volume", volume=volume)), volumes, spp=32)


SPECTRA = {
    "one number": rgb(0.4),
    "three numbers": rgb((0.2, 0.5, 0.7)),
    "hexadecimal": rgb("#3f8fcf"),
    "white space": rgb("0.2  0.5 0.7"),
    "number": 0.4,
    "spectrum": Xml('<spectrum value="0.4"/>'),
    "pairs": Xml('<spectrum value="400:0.1, 500:0.3, 600:0.8, 700:0.6"/>'),
    "pairs of a part": Xml('<spectrum value="500:0.2 550:0.9 600:0.4"/>'),
    "file": Xml('<spectrum filename="band.spd"/>'),
    "file of a part": Xml('<spectrum filename="narrow.spd"/>'),
    "uniform": spectrum("uniform", value=0.4),
    "uniform default": spectrum("uniform"),
    "d65": spectrum("d65"),
    "d65 scale": spectrum("d65", scale=0.5),
    "d65 color": spectrum("d65", color=(0.2, 0.5, 0.7)),
    "regular": spectrum("regular", wavelength_min=400.0, wavelength_max=700.0, values="0.1, 0.3, 0.8, 0.6"),
    "irregular": spectrum("irregular", wavelengths="400, 500, 550, 620, 700", values="0.1, 0.3, 0.7, 0.8, 0.2"),
    "blackbody": spectrum("blackbody", temperature=4000.0),
    "blackbody hot": spectrum("blackbody", temperature=9000.0),
    "rawconstant": spectrum("rawconstant", value=0.4),
    "rawconstant three": spectrum("rawconstant", value=vector((0.2, 0.5, 0.7))),
    "srgb": spectrum("srgb", color=(0.2, 0.5, 0.7)),
    "texture tag": texture("uniform", value=0.4),
}
#: These are no reflectances.
EMISSIONS = {"blackbody", "blackbody hot"}


def spectra() -> Iterator[Case]:
    reflectances = {words: given for words, given in SPECTRA.items() if words not in EMISSIONS}
    yield from named("reflectance", tile, reflectances, spp=4)
    yield from named(
        "area radiance", lambda given: scene(FRONT, shape("rectangle", emitter("area", radiance=given)), depth=1), SPECTRA, spp=4
    )
    sky = {words: given for words, given in SPECTRA.items() if not words.startswith("d65")}
    yield from named("constant radiance", lambda given: patch(diffuse((0.8, 0.8, 0.8)), emitter("constant", radiance=given)), sky, spp=16)
    few = {
        words: SPECTRA[words]
        for words in ("three numbers", "number", "spectrum", "pairs", "uniform", "d65", "blackbody", "regular", "rawconstant")
    }
    yield from named(
        "point intensity", lambda given: lit(emitter("point", intensity=given, position=Xml('<point value="-1, 2, 2"/>'))), few, spp=16
    )
    yield from named(
        "directional irradiance", lambda given: lit(emitter("directional", irradiance=given, direction=vector((1, -1, -1)))), few, spp=16
    )
    some = {words: SPECTRA[words] for words in ("three numbers", "number", "spectrum", "pairs", "file", "uniform", "regular", "irregular")}
    yield from named("conductor k", lambda given: patch(bsdf("conductor", eta=0.5, k=given)), some, spp=4)
    brighter = {
        "rgb": rgb((3.0, 2.0, 1.0)),
        "spectrum": Xml('<spectrum value="3"/>'),
        "uniform": spectrum("uniform", value=3.0),
        "pairs": Xml('<spectrum value="400:1, 550:4, 700:2"/>'),
    }
    yield from named(
        "bright radiance", lambda given: scene(FRONT, shape("rectangle", emitter("area", radiance=given)), depth=1), brighter, spp=4
    )


def all_cases() -> Iterator[Case]:
    for cases in (bitmaps, uses, spectra):
        yield from cases()
