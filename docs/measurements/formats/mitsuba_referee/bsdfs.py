"""Cases of bsdfs, and of their nesting."""

from collections.abc import Iterator

from notation import (
    CAMERA,
    FLOOR,
    FRONT,
    LAMP,
    SKY,
    Case,
    Xml,
    ball,
    bitmap,
    bsdf,
    checker,
    diffuse,
    each,
    emitter,
    look,
    named,
    patch,
    scene,
    shape,
    transform,
    turn,
)

METALS = """a-C Ag Al AlAs AlAs_palik AlSb AlSb_palik Au Be Be_palik Cr CsI CsI_palik Cu Cu_palik Cu2O Cu2O_palik CuO CuO_palik d-C
d-C_palik Hg Hg_palik HgTe HgTe_palik Ir Ir_palik K K_palik Li Li_palik MgO MgO_palik Mo Mo_palik Na_palik Nb Nb_palik Ni_palik Rh
Rh_palik Se Se_palik Se-e Se-e_palik SiC SiC_palik SnTe SnTe_palik Ta Ta_palik Te Te_palik Te-e Te-e_palik ThF4 ThF4_palik TiC
TiC_palik TiN TiN_palik TiO2 TiO2_palik TiO2-e TiO2-e_palik V_palik VC VC_palik VN VN_palik W none""".split()
DIELECTRICS = [
    "vacuum",
    "air",
    "water",
    "ethanol",
    "glycerol",
    "bromine",
    "water ice",
    "pyrex",
    "polypropylene",
    "sodium chloride",
    "amber",
    "pet",
    "diamond",
]
RED = (0.8, 0.2, 0.1)
COPPER = {"eta": (0.2, 0.92, 1.1), "k": (3.9, 2.45, 2.14)}
ROUGHNESS = [
    *({"alpha": alpha, "distribution": kind} for kind in ("beckmann", "ggx") for alpha in (0.05, 0.25, 0.7)),
    *({"alpha_u": 0.05, "alpha_v": 0.4, "distribution": kind} for kind in ("beckmann", "ggx")),
    {"alpha": 0.3, "sample_visible": False},
    {"alpha": checker(0.1, 0.5)},
]
TINTS = [{"specular_reflectance": RED}, {"specular_transmittance": RED}]
INDICES = [{}, {"int_ior": 1.1}, {"int_ior": 2.0}, {"int_ior": "diamond", "ext_ior": "water"}, {"int_ior": 1.0, "ext_ior": 1.5}]


def of(kind: str, **fixed: object):
    """The ball of a bsdf with further parameters."""
    return lambda **params: ball(bsdf(kind, **fixed, **params))


def metal_tile(name: str) -> str:
    return patch(bsdf("conductor", material=name))


def models() -> Iterator[Case]:
    """Opaque and transparent models."""
    yield from each("diffuse", of("diffuse"), [{}, {"reflectance": RED}, {"reflectance": bitmap("chart.png")}])
    yield from named("conductor material", metal_tile, {name: name for name in METALS}, spp=4)
    coefficients = [{}, COPPER, {"eta": 1.5, "k": 0.8}, {"material": "Au", "specular_reflectance": (0.9, 0.5, 0.2)}]
    coefficients += [{"material": "Ag", "specular_reflectance": bitmap("chart.png")}, {"eta": checker(0.3, 1.2), "k": checker(2.0, 4.0)}]
    yield from each("conductor", of("conductor"), coefficients)
    yield from each("roughconductor", of("roughconductor", material="Au"), ROUGHNESS)
    yield from each("roughconductor", of("roughconductor", alpha=0.3), coefficients)
    yield from each("dielectric", of("dielectric"), INDICES + TINTS + [{"specular_transmittance": bitmap("chart.png")}])
    bare = {name: patch(bsdf("roughplastic", int_ior=name, diffuse_reflectance=(0.0, 0.0, 0.0), alpha=0.2)) for name in DIELECTRICS}
    yield from named("dielectric name", str, bare, spp=128)
    yield from each("thindielectric", of("thindielectric"), INDICES[:4] + TINTS)
    yield from each("roughdielectric", of("roughdielectric"), ROUGHNESS + INDICES + TINTS)


def plastics() -> Iterator[Case]:
    looks = [
        {},
        {"diffuse_reflectance": RED},
        {"diffuse_reflectance": RED, "nonlinear": True},
        {"int_ior": 1.1},
        {"int_ior": 2.2, "ext_ior": 1.2},
        {"int_ior": "water"},
        {"specular_reflectance": RED},
        {"diffuse_reflectance": bitmap("chart.png"), "nonlinear": True},
        {"specular_reflectance": bitmap("chart.png"), "diffuse_reflectance": (0.0, 0.0, 0.0)},
    ]
    yield from each("plastic", of("plastic"), looks)
    yield from each("roughplastic", of("roughplastic"), looks)
    rough = [{"alpha": a, "distribution": d} for d in ("beckmann", "ggx") for a in (0.05, 0.3, 0.7)] + [
        {"alpha": 0.3, "sample_visible": False}
    ]
    yield from each("roughplastic", of("roughplastic"), rough)


def principled() -> Iterator[Case]:
    rows = [
        {},
        {"base_color": RED},
        {"base_color": bitmap("chart.png")},
        {"roughness": 0.1},
        {"roughness": 0.9},
        {"roughness": checker(0.2, 0.8)},
        {"metallic": 1.0},
        {"metallic": 0.5, "roughness": 0.3},
        {"metallic": checker(0.0, 1.0)},
        {"anisotropic": 0.9, "metallic": 1.0},
        {"anisotropic": 0.5, "roughness": 0.3},
        {"spec_trans": 1.0, "roughness": 0.3},
        {"spec_trans": 0.5},
        {"spec_trans": 0.7, "eta": 1.8},
        {"spec_trans": checker(0.0, 1.0)},
        {"eta": 1.2},
        {"eta": 2.0, "roughness": 0.2},
        {"specular": 0.0},
        {"specular": 1.0, "roughness": 0.2},
        {"spec_tint": 1.0, "roughness": 0.2},
        {"spec_tint": 0.5, "metallic": 0.5},
        {"sheen": 1.0},
        {"sheen": 1.0, "sheen_tint": 1.0},
        {"flatness": 1.0},
        {"flatness": 0.5, "roughness": 0.8},
        {"clearcoat": 1.0},
        {"clearcoat": 1.0, "clearcoat_gloss": 1.0},
        {"clearcoat": 0.5, "clearcoat_gloss": 0.5, "metallic": 1.0},
        {"clearcoat": checker(0.0, 1.0), "clearcoat_gloss": 0.9},
        {"main_specular_sampling_rate": 0.3, "clearcoat": 0.5, "clearcoat_sampling_rate": 2.0, "diffuse_reflectance_sampling_rate": 0.7},
    ]
    yield from each("principled", lambda **p: ball(bsdf("principled", **({"base_color": RED} | p))), rows)
    thin = [
        {},
        {"base_color": bitmap("chart.png")},
        {"roughness": 0.15},
        {"roughness": 0.9},
        {"anisotropic": 0.9, "spec_trans": 0.5},
        {"spec_trans": 1.0},
        {"spec_trans": 0.5, "roughness": 0.3},
        {"eta": 1.2, "spec_trans": 0.5},
        {"eta": 2.0},
        {"spec_tint": 1.0, "spec_trans": 0.8},
        {"sheen": 1.0},
        {"sheen": 1.0, "sheen_tint": 1.0},
        {"flatness": 1.0},
        {"diff_trans": 0.6},
        {"diff_trans": 2.0},
        {"diff_trans": 1.0, "flatness": 0.5},
        {"diff_trans": checker(0.0, 2.0)},
        {"spec_trans": checker(0.0, 1.0)},
    ]
    yield from each("principledthin", lambda **p: ball(bsdf("principledthin", **({"base_color": RED} | p))), thin)


GREEN, PLASTIC, GLASS = diffuse((0.1, 0.7, 0.2)), bsdf("roughplastic", alpha=0.2, diffuse_reflectance=RED), bsdf("dielectric")


def from_behind(material: str) -> str:
    """The back of a square."""
    return scene(CAMERA, FLOOR, LAMP, SKY, shape("rectangle", material, to_world=transform(turn(y=1, angle=180))))


def nested() -> Iterator[Case]:
    def mask(opacity: object, inside: Xml = PLASTIC) -> Xml:
        return bsdf("mask", inside, opacity=opacity)

    def blend(weight: object, first: Xml = GREEN, second: Xml = PLASTIC) -> Xml:
        return bsdf("blendbsdf", first, second, weight=weight)

    def twosided(*sides: Xml) -> Xml:
        return bsdf("twosided", *sides)

    materials = {
        "mask default": bsdf("mask", PLASTIC),
        "mask 0": mask(0.0),
        "mask 0.3": mask(0.3),
        "mask 1": mask(1.0),
        "mask checkerboard": mask(checker(0.0, 1.0)),
        "mask of a bitmap": mask(bitmap("gray.png", raw=True)),
        "mask of a coloured bitmap": mask(bitmap("chart.png", raw=True)),
        "mask of glass": mask(0.5, GLASS),
        "mask of a twosided": mask(0.5, twosided(PLASTIC)),
        "mask rgb": mask((0.4, 0.4, 0.4)),
        "blend 0": blend(0.0),
        "blend 0.3": blend(0.3),
        "blend 1": blend(1.0),
        "blend checkerboard": blend(checker(0.0, 1.0)),
        "blend of a bitmap": blend(bitmap("gray.png", raw=True)),
        "blend of glass": blend(0.5, GLASS, GREEN),
        "blend of a mask": blend(0.4, mask(0.5), GREEN),
        "blend of blends": blend(0.5, blend(0.2), blend(0.7, PLASTIC, bsdf("conductor"))),
        "blend of null": blend(0.25, bsdf("null"), GREEN),
        "blend of coloured bitmap": blend(bitmap("chart.png", raw=True)),
        "twosided": twosided(PLASTIC),
        "twosided two": twosided(PLASTIC, GREEN),
        "twosided blend": twosided(blend(0.4)),
        "null": bsdf("null"),
        "bumpmap of a twosided": bsdf("bumpmap", bitmap("bumps.png", raw=True), twosided(PLASTIC), scale=0.2),
    }
    yield from named("nested", ball, materials)
    sides = {"diffuse": GREEN, "plastic": PLASTIC, "twosided": twosided(GREEN), "twosided two": twosided(PLASTIC, GREEN), "glass": GLASS}
    sides |= {
        "conductor": bsdf("roughconductor", material="Cu"),
        "principled": bsdf("principled", base_color=RED),
        "mask": mask(0.6),
        "blend": blend(0.5, GREEN, GLASS),
    }
    sides |= {"bumpmap": twosided(bumpmap("bumps.png", 0.3)), "normalmap": twosided(normalmap("normals.png"))}
    yield from named("from behind", from_behind, sides)


def bumpmap(file: str, height: float, inside: Xml = PLASTIC, **params: object) -> Xml:
    return bsdf("bumpmap", bitmap(file, raw=True, **params), inside, scale=height)


def normalmap(file: str, inside: Xml = PLASTIC, **params: object) -> Xml:
    return bsdf("normalmap", inside, normalmap=bitmap(file, raw=True, **params))


def slanted(material: str) -> str:
    """A square under a lamp from one side: what tilts its normal changes the mean."""
    lamp = shape("rectangle", emitter("area", radiance=(9.0, 8.0, 7.0)), to_world=transform(look((-3, 1.5, 2.5))))
    return scene(FRONT, lamp, shape("rectangle", material), depth=2)


def shaped() -> Iterator[Case]:
    """Bumps and normal maps."""
    turned = transform(turn(z=1, angle=30))
    materials = {
        "bumpmap": bumpmap("bumps.png", 0.1),
        "bumpmap high": bumpmap("bumps.png", 0.5, GREEN),
        "bumpmap negative": bumpmap("bumps.exr", -0.2),
        "bumpmap nearest": bumpmap("bumps.png", 0.2, filter_type="nearest"),
        "bumpmap to_uv": bumpmap("bumps.png", 0.1, to_uv=turned),
        "bumpmap conductor": bumpmap("bumps.exr", 0.1, bsdf("roughconductor", alpha=0.3)),
        "bumpmap flags": bsdf("bumpmap", bitmap("bumps.exr"), PLASTIC, scale=0.3, flip_invalid_normals=False, use_shadowing_function=False),
        "bumpmap checkerboard": bsdf("bumpmap", checker(0.0, 1.0), PLASTIC, scale=0.1),
        "normalmap": normalmap("normals.png"),
        "normalmap exr": normalmap("normals.exr"),
        "normalmap diffuse": normalmap("normals.png", GREEN),
        "normalmap to_uv": normalmap("normals.png", to_uv=turned),
        "normalmap conductor": normalmap("normals.png", bsdf("roughconductor", alpha=0.3)),
        "normalmap not raw": bsdf("normalmap", GREEN, normalmap=bitmap("normals.png")),
        "normalmap flags": bsdf(
            "normalmap", PLASTIC, normalmap=bitmap("normals.png", raw=True), flip_invalid_normals=False, use_shadowing_function=False
        ),
        "normalmap of a bumpmap": normalmap("normals.png", bumpmap("bumps.png", 0.1)),
        "normalmap in a blend": bsdf("blendbsdf", normalmap("normals.png"), GREEN, weight=0.5),
    }
    yield from named("slanted", slanted, materials)
    yield from named("ball", ball, {"bumpmap": bumpmap("bumps.png", 0.2), "normalmap": normalmap("normals.png")})


def others() -> Iterator[Case]:
    """Models without a counterpart of ours."""
    rows = {
        "polarizer": bsdf("polarizer"),
        "retarder": bsdf("retarder"),
        "circular": bsdf("circular"),
        "pplastic": bsdf("pplastic"),
        "hair": bsdf("hair"),
    }
    yield from named("bsdf", ball, rows)


def all_cases() -> Iterator[Case]:
    for cases in (models, plastics, principled, nested, shaped, others):
        yield from cases()
