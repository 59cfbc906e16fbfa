"""The cases of scene_faults.py: each a scene that breaks renderers, and what a renderer should make of it."""

import math

from hard_scenes import (
    LAMP, VIEW, WALLS, Case, Space, bsdf, diffuse, emitter, glossy, grid, lamp, mesh, number, obj, pfm, ply, rgb, room, scene,
    steps, things, two_sided, walls, with_floor,
)  # fmt: skip

HERE = Space()
#: Light tracing sees neither specular surfaces nor the environment.
MIRRORS = ("light-trace",)
PHOTONS = ("light-trace", "photon-map", "rich-vpl", "rich-lightcuts")


def scales() -> list[Case]:
    """The same room in other units, and at other places."""
    cases = [Case("room", room())]
    cases += [Case(f"room, scale {s:g}", room(Space(s)), same_as="room") for s in (1e-6, 1e-4, 1e4, 1e6)]
    far = {"1 km along x": (1e3, 0, 0), "10 km along x": (1e4, 0, 0), "10 km along each axis": (1e4, -1e4, 1e4)}
    cases += [Case(f"room, {name}", room(Space(1.0, shift)), same_as="room") for name, shift in far.items()]
    too_far = "coordinates have steps of 8 mm"
    cases += [Case("room, 100 km along x", room(Space(1.0, (1e5, 0, 0))), same_as="room", beyond=too_far)]
    cases += [Case("room, scale 1e-3, 10 m away", room(Space(1e-3, (10, 0, 0))), same_as="room")]
    cases += [Case("room, scale 1e6, 1e10 away", room(Space(1e6, (1e10, 0, 0))), same_as="room")]
    point = lambda s: f'<emitter type="point"><point name="position" value="{Space(s).point(0, 1.7, 0)}"/>{rgb("intensity", 4 * s * s)}</emitter>'  # noqa: E731
    cases += [Case("room, point light", room(lamp=point(1)))]
    cases += [Case(f"room, point light, scale {s:g}", room(Space(s), lamp=point(s)), same_as="room, point light") for s in (1e-6, 1e6)]
    return cases


def meshes() -> list[Case]:
    """Degenerate and repeated triangles, bad normals."""
    corners, triangles = grid()
    flat = [*triangles, (0, 0, 0), (0, 0, 1), (5, 5, 9), (0, 1, 2), (0, 40, 80), (3, 12, 21)]
    near = [*corners, (0, 0, 0), (1e-30, 0, 0), (0, 0, 1e-30), (1e-42, 1e-42, 0)]
    tiny = [*triangles, *[(81 + a, 81 + b, 81 + c) for a, b, c in ((0, 1, 2), (1, 2, 3), (0, 2, 3))]]
    needle = [*corners, (-1, 0, 1), (1, 0, 1), (0, 0, 1 - 1e-7)]
    up, down, none = [(0, 1, 0)] * 81, [(0, -1, 0)] * 81, [(0, 0, 0)] * 81
    found = []

    def add(name: str, file: str, data: bytes, same_as: str = "", **more) -> None:
        xml, files = with_floor(file, data, material=more.pop("material", ""))
        found.append(Case(name, xml, files, same_as=same_as, **more))

    found.append(Case("room, two-sided floor", room(walls=walls(HERE, {"floor": two_sided(glossy(0.3, "roughplastic"))})), same_as="room"))
    add("floor as mesh", "floor.obj", obj(corners, triangles), same_as="room")
    add("triangles without area", "floor.obj", obj(corners, flat), same_as="room")
    add("triangles of 1e-30 m", "floor.obj", obj(near, tiny), same_as="room")
    add("needle of 2 m by 1e-7 m", "floor.obj", obj(needle, [*triangles, (81, 82, 83)]), same_as="room")
    add("every triangle twice", "floor.obj", obj(corners, triangles * 2), same_as="room")
    add("every triangle 100 times", "floor.obj", obj(corners, triangles * 100), same_as="room")
    add("every triangle also reversed, two-sided", "floor.obj", obj(corners, triangles + [(a, c, b) for a, b, c in triangles]),
        same_as="room, two-sided floor", material=two_sided(glossy(0.3, "roughplastic")),
        beyond="lights on both copies share the light", beyond_for=("rich-vpl", "rich-lightcuts"))  # fmt: skip
    add("vertex normals", "floor.ply", ply(corners, triangles, up), same_as="room")
    add("vertex normals of length 0", "floor.ply", ply(corners, triangles, none), same_as="room",
        no_mitsuba="makes normals that are not numbers")  # fmt: skip
    add("vertex normals reversed", "floor.ply", ply(corners, triangles, down))
    add("one vertex not a number", "floor.ply", ply([(math.nan, 0, 0), *corners[1:]], triangles), message="floor.ply")
    add("one vertex infinite", "floor.ply", ply([(math.inf, 0, 0), *corners[1:]], triangles), message="floor.ply")
    add("one vertex at 3e38", "floor.ply", ply([*corners, (3e38, -3e38, 0)], [*triangles, (81, 0, 1)]), no_mitsuba="no such numbers")
    add("one normal not a number", "floor.ply", ply(corners, triangles, [(math.nan, 0, 0), *up[1:]]), same_as="room",
        no_mitsuba="makes values that are not numbers")  # fmt: skip
    add("no triangles", "floor.obj", obj(corners, []), no_mitsuba="an error there")
    add("one index out of range", "floor.ply", ply(corners, [*triangles, (0, 1, 81)]), message="floor.ply")
    flipped = walls(HERE, flip=True)
    found.append(Case("walls inside out", room(walls=flipped)))
    both = {name: two_sided(diffuse(0.7)) for name in WALLS}
    found.append(Case("two-sided walls", room(walls=walls(HERE, both))))
    found.append(Case("two-sided walls inside out", room(walls=walls(HERE, both, flip=True)), same_as="two-sided walls"))
    twice = things(HERE) * 2
    found.append(Case("every object twice", room(things=twice), same_as="room"))
    glass = bsdf("dielectric", number("int_ior", 1.5))
    ball = lambda flip: HERE.shape("sphere", steps(scale="0.4, 0.4, 0.4", move="0, 0.8, 0"), glass, f'<boolean name="flip_normals" value="{flip}"/>')  # noqa: E731
    found.append(Case("glass ball", room(things=ball("false")), without=MIRRORS))
    found.append(Case("glass ball inside out", room(things=ball("true")), without=MIRRORS))
    return found


def lights() -> list[Case]:
    """Lights of every size and power, and none."""
    corners = [(-0.3, 1.98, -0.3), (0.3, 1.98, -0.3), (0.3, 1.98, 0.3), (-0.3, 1.98, 0.3)]
    square = [(0, 1, 2), (0, 2, 3)]
    mesh_lamp = mesh(HERE, "lamp.obj", diffuse(0.2), emitter("12, 11, 9"))
    found = [
        Case("no light", room(lamp=""), radiance=0),
        Case("light of radiance 0", room(lamp=lamp(HERE, 0)), radiance=0),
        Case("light of radiance 1e-30", room(radiance="12e-30, 11e-30, 9e-30"), same_as="room", brightness=1e-30),
        Case("light of radiance 1e-12", room(radiance="12e-12, 11e-12, 9e-12"), same_as="room", brightness=1e-12),
        Case("light of radiance 1e12", room(radiance="12e12, 11e12, 9e12"), same_as="room", brightness=1e12),
        Case("light of radiance 1e30", room(radiance="12e30, 11e30, 9e30"), same_as="room", brightness=1e30),
        Case("light of negative radiance", room(radiance="-12, -11, -9"), same_as="room", brightness=-1,
             beyond="photons have no negative power", beyond_for=PHOTONS),
        Case("mesh light", room(lamp=mesh_lamp), {"lamp.obj": obj(corners, square)}, same_as="room"),
        Case("mesh light with triangles without area", room(lamp=mesh_lamp),
             {"lamp.obj": obj(corners, [*square, (0, 0, 1), (0, 0, 0), (1, 2, 2)])}, same_as="room"),
        Case("mesh light without area", room(lamp=mesh_lamp), {"lamp.obj": obj(corners, [(0, 0, 1), (2, 2, 2)])}, radiance=0,
             no_mitsuba="not a number there"),
        Case("light scaled to 0", room(lamp=HERE.shape("rectangle", steps(scale="0, 0, 1"), diffuse(), emitter(1))), message="must be invertible"),
        Case("sphere light of radius 1e-5", room(lamp=ball_light(1e-5, 4 / math.pi / 1e-10)), same_as="room, point light"),
        Case("sphere light of radius 1e-9", room(lamp=ball_light(1e-9, 4 / math.pi / 1e-18)), same_as="room, point light"),
        Case("black room with light", room(walls=walls(HERE, {n: diffuse(0) for n in WALLS}), things="")),
        Case("1e5 m lamp over an open room", beyond="hardly any photon arrives", beyond_for=PHOTONS, xml=room(walls=walls(HERE, left_out=("ceiling",)), lamp=HERE.shape(
            "rectangle", steps(scale="1e5, 1e5, 1", turn="x 90", move="0, 10, 0"), diffuse(0), emitter(1)))),
        Case("sphere light of 5 km around all", beyond="hardly any photon arrives", beyond_for=PHOTONS, xml=room(walls=walls(HERE, left_out=("ceiling",)), lamp=HERE.shape(
            "sphere", steps(scale="5000, 5000, 5000"), diffuse(0), emitter(1), '<boolean name="flip_normals" value="true"/>'))),
        Case("constant light, open room", room(walls=walls(HERE, left_out=("ceiling",)), lamp=f'<emitter type="constant">{rgb("radiance", 1)}</emitter>'),
             same_as="sphere light of 5 km around all", without=MIRRORS),
        Case("1000 lamps of radiance 0 and one lamp", room(more="".join(
            HERE.shape("rectangle", steps(scale="0.001, 0.001, 1", turn="x 90", move=f"{0.001 * i - 0.5}, 1.99, 0.9"), emitter(0)) for i in range(1000)))),
        Case("lamps of power 1 and 1e-12", room(more=HERE.shape("rectangle", steps(scale="0.1, 0.1, 1", turn="x 90", move="0.6, 1.9, 0.6"), diffuse(0.2), emitter(1e-11)))),
    ]  # fmt: skip
    return found + environments()


def ball_light(radius: float, radiance: float) -> str:
    return HERE.shape("sphere", steps(scale=f"{radius}, {radius}, {radius}", move="0, 1.7, 0"), diffuse(0), emitter(radiance))


def environments() -> list[Case]:
    opened = walls(HERE, left_out=("ceiling",))
    envmap = '<emitter type="envmap"><string name="filename" value="sky.pfm"/></emitter>'
    def sky(name: str, value: float, **more) -> Case:
        rows = [[0.5] * 16 for _ in range(8)]
        rows[1][5] = value
        return Case(name, room(walls=opened, lamp=envmap), {"sky.pfm": pfm(rows)}, no_mitsuba="its envmap of this size is another", without=MIRRORS, **more)

    black = pfm([[0.0] * 16 for _ in range(8)])
    return [
        sky("environment with a pixel of 0", 0.0),
        sky("environment with a pixel of 0.5", 0.5),
        sky("environment with a pixel of 1e4", 1e4),
        sky("environment with a pixel of 1e18", 1e18),
        sky("environment with a pixel of 1e30", 1e30, same_as="environment with a pixel of 1e18", brightness=1e12),
        sky("environment with a pixel that is not a number", math.nan, same_as="environment with a pixel of 0"),
        sky("environment with an infinite pixel", math.inf, same_as="environment with a pixel of 0.5"),
        sky("environment with a negative pixel", -0.3),
        Case("environment of 1e-30", room(walls=opened, lamp=envmap), {"sky.pfm": pfm([[0.5e-30] * 16 for _ in range(8)])},
             same_as="environment with a pixel of 0.5", brightness=1e-30, without=MIRRORS,
             no_mitsuba="its envmap of this size is another"),
        Case("black environment", room(walls=opened, lamp=envmap), {"sky.pfm": black}, radiance=0, no_mitsuba="not a number there"),
    ]


def materials() -> list[Case]:
    """Roughness, albedo and indices of refraction at their ends."""
    found = []
    for kind in ("roughconductor", "roughplastic", "roughdielectric"):
        for alpha in (0.0, 1e-8, 1e-4, 0.01, 1.0, 3.0):
            found.append(Case(f"{kind}, alpha {alpha:g}", room(things=things(HERE, ball=glossy(alpha, kind), box=diffuse())),
                              without=MIRRORS if alpha < 0.1 or kind == "roughdielectric" else (), spp=256 if alpha < 0.1 else 128,
                              no_mitsuba="divides by 0" if alpha == 0 else "beyond its range" if alpha > 1 else ""))  # fmt: skip
    for roughness in (0.0, 1.0):
        ball = bsdf("principled", rgb("base_color", "0.8, 0.5, 0.3"), number("roughness", roughness), number("metallic", 0.5), number("specular", 0.5))
        found.append(Case(f"principled, roughness {roughness:g}", room(things=things(HERE, ball=ball)), without=MIRRORS if roughness == 0 else ()))
    white = {name: diffuse(1) for name in WALLS}
    ball = HERE.shape("sphere", steps(scale="0.5, 0.5, 0.5", move="0, 1, 0"), diffuse(1))
    view = HERE.camera((0, 1, 3), (0, 1, 0), 30)
    sky = f'<emitter type="constant">{rgb("radiance", 1)}</emitter>'
    furnace = lambda ball, depth: scene(view, ball, sky, depth=depth)  # noqa: E731
    metal = bsdf("conductor", rgb("specular_reflectance", 1), '<string name="material" value="none"/>')
    glass = lambda ior: bsdf("dielectric", number("int_ior", ior), number("ext_ior", 1))  # noqa: E731
    shape = lambda material: HERE.shape("sphere", steps(scale="0.5, 0.5, 0.5", move="0, 1, 0"), material)  # noqa: E731
    return found + [
        Case("white room, 100 bounces", room(walls=walls(HERE, white), depth=100)),
        Case("white room without end", room(walls=walls(HERE, white), depth=-1), without=("light-trace",)),
        Case("white room without end and without light", room(walls=walls(HERE, white), depth=-1, lamp="", things=""), radiance=0),
        Case("room of albedo 1.5", room(walls=walls(HERE, {n: diffuse(1.5) for n in WALLS}), depth=5), message="reflectance"),
        Case("white ball in a white sky", furnace(ball, -1), radiance=1, without=MIRRORS),
        Case("mirror ball in a white sky", furnace(shape(metal), -1), radiance=1, without=MIRRORS),
        Case("glass ball in a white sky", furnace(shape(glass(1.5)), -1), radiance=1, without=MIRRORS),
        Case("glass of index 1 in a white sky", furnace(shape(glass(1.0)), -1), radiance=1, without=MIRRORS),
        Case("glass of index 1e6 in a white sky", furnace(shape(glass(1e6)), 12), without=MIRRORS, no_mitsuba="runs on its own depth"),
        Case("glass of index 0", furnace(shape(glass(0)), 8), message="int_ior"),
    ]


def cameras() -> list[Case]:
    """Cameras in and on objects."""
    glass, rough = bsdf("dielectric", number("int_ior", 1.5)), glossy(0.3, "roughdielectric")
    around = lambda material, *more: HERE.shape("sphere", steps(scale="0.2, 0.2, 0.2", move="0.1, 1, 0.6"), material, *more)  # noqa: E731
    inside = HERE.camera((0.1, 1, 0.6), (0, 0.8, -1))
    touch = lambda z: HERE.camera((0.1, 1, z), (0, 0.8, -1))  # noqa: E731
    lens = lambda radius, focus: HERE.camera(*VIEW, kind="thinlens", more=number("aperture_radius", radius) + number("focus_distance", focus))  # noqa: E731
    return [
        Case("camera in a diffuse ball", room(camera=inside, things=around(diffuse())), radiance=0, without=MIRRORS),
        Case("camera in a two-sided ball", room(camera=inside, things=around(two_sided(diffuse()))), radiance=0),
        Case("camera in a glass ball", room(camera=inside, things=around(glass)), without=MIRRORS, spp=256),
        Case("camera in a ball of rough glass", room(camera=inside, things=around(rough)), without=MIRRORS, spp=256),
        Case("camera in a lamp", room(camera=inside, things=around(diffuse(0.5), emitter(3)), lamp="")),
        Case("camera in a lamp that shines inwards", radiance=3 * (2 - 2**-7), xml=room(camera=inside, lamp="", things=around(
            diffuse(0.5), emitter(3), '<boolean name="flip_normals" value="true"/>'))),
        Case("camera on a wall", room(camera=touch(1.0)), no_mitsuba="the camera is on the surface"),
        Case("camera 1e-6 before a wall", room(camera=touch(1 - 1e-6)), same_as="camera on a wall"),
        Case("camera of 0.001 degrees", room(camera=HERE.camera(*VIEW, fov=0.001)), without=MIRRORS),
        Case("camera of 179 degrees", room(camera=HERE.camera(*VIEW, fov=179))),
        Case("camera of 0 degrees", room(camera=HERE.camera(*VIEW, fov=0)), message="fov"),
        Case("camera of 180 degrees", room(camera=HERE.camera(*VIEW, fov=180)), message="fov"),
        Case("camera that looks at itself", room(camera=HERE.camera(VIEW[0], VIEW[0])), message="lookat"),
        Case("camera with up along the view", room(camera=HERE.camera((0, 1, 0), (0, 0, 0))), message="lookat"),
        Case("lens of radius 0", room(camera=lens(0, 1)), same_as="room", no_mitsuba="an error there"),
        Case("lens in focus at 0", room(camera=lens(0.01, 0)), message="focus_distance"),
        Case("lens of 1 m in a room of 2 m", room(camera=lens(1.0, 1.0)), without=("light-trace",)),
    ]  # fmt: skip


def all_cases() -> list[Case]:
    return scales() + meshes() + lights() + materials() + cameras()
