# SPDX-License-Identifier: GPL-3.0-or-later
"""The export of a scene by a background Blender, so that neither the user's data nor the window is touched."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np

WORKER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "manylight_export", "worker.py")
# Seconds between checks whether the user has cancelled.
POLL = 0.05


class ExportError(Exception):
    """The scene cannot be exported; the message says why."""


class Cancelled(Exception):
    """The user has cancelled the render."""


def request(engine, depsgraph, needs_coverage, folder):
    """Writes a copy of the scene and the request for it to `folder`. Reads the data of Blender: to be called while these are
    locked, by `RenderEngine.update`. `needs_coverage`: whether alpha has to be the part that surfaces cover. The path of the
    request."""
    scene = depsgraph.scene.original
    blend = os.path.join(folder, "scene.blend")
    bpy.data.libraries.write(blend, {scene}, path_remap="ABSOLUTE", fake_user=True)
    size = picture_size(scene.render)
    camera = engine.camera_override
    content = {
        "blend": blend,
        "scene": scene.name,
        "view_layer": depsgraph.view_layer.name,
        "frame": scene.frame_current,
        "subframe": scene.frame_subframe,
        "frames": walk_frames(scene),
        "camera": camera.name if camera and camera.original != scene.camera else None,
        "needs_coverage": needs_coverage,
        "size": size,
        "border": border(scene.render, size),
    }
    path = os.path.join(folder, "request.json")
    with open(path, "w") as file:
        json.dump(content, file)
    return path


def walk_frames(scene):
    """First and last frame of a walkthrough; None for pictures with lights of their own. Raises ValueError."""
    if not scene.manylight.walkthrough:
        return None
    first, last = scene.frame_start, scene.frame_end
    if not first <= scene.frame_current <= last:
        raise ValueError(f"frame {scene.frame_current} of a walkthrough is not within the frames {first} to {last} of the scene")
    return [first, last]


def picture_size(render):
    """Width and height of the picture in pixels."""
    return [edge * render.resolution_percentage // 100 for edge in (render.resolution_x, render.resolution_y)]


def border(render, size):
    """The rendered part in pixels: first column, first row from the top, width, height. Rounded as Blender does, in single
    precision."""
    if not render.use_border:
        return [0, 0, *size]
    edges = np.float32([render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y])
    left, right, bottom, top = (edges * np.float32([size[0], size[0], size[1], size[1]])).astype(int).tolist()
    return [left, size[1] - top, right - left, top - bottom]


def command(path):
    """The command that runs the worker: Blender itself, or Python where Blender is a module."""
    if bpy.app.binary_path:
        scripts = ["--enable-autoexec"] if bpy.context.preferences.filepaths.use_scripts_auto_execute else []
        options = ["--background", "--factory-startup", *scripts, "--python-exit-code", "1", "--python", WORKER, "--"]
        return [bpy.app.binary_path, *options, path]
    return [sys.executable, WORKER, path]


def run(path, is_cancelled):
    """Runs the worker; its result as a dictionary."""
    log_path = os.path.join(os.path.dirname(path), "export.log")
    with open(log_path, "w") as log:
        process = subprocess.Popen(command(path), stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        while True:
            try:
                process.wait(POLL)
                break
            except subprocess.TimeoutExpired:
                if is_cancelled():
                    process.kill()
                    process.wait()
                    raise Cancelled from None
    result_path = os.path.join(os.path.dirname(path), "result.json")
    if not os.path.exists(result_path):
        with open(log_path, errors="replace") as log:
            tail = log.read()[-2000:]
        raise ExportError(f"the background Blender that exports the scene ended with code {process.returncode}:\n{tail}")
    with open(result_path) as file:
        result = json.load(file)
    if "error" in result:
        raise ExportError(result["error"])
    return result
