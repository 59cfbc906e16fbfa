#!/usr/bin/env python3
"""Cycles with path guiding, called as `manylight render` is, for plans of `manylight study`.

    python3 cycles_path.py SCENE.xml --time 30s --size 320x180 --max-depth 16 [--denoise] --json --output OUT.exr

Meshes, cameras and area lights are translated exactly, up to spheres as triangles. Materials: diffuse, GGX conductors and
glass have the same models; the diffuse base of a rough plastic lacks one factor (`plastic`), and the tint of a conductor
fades at grazing angles (`conductor`). The falloff of spot lights is made of nodes. Needs `pip install bpy OpenEXR`.
"""
import functools
import math
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import microfacets
import program
import scene_xml

#: Seconds of the time that are left to the denoiser, per megapixel.
DENOISING_SECONDS = 30.0


def main():
    parser = program.parser(__doc__)
    parser.add_argument("--denoise", action="store_true", help="by Open Image Denoise, with albedo and normal")
    parser.add_argument("--no-guiding", action="store_true")
    parser.add_argument("--clamp-indirect", type=float, default=0.0, help="Blender's default is 10; 0 is none")
    words = parser.parse_args()
    try:
        import bpy
    except ImportError:
        program.unavailable("Cycles is not installed: pip install bpy")
    try:
        scene = scene_xml.read_scene(words.scene, words.size)
    except scene_xml.Unsupported as reason:
        program.unavailable(f"not translated: {reason}")
    with program.output_to_stderr():
        build(bpy, scene)
        settings = set_up(bpy, scene.camera, words)
        image, seconds = render(bpy)
    for path in words.output:
        program.write(path, image)
    if words.json:
        # Cycles does not state how many samples a time limit has left.
        counts = {} if words.spp is None else {"passes": words.spp}
        program.report(f"Blender {bpy.app.version_string}", settings, {"path": seconds}, counts)


def build(bpy, scene):
    """The scene in an empty file. Without a world there is no light from outside."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.world = None
    materials = {}
    for shape in scene.shapes:
        key = (shape.material, shape.radiance)
        if key not in materials:
            materials[key] = make_material(bpy, scene.materials[shape.material], shape.radiance)
        add_mesh(bpy, shape, materials[key])
    for spot in scene.spots:
        add_spot(bpy, spot)


def add_mesh(bpy, shape, material):
    mesh = bpy.data.meshes.new(shape.name or "shape")
    mesh.from_pydata(shape.vertices.tolist(), [], shape.triangles.tolist())
    mesh.materials.append(material)
    if shape.uvs is not None:
        corners = shape.uvs[shape.triangles.ravel()].copy()
        # Blender's v = 0 is the last row of an image.
        corners[:, 1] = 1 - corners[:, 1]
        mesh.uv_layers.new().data.foreach_set("uv", corners.ravel())
    if shape.normals is not None:
        mesh.shade_smooth()
        mesh.normals_split_custom_set_from_vertices(shape.normals.tolist())
    bpy.context.collection.objects.link(bpy.data.objects.new(mesh.name, mesh))


# Materials


class Nodes:
    """Nodes of a material or light, made with less ceremony."""

    def __init__(self, owner, bpy):
        owner.use_nodes = True
        self.tree = owner.node_tree
        self.tree.nodes.clear()
        self.bpy = bpy

    def add(self, kind, inputs=(), **attributes):
        """A node. `inputs`: pairs of name or index, and value or socket."""
        node = self.tree.nodes.new(kind)
        for name, value in attributes.items():
            setattr(node, name, value)
        for name, value in dict(inputs).items():
            self.set(node.inputs[name], value)
        return node

    def set(self, socket, value):
        if hasattr(value, "is_linked"):
            self.tree.links.new(value, socket)
        elif socket.type == "RGBA":
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value

    def math(self, operation, *operands, **attributes):
        node = self.add("ShaderNodeMath", enumerate(operands), operation=operation, **attributes)
        return node.outputs[0]

    def dot(self, a, b):
        return self.add("ShaderNodeVectorMath", {0: a, 1: b}, operation="DOT_PRODUCT").outputs["Value"]

    def mix(self, factor, first, second):
        return self.add("ShaderNodeMixShader", {0: factor, 1: first, 2: second}).outputs[0]

    def sum(self, first, second):
        return self.add("ShaderNodeAddShader", {0: first, 1: second}).outputs[0]

    def curve(self, place, values):
        """The piecewise linear function with these values at equal distances from 0 to 1."""
        node = self.add("ShaderNodeValToRGB", {0: place})
        elements = node.color_ramp.elements
        while len(elements) < len(values):
            elements.new(0.5)
        for index, value in enumerate(values):
            elements[index].position = index / (len(values) - 1)
            elements[index].color = (value, value, value, 1)
        return node.outputs["Color"]

    def black(self):
        return self.add("ShaderNodeBsdfDiffuse", {"Color": (0, 0, 0)}).outputs[0]

    def color(self, value):
        """A socket for a texture, and three numbers as they are."""
        if not isinstance(value, scene_xml.Texture):
            return value
        image = self.bpy.data.images.load(str(value.path), check_existing=True)
        image.colorspace_settings.name = "Non-Color" if value.raw else "sRGB"
        return self.add("ShaderNodeTexImage", image=image, interpolation="Linear").outputs["Color"]


def make_material(bpy, source, radiance):
    material = bpy.data.materials.new(source.kind)
    nodes = Nodes(material, bpy)
    if radiance is None:
        surface = scattering(nodes, source)
    else:
        surface = emission(nodes, radiance)
        material.cycles.emission_sampling = "FRONT"
    nodes.add("ShaderNodeOutputMaterial", {"Surface": surface})
    return material


def emission(nodes, radiance):
    """Emission from the front. Emitters reflect nothing: the scenes give them black materials or hardly brighter ones."""
    strength = max(radiance)
    emitting = nodes.add("ShaderNodeEmission", {"Color": [c / strength for c in radiance], "Strength": strength})
    back = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    return nodes.mix(back, emitting.outputs[0], nodes.black())


def scattering(nodes, source):
    """The output of the nodes of a material."""
    make = {
        "diffuse": diffuse, "roughplastic": plastic, "roughconductor": conductor, "dielectric": glass, "blendbsdf": blend
    }
    return make[source.kind](nodes, source)


def diffuse(nodes, source):
    return nodes.add("ShaderNodeBsdfDiffuse", {"Color": nodes.color(source.color), "Roughness": 0.0}).outputs[0]


def plastic(nodes, source):
    """A GGX dielectric layer on a diffuse base. With T the transmittance of the layer, Mitsuba's base is the color times
    T(wi) T(wo) times a constant; nodes see wo only, so that T(wi) is replaced by its mean."""
    inputs = {"Base Color": (0, 0, 0), "Roughness": math.sqrt(source.alpha), "IOR": source.ior, "Metallic": 0.0}
    layer = nodes.add("ShaderNodeBsdfPrincipled", inputs, distribution="GGX").outputs[0]
    geometry = nodes.add("ShaderNodeNewGeometry").outputs
    cosine = nodes.dot(geometry["Incoming"], geometry["Normal"])
    share = nodes.curve(cosine, base_share(source.alpha, source.ior))
    return nodes.sum(layer, nodes.mix(share, nodes.black(), diffuse(nodes, source)))


@functools.cache
def base_share(alpha, ior):
    """Share of the diffuse color that a rough plastic has for each of CURVE_COSINES."""
    return microfacets.plastic_base(alpha, ior) * microfacets.transmittance(alpha, ior, CURVE_COSINES)


#: Cosines at which curves are given.
CURVE_COSINES = np.linspace(0, 1, 32)


def conductor(nodes, source):
    """The largest component of the tint is the share of the metal in a mixture with black, the others change k so
    that the reflectance at normal incidence has the tint."""
    largest = max(source.tint)
    eta, k = scene_xml.tinted(source.eta, source.k, np.array(source.tint) / largest)
    inputs = {"Roughness": math.sqrt(source.alpha), "IOR": tuple(eta), "Extinction": tuple(k)}
    kind = {"distribution": "GGX", "fresnel_type": "PHYSICAL_CONDUCTOR"}
    metal = nodes.add("ShaderNodeBsdfMetallic", inputs, **kind).outputs[0]
    return metal if largest == 1.0 else nodes.mix(largest, nodes.black(), metal)


def glass(nodes, source):
    return nodes.add("ShaderNodeBsdfGlass", {"Roughness": 0.0, "IOR": source.ior}).outputs[0]


def blend(nodes, source):
    first, second = (scattering(nodes, part) for part in source.parts)
    weight = source.weight[0] if isinstance(source.weight, tuple) else nodes.color(source.weight)
    return nodes.mix(weight, first, second)


def add_spot(bpy, spot):
    """A spot light of constant intensity; nodes give it the falloff, because Blender's is another function of the angle."""
    light = bpy.data.lights.new("spot", "SPOT")
    light.shadow_soft_size = 0.0
    light.spot_size, light.spot_blend = 2 * spot.cutoff, 0.0
    # The radiant intensity of a power of P watts is P / (4 pi) times the strength of the emission node.
    light.energy = 4 * math.pi
    nodes = Nodes(light, bpy)
    incoming = nodes.add("ShaderNodeNewGeometry").outputs["Incoming"]
    cosine = nodes.math("MINIMUM", nodes.dot(incoming, tuple(spot.direction)), 1.0)
    angle = nodes.math("ARCCOSINE", cosine)
    fall = nodes.math("DIVIDE", nodes.math("SUBTRACT", spot.cutoff, angle), spot.cutoff - spot.beam, use_clamp=True)
    strength = max(spot.intensity)
    color = [c / strength for c in spot.intensity]
    shader = nodes.add("ShaderNodeEmission", {"Color": color, "Strength": nodes.math("MULTIPLY", fall, strength)})
    nodes.add("ShaderNodeOutputLight", {0: shader.outputs[0]})
    thing = bpy.data.objects.new("spot", light)
    thing.matrix_world = placement(spot.position, spot.direction, any_normal(spot.direction))
    bpy.context.collection.objects.link(thing)


def placement(position, direction, up):
    """The matrix of a camera or light, which look along -z with y up."""
    import mathutils

    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = np.cross(direction, up), up, -direction
    matrix[:3, 3] = position
    return mathutils.Matrix(matrix.tolist())


def any_normal(direction):
    """A unit vector at right angles to a unit vector."""
    axis = np.eye(3)[np.argmin(np.abs(direction))]
    normal = np.cross(direction, axis)
    return normal / np.linalg.norm(normal)


# Camera and settings


def set_up(bpy, camera, words):
    """Camera, film and integrator; returns what the report says of them."""
    scene = bpy.context.scene
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "HORIZONTAL" if camera.is_horizontal else "VERTICAL"
    data.angle = camera.fov
    data.clip_start, data.clip_end = 1e-3, 1e4
    thing = bpy.data.objects.new("camera", data)
    thing.matrix_world = placement(camera.position, camera.direction, camera.up)
    bpy.context.collection.objects.link(thing)
    scene.camera = thing
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = words.size
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Raw"
    return set_up_cycles(scene.cycles, words)


def set_up_cycles(cycles, words):
    """No cut-off, no blur and by default no clamping: nothing that biases on purpose, as far as settings go."""
    cycles.device = "CPU"
    cycles.seed = words.seed
    cycles.pixel_filter_type = "BOX"
    bounces = 1024 if words.max_depth < 0 else max(words.max_depth - 2, 0)
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.sample_clamp_direct, cycles.sample_clamp_indirect = 0.0, words.clamp_indirect
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_light_tree = True
    cycles.use_adaptive_sampling = False
    cycles.use_guiding = not words.no_guiding
    cycles.use_surface_guiding = cycles.use_guiding
    cycles.samples = words.spp or 1 << 20
    if words.time is not None:
        megapixels = words.size[0] * words.size[1] / 1e6
        cycles.time_limit = words.time - (DENOISING_SECONDS * megapixels if words.denoise else 0.0)
    cycles.use_denoising = words.denoise
    if words.denoise:
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
        cycles.denoising_prefilter = "ACCURATE"
        cycles.denoising_quality = "HIGH"
    return {
        "integrator": "path", "guiding": cycles.use_guiding, "denoiser": words.denoise,
        "clamp_indirect": words.clamp_indirect, "max_bounces": bounces,
    }


def render(bpy):
    """The image, and the seconds of rendering with the building of the BVH and denoising."""
    import OpenEXR
    import tempfile

    render = bpy.context.scene.render
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.exr"
        render.filepath = str(path)
        start = time.monotonic()
        bpy.ops.render.render(write_still=True)
        seconds = time.monotonic() - start
        with OpenEXR.File(str(path), separate_channels=True) as file:
            image = np.stack([np.array(file.channels()[c].pixels, float) for c in "RGB"], axis=-1)
    return image, seconds


if __name__ == "__main__":
    main()
