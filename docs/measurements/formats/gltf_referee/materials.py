"""Cases of materials and their extensions."""

from collections.abc import Iterator

import numpy as np

from scenes import NEAREST, Case, File, Mesh, ball, matte, rewritten, shiny, shown, wall

GRAY = (0.5, 0.5, 0.5, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0, 1.0)


def chart(size: int = 4) -> np.ndarray:
    """Texels of different colors and opacities, not symmetric."""
    y, x = np.mgrid[:size, :size] / (size - 1)
    pixels = np.stack([0.2 + 0.8 * x, 0.9 - 0.7 * y, 0.3 + 0.6 * x * y, 0.15 + 0.7 * (0.6 * x + 0.4 * y)], -1)
    pixels[0, 0] = (1, 0.1, 0.1, 0.95)
    return np.round(255 * pixels).astype("u1")


def bumps(size: int = 8, scale: float = 1, turn: int = 0) -> np.ndarray:
    """A normal texture of a slanted wave. `turn`: 1 or -1 for slopes (x, y) that are (-y, x) or (y, x)."""
    y, x = np.mgrid[:size, :size] * (2 * np.pi / size)
    slopes = [scale * (0.45 * np.sin(x) + 0.2), scale * 0.3 * np.cos(y + x)]
    if turn:
        slopes = [-turn * slopes[1], slopes[0]]
    normal = np.stack([*slopes, np.ones_like(x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.round(127.5 * normal + 127.5).astype("u1")


def extension(name: str, **values: object) -> dict:
    return {f"KHR_materials_{name}": values}


def textured(name: str, make, pixels: np.ndarray, mesh: Mesh | None = None, light: str = "panels", sampler: dict = NEAREST) -> Case:
    """A case whose material refers to one texture."""
    file = File()
    info = {"index": file.texture(pixels, sampler)}
    return shown(name, make(info), mesh or wall(), light, file)


def colors() -> Iterator[Case]:
    """Base colors, and what is ignored."""
    for light in ("white", "panels"):
        yield shown(f"base color factor, {light}", matte(), wall(), light)
    yield textured("base color texture nearest", lambda t: matte(WHITE, t), chart()[..., :3])
    yield textured("base color texture times factor", lambda t: matte((0.5, 1.0, 0.3, 1.0), t), chart()[..., :3])
    yield textured("base color texture linear", lambda t: matte(WHITE, t), chart()[..., :3], sampler={"magFilter": 9729})
    yield textured("occlusion texture", lambda t: matte(occlusionTexture=t), chart()[..., :3])
    yield shown("no material factors", {"pbrMetallicRoughness": {}}, ball(), "white")


def vertex_colors() -> Iterator[Case]:
    values = np.array([(1, 0.2, 0.1, 0.9), (0.1, 0.8, 0.3, 0.4), (0.2, 0.3, 1, 0.6), (0.9, 0.9, 0.5, 0.2)])
    kinds = {"float": values.astype("f4"), "8 bits": np.round(255 * values).astype("u1"), "16 bits": np.round(65535 * values).astype("u2")}
    for name, colors in kinds.items():
        mesh = wall()
        mesh.attributes["COLOR_0"] = colors[:, :3]
        yield shown(f"vertex colors {name}", matte(WHITE), mesh)
    mesh.attributes["COLOR_0"] = kinds["float"]
    yield shown("vertex colors with alpha BLEND", matte(WHITE, alphaMode="BLEND"), mesh, "white")
    yield shown("vertex colors with alpha MASK", matte(WHITE, alphaMode="MASK"), mesh, "white")
    yield textured("vertex colors times texture and factor", lambda t: matte((0.7, 0.9, 0.8, 1.0), t), chart()[..., :3], mesh)


def metals() -> Iterator[Case]:
    """Roughness, metallic, and their texture. Its dielectric texels do not reflect specularly."""
    bare = extension("specular", specularFactor=0)
    for roughness in (0.0, 0.3, 0.6, 1.0):
        yield shown(f"metal roughness {roughness}", shiny(roughness, 1), ball())
        yield shown(f"dielectric roughness {roughness}", shiny(roughness), ball())
        yield shown(f"black dielectric roughness {roughness}", shiny(roughness, 0, BLACK), ball())
    yield shown("half metal", shiny(0.2, 0.5, extensions=bare), ball())
    pixels = np.zeros((4, 4, 3), "u1")
    pixels[..., 1] = np.linspace(25, 70, 16).reshape(4, 4)
    pixels[..., 2] = 255 * (np.indices((4, 4)).sum(0) % 2)
    for name, sampler in (("nearest", NEAREST), ("linear", {})):
        make = lambda t: shiny(1, 1, base={"metallicRoughnessTexture": t}, extensions=bare)  # noqa: E731
        yield textured(f"metallic roughness texture {name}", make, pixels, ball(), sampler=sampler)
    make = lambda t: shiny(0.7, 0.5, base={"metallicRoughnessTexture": t}, extensions=bare)  # noqa: E731
    yield textured("metallic roughness texture times factors", make, pixels, ball())


def normals() -> Iterator[Case]:
    """Normal textures. The tangents of files, which Blender does not read, are turned by 90 degrees."""

    def bumpy(name: str, pixels: np.ndarray, mesh: Mesh | None = None, material=matte, scale: float = 1, sampler: dict = NEAREST) -> Case:
        return textured(name, lambda t: material(normalTexture=t | {"scale": scale}), pixels, mesh, sampler=sampler)

    for name, sampler in (("nearest", NEAREST), ("linear", {})):
        yield bumpy(f"normal texture {name}", bumps(), sampler=sampler)
    small = bumpy("normal texture scale 0.4", bumps(), scale=0.4)
    yield small
    yield rewritten(small, bumpy("", bumps(scale=0.4)))
    yield bumpy("normal texture scale 2", bumps(), scale=2)
    yield bumpy("normal texture of a metal", bumps(), material=lambda **more: shiny(0.2, 1, **more))
    yield bumpy("normal texture of a ball", bumps(), ball())
    for sign in (1, -1):
        mesh = wall()
        mesh.attributes["TANGENT"] = np.array([(0, 1, 0, sign)] * 4, "f4")
        turned = bumpy(f"normal texture with tangents, w {sign}", bumps(), mesh)
        yield turned
        yield rewritten(turned, bumpy("", bumps(turn=sign)))


def emission() -> Iterator[Case]:
    strength = extension("emissive_strength", emissiveStrength=5)
    yield shown("emission factor", matte(BLACK, emissiveFactor=[0.9, 0.5, 0.1]), wall(), "none", spp=16)
    yield shown("emission strength", matte(BLACK, emissiveFactor=[0.9, 0.5, 0.1], extensions=strength), wall(), "none", spp=16)
    for name, sampler in (("nearest", NEAREST), ("linear", {})):
        make = lambda t: matte(BLACK, emissiveTexture=t, emissiveFactor=[1, 0.5, 1])  # noqa: E731
        yield textured(f"emission texture {name}", make, chart()[..., :3], light="white", sampler=sampler)
    for sides in (False, True):
        turned = {"rotation": [0, 1, 0, 0]}
        material = matte(GRAY, emissiveFactor=[0.9, 0.5, 0.1], doubleSided=sides)
        yield shown(f"emission of a back face, doubleSided {sides}", material, wall(), "white", node=turned)
    unlit = {"KHR_materials_unlit": {}}
    yield shown("unlit", {"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1]}, "extensions": unlit}, wall(), "panels")


def opacity() -> Iterator[Case]:
    for alpha, cutoff in ((0.6, None), (0.4, None), (0.4, 0.3), (0.5, 0.5)):
        more = {} if cutoff is None else {"alphaCutoff": cutoff}
        name = f"alpha MASK factor {alpha}, cutoff {cutoff}"
        yield shown(name, matte((0.8, 0.5, 0.2, alpha), alphaMode="MASK", **more), wall(), "white")
    yield shown("alpha BLEND factor", matte((0.8, 0.5, 0.2, 0.4), alphaMode="BLEND"), wall(), "white")
    yield shown("alpha OPAQUE factor", matte((0.8, 0.5, 0.2, 0.4)), wall(), "white")
    for mode in ("MASK", "BLEND", "OPAQUE"):
        for name, sampler in (("nearest", NEAREST), ("linear", {})):
            make = lambda t, mode=mode: matte((1, 1, 1, 0.9), t, alphaMode=mode)  # noqa: E731
            pixels = chart()
            pixels[..., :3] = 0
            yield textured(f"alpha {mode} texture {name}", make, pixels, light="white", sampler=sampler)
    make = lambda t: matte(WHITE, t, alphaMode="MASK", alphaCutoff=0.3)  # noqa: E731
    yield textured("alpha MASK texture, cutoff 0.3", make, chart(), light="white")
    glowing = matte((0.5, 0.5, 0.5, 0.4), alphaMode="BLEND", emissiveFactor=[0.9, 0.5, 0.1])
    yield shown("alpha BLEND of emission", glowing, wall(), "white")
    for sides in (False, True):
        for name, material in (("matte", matte(doubleSided=sides)), ("metal", shiny(0.3, 1, doubleSided=sides))):
            turned = {"rotation": [0.3, 0.9, 0.1, 0.2]}
            yield shown(f"back face of {name}, doubleSided {sides}", material, wall(), node=turned)


def interfaces() -> Iterator[Case]:
    """Indices of refraction and specular parameters, of black dielectrics, whose reflection alone is seen."""

    def black(**extensions: object) -> dict:
        return shiny(0.3, 0, BLACK, extensions=extensions)

    for ior in (1.0, 1.2, 1.5, 2.0, 0):
        yield shown(f"ior {ior}", black(**extension("ior", ior=ior)), ball())
    for factor in (0, 0.5):
        yield shown(f"specular factor {factor}", black(**extension("specular", specularFactor=factor)), ball())
    yield shown("specular color factor", black(**extension("specular", specularColorFactor=[0.9, 0.4, 0.1])), ball())
    both = extension("specular", specularFactor=0.5, specularColorFactor=[0.9, 0.4, 0.1])
    yield shown("specular color and factor", black(**both), ball())
    dense = extension("ior", ior=1.8) | both
    yield shown("specular color, factor and ior", black(**dense), ball())
    make = lambda t: black(**extension("specular", specularTexture=t))  # noqa: E731
    yield textured("specular texture", make, chart(), ball())
    make = lambda t: black(**extension("specular", specularColorTexture=t))  # noqa: E731
    yield textured("specular color texture", make, chart()[..., :3], ball())
    yield shown("specular color of a metal", shiny(0.3, 1, extensions=both), ball())


def coats() -> Iterator[Case]:
    def coated(base: dict | None = None, **values: object) -> dict:
        return (base or matte(BLACK)) | {"extensions": {"KHR_materials_specular": {"specularFactor": 0}} | extension("clearcoat", **values)}

    yield shown("clearcoat over black", coated(clearcoatFactor=1, clearcoatRoughnessFactor=0.3), ball())
    yield shown("clearcoat rough over black", coated(clearcoatFactor=1, clearcoatRoughnessFactor=0.6), ball())
    yield shown("clearcoat smooth over black", coated(clearcoatFactor=1), ball())
    yield shown("clearcoat factor 0.5 over black", coated(clearcoatFactor=0.5, clearcoatRoughnessFactor=0.3), ball())
    yield shown("clearcoat over matte", coated(matte(), clearcoatFactor=1, clearcoatRoughnessFactor=0.3), ball())
    yield shown("clearcoat over metal", coated(shiny(0.5, 1), clearcoatFactor=1, clearcoatRoughnessFactor=0.2), ball())
    make = lambda t: coated(clearcoatFactor=1, clearcoatTexture=t, clearcoatRoughnessFactor=0.3)  # noqa: E731
    yield textured("clearcoat texture", make, chart()[..., :3], ball())
    make = lambda t: coated(clearcoatFactor=1, clearcoatRoughnessFactor=0.6, clearcoatRoughnessTexture=t)  # noqa: E731
    yield textured("clearcoat roughness texture", make, chart()[..., :3], ball())
    make = lambda t: coated(clearcoatFactor=1, clearcoatRoughnessFactor=0.3, clearcoatNormalTexture=t)  # noqa: E731
    yield textured("clearcoat normal texture over black", make, bumps())
    make = lambda t: coated(matte(normalTexture=t), clearcoatFactor=1, clearcoatRoughnessFactor=0.3)  # noqa: E731
    yield textured("clearcoat without the bumps of its base", make, bumps())


def stretched(roughness: float, strength: float, degrees: float) -> dict:
    values = {"anisotropyStrength": strength, "anisotropyRotation": float(np.radians(degrees))}
    return shiny(roughness, 1, extensions=extension("anisotropy", **values))


def lobes() -> Iterator[Case]:
    """Sheen, thin films, anisotropy."""
    sheen = extension("sheen", sheenColorFactor=[0.9, 0.7, 0.5], sheenRoughnessFactor=0.5)
    yield shown("sheen over black", matte(BLACK, extensions=sheen), ball(), "white")
    yield shown("sheen over matte", matte(extensions=sheen), ball(), "white")
    film = extension("iridescence", iridescenceFactor=1, iridescenceIor=1.8, iridescenceThicknessMaximum=500)
    yield shown("iridescence of metal", shiny(0.3, 1, extensions=film), ball())
    yield shown("iridescence of dielectric", shiny(0.3, 0, BLACK, extensions=film), ball())
    for degrees in (0, 90, 45):
        case = shown(f"anisotropy rotation {degrees}", stretched(0.2, 0.3, degrees), ball())
        yield case
        # The aspect ratio of Cycles is sqrt(1 - 0.9 anisotropy), and its alphas are those of the roughness over and times it.
        along = 0.04 + 0.96 * 0.3**2
        same = stretched((0.04 * along) ** 0.25, (1 - 0.04 / along) / 0.9, degrees)
        if degrees != 45:
            yield rewritten(case, shown("", same, ball()))
    make = lambda t: shiny(0.3, 1, extensions=extension("anisotropy", anisotropyStrength=1, anisotropyTexture=t))  # noqa: E731
    pixels = np.full((2, 2, 3), (255, 128, 150), "u1")
    pixels[0, 0, 2] = pixels[1, 1, 2] = 60
    yield textured("anisotropy texture of strengths", make, pixels, ball())


def glass() -> Iterator[Case]:
    """Panes and bodies, before stripes of gray."""
    thin = extension("transmission", transmissionFactor=1)
    solid = thin | extension("volume", thicknessFactor=1)
    color = (0.6, 0.8, 0.9, 1.0)

    def seen(name: str, roughness: float, extensions: dict, color: tuple = WHITE, mesh: Mesh | None = None) -> Case:
        return shown(f"transmission {name}", shiny(roughness, 0, color, extensions=extensions), mesh or ball(), "white", backdrop=True)

    for roughness in (0.0, 0.3):
        yield seen(f"solid roughness {roughness}", roughness, solid)
        yield seen(f"pane roughness {roughness}", roughness, thin, WHITE, wall())
    for name, node in (("front", {}), ("back", {"node": {"rotation": [0, 1, 0, 0]}})):
        yield shown(f"transmission pane in white, {name}", shiny(0.3, 0, WHITE, extensions=thin), wall(), "white", **node)
    yield seen("thin ball", 0, thin)
    yield seen("solid, color", 0, solid, color)
    yield seen("pane, color", 0, thin, color, wall())
    yield seen("solid, ior 1.2", 0, solid | extension("ior", ior=1.2))
    yield seen("0.5 of a black base", 0, solid | extension("transmission", transmissionFactor=0.5), BLACK)
    yield seen("0.5", 0, solid | extension("transmission", transmissionFactor=0.5), color)
    hue = np.array([0.5, 0.7, 0.9])
    absorbing = [
        extension("volume", thicknessFactor=1, attenuationDistance=1.5, attenuationColor=c.tolist()) for c in (hue, 1 + np.log(hue))
    ]
    first, second = (seen("absorbing", 0, thin | volume) for volume in absorbing)
    yield first
    # Blender's importer makes 1 - color an absorption coefficient.
    yield rewritten(first, second)
    dispersing = shiny(0, 0, WHITE, extensions=solid | extension("dispersion", dispersion=10))
    yield shown("transmission with dispersion", dispersing, ball())
    make = lambda t: shiny(0, 0, extensions=solid | extension("transmission", transmissionFactor=1, transmissionTexture=t))  # noqa: E731
    yield textured("transmission texture", make, chart()[..., :3], ball(), "white")
    scattered = extension("diffuse_transmission", diffuseTransmissionFactor=0.5, diffuseTransmissionColorFactor=[0.9, 0.6, 0.3])
    yield shown("diffuse transmission", matte(extensions=scattered), wall(), "white")


def all_cases() -> Iterator[Case]:
    for family in (colors, vertex_colors, metals, normals, emission, opacity, interfaces, coats, lobes, glass):
        yield from family()
