# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the engine, kept in the file: of the scene (`scene.manylight`) and of view layers (`view_layer.manylight`)."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

METHODS = [
    ("auto", "Automatic", "Path tracing, Rich VPLs, or the mean of both: what has the least error in the scene"),
    ("rich-vpl", "Rich VPLs", "Rich virtual point lights, placed by importance; each stands for all photons in its cell"),
    ("rich-lightcuts", "Rich lightcuts", "Lightcuts with many Rich-VPLs"),
    ("bidirectional-lightcuts", "Bidirectional lightcuts", "One cut through all pairs of gather points and Rich-VPLs"),
    ("rich-vsl", "Rich VSLs", "Rich virtual spherical lights"),
    ("rich-vpl-paper", "Rich VPLs of 2015", "Rich-VPLs as presented in 2015"),
    ("vpl", "VPLs", "Classic virtual point lights (instant radiosity)"),
    ("vpl-is", "VPLs by importance", "Virtual point lights placed by importance"),
    ("vsl", "VSLs", "Virtual spherical lights"),
    ("lightcuts", "Lightcuts", "Many classic virtual point lights in clusters of a light tree"),
    ("photon-map", "Photon map", "Progressive photon mapping"),
    ("path", "Path tracing", "Path tracing with next-event estimation: the reference"),
    ("light-trace", "Light tracing", "Light tracing; smooth glass and mirrors are black"),
    ("direct", "Direct light", "Direct illumination only"),
]
FILTERS = [
    ("box", "Box", "Closest to Cycles' default, Blackman-Harris with a width of 1.5 pixels"),
    ("tent", "Tent", "Falls linearly"),
    ("gaussian", "Gaussian", "Standard deviation of half a pixel: smoother than Cycles' default"),
    ("mitchell", "Mitchell", "Mitchell-Netravali"),
    ("catmullrom", "Catmull-Rom", "Sharper, with negative lobes"),
    ("lanczos", "Lanczos", "Windowed sinc, with negative lobes"),
]
# Terms of the image, as film layers and as passes.
TERMS = ("emission", "direct", "virtual_lights", "compensation", "caustics")


class SceneSettings(bpy.types.PropertyGroup):
    method: EnumProperty(name="Method", items=METHODS, default="auto")
    passes: IntProperty(name="Passes", description="Samples of a pixel; 0: until the time is over", default=64, min=0)
    time: FloatProperty(
        name="Time limit", description="Stop after this time without loading, in seconds; 0: no limit", min=0.0, unit="NONE"
    )
    target_error: FloatProperty(
        name="Target error",
        description="Stop when the relative error of the picture, denoised if it is, is at most this; 0: none",
        min=0.0,
        precision=4,
    )
    lights: IntProperty(
        name="Lights",
        description="Virtual lights of a pass; 0: as the method says",
        default=0,
        min=0,
    )
    max_depth: IntProperty(
        name="Depth", description="Most segments of a path: 1 is emission, 2 direct light; 0: no limit", default=0, min=0
    )
    seed: IntProperty(name="Seed", description="The same seed gives the same picture", default=0, min=0)
    threads: IntProperty(name="Threads", description="0: one for each processor", default=0, min=0)
    filter: EnumProperty(name="Filter", items=FILTERS, default="box")
    denoise: BoolProperty(name="Denoise", description="Denoise the picture at the end by Open Image Denoise")
    walkthrough: BoolProperty(
        name="Walkthrough",
        description=(
            "Nothing but the camera moves in the animation: photons and lights are made once, for the cameras of all frames, "
            "so that their noise does not flicker"
        ),
    )
    more: StringProperty(
        name="More options",
        description="Further options of manylight.render, such as: photons=200000 clamp=none",
    )


class ViewLayerSettings(bpy.types.PropertyGroup):
    albedo: BoolProperty(name="Albedo", description="The pass `Denoising Albedo`: albedo of the first surface")
    terms: BoolProperty(
        name="Terms of the image",
        description="Emission, direct light, virtual lights, compensation of their clamping, and caustics",
    )


CLASSES = (SceneSettings, ViewLayerSettings)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.manylight = PointerProperty(type=SceneSettings)
    bpy.types.ViewLayer.manylight = PointerProperty(type=ViewLayerSettings)


def unregister():
    del bpy.types.ViewLayer.manylight
    del bpy.types.Scene.manylight
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def render_options(settings):
    """Keywords of `manylight.render`. Raises ValueError for malformed further options."""
    options = {"method": settings.method, "seed": settings.seed, "filter": settings.filter}
    positive = {
        "passes": settings.passes,
        "time": settings.time,
        "target_error": settings.target_error,
        "lights": settings.lights,
        "max_depth": settings.max_depth,
        "threads": settings.threads,
    }
    options |= {name: value for name, value in positive.items() if value > 0}
    if not settings.passes and not settings.time and not settings.target_error:
        raise ValueError("passes, time limit and target error are all 0: the render would never end")
    if settings.denoise:
        options["denoise"] = "oidn"
    for word in settings.more.split():
        name, equals, value = word.partition("=")
        if not equals or not name.isidentifier():
            raise ValueError(f"more options: found `{word}`, expected NAME=VALUE")
        options[name] = parsed(value)
    return options


def parsed(text):
    """An integer, a number, or text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
