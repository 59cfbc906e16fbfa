# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of manylight as passes of Blender. Arrays of numpy; rows from the top down."""

import numpy as np

# Depth where there is no surface, as in Cycles.
FAR = 1e10
# Start of the names of light groups' passes and layers, and the layer of the world.
GROUP = "Combined_"
WORLD_LAYER = f"{GROUP}environment"
# Start of the names of layers of light groups in a denoised picture.
DENOISED = "denoised_"
# Coverage below which a pixel has no surface.
LEAST_COVERAGE = 1e-6


def enabled(view_layer, terms):
    """The passes of a view layer beside the picture: name, channels, and kind for the compositor."""
    own = view_layer.manylight
    chosen = [
        (view_layer.use_pass_z, "Depth", "Z", "VALUE"),
        (view_layer.use_pass_position, "Position", "XYZ", "VECTOR"),
        (view_layer.use_pass_normal, "Normal", "XYZ", "VECTOR"),
        (own.albedo, "Denoising Albedo", "RGB", "COLOR"),
    ]
    chosen += [(own.terms, name, "RGB", "COLOR") for name in terms]
    chosen += [(True, name, "RGB", "COLOR") for name in of_light_groups(view_layer)]
    return [(name, channels, kind) for is_on, name, channels, kind in chosen if is_on]


def of_surfaces(view_layer, terms):
    """Names of the enabled passes that describe the first surface."""
    return {name for name, _, _ in enabled(view_layer, terms)}.difference(terms, of_light_groups(view_layer))


def of_light_groups(view_layer):
    """Names of the passes of the light groups, those of Cycles."""
    return [f"{GROUP}{group.name}" for group in view_layer.lightgroups]


def light_groups(layers, names, world_group, light_behind):
    """The passes `names` of light groups from the layers of a picture. The world has a layer of its own, which belongs to the group
    `world_group`, if that is not empty, with the light behind the picture, (height, width, 3). Groups of denoised pictures are denoised."""
    nothing = np.zeros_like(light_behind)
    group = lambda name: layers.get(f"{DENOISED}{name}", layers.get(name, nothing))
    found = {name: group(name) for name in names}
    world = f"{GROUP}{world_group}"
    if world in found:
        found[world] = found[world] + group(WORLD_LAYER) + light_behind
    return found


# What other engines offer and this one does not, by property of the view layer.
UNAVAILABLE = {
    "use_pass_mist": "Mist",
    "use_pass_vector": "Vector",
    "use_pass_uv": "UV",
    "use_pass_object_index": "Object Index",
    "use_pass_material_index": "Material Index",
    "use_pass_diffuse_direct": "Diffuse Direct",
    "use_pass_diffuse_indirect": "Diffuse Indirect",
    "use_pass_diffuse_color": "Diffuse Color",
    "use_pass_glossy_direct": "Glossy Direct",
    "use_pass_glossy_indirect": "Glossy Indirect",
    "use_pass_glossy_color": "Glossy Color",
    "use_pass_transmission_direct": "Transmission Direct",
    "use_pass_transmission_indirect": "Transmission Indirect",
    "use_pass_transmission_color": "Transmission Color",
    "use_pass_emit": "Emission",
    "use_pass_environment": "Environment",
    "use_pass_ambient_occlusion": "Ambient Occlusion",
    "use_pass_shadow": "Shadow",
    "use_pass_cryptomatte_object": "Cryptomatte Object",
    "use_pass_cryptomatte_material": "Cryptomatte Material",
    "use_pass_cryptomatte_asset": "Cryptomatte Asset",
}


def unavailable(view_layer):
    """Names of enabled passes that the engine does not have."""
    return [name for prop, name in UNAVAILABLE.items() if getattr(view_layer, prop, False)]


def behind(alpha, background):
    """The light of the background in a picture: (height, width, 3). `background`: (3,) or (height, width, 3), or None."""
    light = np.zeros((*alpha.shape, 3), np.float32)
    if background is not None:
        light += (1 - np.clip(alpha, 0, 1))[..., None] * background
    return light


def combined(picture, alpha, light_behind, is_transparent):
    """The picture over its background: (height, width, 4), premultiplied."""
    result = np.empty((*picture.shape[:2], 4), np.float32)
    result[..., :3], result[..., 3] = picture, alpha
    if not is_transparent:
        result[..., :3] += light_behind
        result[..., 3] = 1
    return result


def to_blender(vectors):
    """Vectors of glTF's world, (..., 3), in Blender's, which has z up."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([x, -z, y], -1)


def surface_passes(layers, camera):
    """The passes that describe the first surface, from layers that count samples without a surface as 0.

    `camera`: the matrix (4, 4) from the camera to the world. Depth is along the view axis, as in Cycles."""
    alpha = layers["alpha"]
    is_covered = alpha > LEAST_COVERAGE
    weight = np.where(is_covered, alpha, 1)[..., None]
    position = to_blender(layers["position"]) / weight
    matrix = np.array(camera)
    forward = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    depth = (position - matrix[:3, 3]) @ forward
    return {
        "Depth": np.where(is_covered, depth, FAR)[..., None],
        "Position": np.where(is_covered[..., None], position, 0),
        "Normal": to_blender(layers["normal"]),
        "Denoising Albedo": layers["albedo"],
    }
