# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of manylight as passes of Blender. Arrays of numpy; rows from the top down."""

import numpy as np

# Depth where there is no surface, as in Cycles.
FAR = 1e10
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
    return [(name, channels, kind) for is_on, name, channels, kind in chosen if is_on]


def of_surfaces(view_layer, terms):
    """Names of the enabled passes that describe the first surface."""
    return {name for name, _, _ in enabled(view_layer, terms)}.difference(terms)


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


def combined(picture, alpha, background, is_transparent):
    """The picture over its background: (height, width, 4), premultiplied. `background`: (3,) or (height, width, 3), or None."""
    result = np.empty((*picture.shape[:2], 4), np.float32)
    result[..., :3], result[..., 3] = picture, alpha
    if is_transparent:
        return result
    if background is not None:
        result[..., :3] += (1 - np.clip(alpha, 0, 1))[..., None] * background
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
