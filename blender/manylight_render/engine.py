# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: exports the scene, renders it by the package `manylight`, and hands the layers to Blender."""

import shutil
import tempfile
import time

import bpy
import numpy as np

from . import launch, passes, walkthrough
from .settings import TERMS, render_options

# Samples of a pixel for the passes that describe surfaces, and for the background.
SURFACE_SAMPLES = 16
# Least seconds between updates of the picture.
UPDATE_INTERVAL = 1.0
MISSING = (
    "the Python package `manylight` is not installed in Blender's Python: install it by "
    "`{python} -m pip install manylight`, or add its wheel to the extension"
)


class RenderFailed(Exception):
    """The render cannot go on; the message says why."""


class ManylightEngine(bpy.types.RenderEngine):
    bl_idname = "MANYLIGHT"
    bl_label = "manylight"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene, renderlayer):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name, channels, kind in passes.enabled(renderlayer, TERMS):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def update(self, data, depsgraph):
        self.failure = None
        self.folder = tempfile.mkdtemp(prefix="manylight_")
        try:
            needs_coverage = bool(passes.of_surfaces(depsgraph.view_layer, TERMS))
            self.request = launch.request(self, depsgraph, needs_coverage, self.folder)
        except ValueError as error:
            self.failure = str(error)
        except Exception as error:
            self.failure = f"the scene cannot be written for the export: {error}"

    def render(self, depsgraph):
        try:
            if self.failure:
                raise RenderFailed(self.failure)
            render_layer(self, depsgraph)
        except launch.Cancelled:
            self.leave_black(depsgraph)
        except (RenderFailed, launch.ExportError) as error:
            self.fail(f"manylight: {error}")
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)

    def leave_black(self, depsgraph):
        """Hands over an empty picture: Blender crashes when it saves a result that no engine has begun."""
        _, _, width, height = launch.border(depsgraph.scene.render, launch.picture_size(depsgraph.scene.render))
        self.end_result(self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name))

    def is_cancelled(self):
        """Whether the user has cancelled the render."""
        return self.test_break()

    def fail(self, message):
        self.report({"ERROR"}, message)
        self.error_set(message)


def render_layer(engine, depsgraph):
    manylight = package()
    view_layer, scene = depsgraph.view_layer, depsgraph.scene
    try:
        options = render_options(scene.manylight)
    except ValueError as error:
        raise RenderFailed(error) from None
    lost = passes.unavailable(view_layer)
    if lost:
        engine.report({"WARNING"}, f"manylight: these passes are not available: {', '.join(lost)}")
    engine.update_stats("", "Exporting the scene")
    exported = launch.run(engine.request, engine.is_cancelled)
    try:
        job = Job(engine, manylight, exported, options, scene, view_layer)
        for warning in exported["warnings"] + job.scene_warnings():
            job.warn(warning)
        job.run()
    except manylight.Error as error:
        raise RenderFailed(error) from None


def package():
    try:
        import manylight
    except ImportError:
        import sys

        raise RenderFailed(MISSING.format(python=sys.executable)) from None
    return manylight


class Job:
    """The render of one view layer."""

    def __init__(self, engine, manylight, exported, options, scene, view_layer):
        self.engine, self.manylight, self.exported, self.options = engine, manylight, exported, options
        self.passes = passes.enabled(view_layer, TERMS)
        self.groups = passes.of_light_groups(view_layer)
        self.is_transparent = scene.render.film_transparent
        self.frame = {}
        if exported["cameras"]:
            self.frame = {"cameras": exported["cameras"], "frame": scene.frame_current - scene.frame_start + 1}
        self.view_layer = view_layer
        engine.update_stats("", "Loading the scene")
        self.scene = self.load("scene.glb", exported["environment"])

    def load(self, name, environment):
        path = f"{self.engine.folder}/{name}"
        return self.manylight.load_file(path, light_units="W", environment=environment)

    def scene_warnings(self):
        """Warnings of the loader, without those that advise an option of the command."""
        return [str(warning) for warning in self.scene.warnings if "--environment" not in str(warning)]

    def warn(self, warning):
        self.engine.report({"WARNING"}, f"manylight: {warning}")

    def window(self):
        """Keywords for the film and the rendered part of it."""
        size, (x, y, width, height) = self.exported["size"], self.exported["window"]
        if (x, y, width, height) == (0, 0, *size):
            return {"size": tuple(size)}
        crop = (x / size[0], (x + width) / size[0], y / size[1], (y + height) / size[1])
        return {"size": tuple(size), "crop": crop}

    def run(self):
        engine = self.engine
        _, _, width, height = self.exported["window"]
        for name, channels, _ in self.passes:
            engine.add_pass(name, len(channels), channels, layer=self.view_layer.name)
        result = engine.begin_result(0, 0, width, height, layer=self.view_layer.name)
        try:
            self.fill(result)
        finally:
            # A cancelled render keeps the picture so far.
            engine.end_result(result)

    def fill(self, result):
        background = self.background()
        surfaces = self.surface_passes()
        self.engine.update_stats("", "Rendering")
        shown_at, started, image = 0.0, time.monotonic(), None
        for image in self.images():
            if time.monotonic() - shown_at > UPDATE_INTERVAL:
                self.show(result, image, background, surfaces)
                self.engine.update_result(result)
                shown_at = time.monotonic()
            self.report_progress(image.passes, time.monotonic() - started)
            if self.engine.is_cancelled():
                break
        if image is None:
            raise RenderFailed("the render ended before its first pass")
        self.show(result, image, background, surfaces)

    def images(self):
        """The picture after each pass, or the denoised one at the end."""
        options = self.options | self.window() | {"hide_emitters": self.exported["hide_emitters"]}
        if self.groups:
            options["light_groups"] = True
        if self.frame:
            options |= self.frame | walkthrough.kept(self.manylight, self.scene, self.frame["cameras"], options, self.warn)
        if "denoise" not in options:
            yield from self.scene.passes(**options)
            return

        def progress(passes_done, _, seconds):
            self.report_progress(passes_done, seconds)
            if self.engine.is_cancelled():
                raise launch.Cancelled

        yield self.manylight.render(self.scene, progress=progress, **options)

    def report_progress(self, passes_done, seconds):
        parts = []
        if "passes" in self.options:
            parts.append(passes_done / self.options["passes"])
        if "time" in self.options:
            parts.append(seconds / self.options["time"])
        self.engine.update_progress(min(1.0, max(parts, default=0.0)))
        total = self.options.get("passes")
        self.engine.update_stats("", f"Pass {passes_done}" + (f" of {total}" if total else ""))

    def background(self):
        """What the camera sees behind all surfaces: (3,) or (height, width, 3); None if the picture has it."""
        if not self.exported["hide_emitters"] or self.is_transparent:
            return None
        if not self.exported["background"]:
            return np.array(self.exported["background_color"], np.float32)
        scene = self.load("background.glb", self.exported["background"])
        options = {"passes": SURFACE_SAMPLES, "filter": self.options["filter"], "max_depth": 1} | self.window()
        return np.asarray(self.manylight.render(scene, method="path", **options))

    def surface_passes(self):
        """Passes that describe the first surface."""
        names = passes.of_surfaces(self.view_layer, TERMS)
        if not names:
            return {}
        self.engine.update_stats("", "Rendering the passes of surfaces")
        options = {"passes": SURFACE_SAMPLES, "filter": self.options["filter"], "hide_emitters": True} | self.window() | self.frame
        image = self.manylight.render(self.scene, method="aov", aov=["position"], **options)
        found = passes.surface_passes(image.layers, self.exported["camera"])
        return {name: values for name, values in found.items() if name in names}

    def show(self, result, image, background, surfaces):
        """Fills the passes of the result."""
        picture = np.asarray(image)
        alpha = image.layers.get("alpha", np.ones(picture.shape[:2], np.float32))
        behind = passes.behind(alpha, background)
        shown = {"Combined": passes.combined(picture, alpha, behind, self.is_transparent)} | surfaces
        shown |= {name: image.layers[name] for name, _, _ in self.passes if name in TERMS and name in image.layers}
        if self.groups:
            shown |= passes.light_groups(image.layers, self.groups, self.exported["world_group"], behind)
        layer = result.layers[0]
        for name, values in shown.items():
            target = layer.passes.find_by_name(name, "")
            if target:
                target.rect.foreach_set(np.ascontiguousarray(values[::-1], np.float32).ravel())


def register():
    bpy.utils.register_class(ManylightEngine)


def unregister():
    walkthrough.forget()
    bpy.utils.unregister_class(ManylightEngine)
