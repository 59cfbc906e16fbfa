# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual lights of an animation in which nothing but the camera moves: kept from frame to frame."""

import os
import shutil
import tempfile

# Folder and settings of the lights of the last walkthrough.
_kept = None


def kept(manylight, scene, cameras, settings, warn):
    """Keywords of `manylight.render` for a frame: the first one keeps the lights of all in a file, the others shade by them.
    `settings`: its other keywords; `warn` takes a warning."""
    global _kept
    settings = {name: value for name, value in settings.items() if name != "threads"}
    if not manylight.keeps_lights(**settings):
        return {}
    made_by = (scene.digest, cameras, settings)
    if _kept is None or _kept[1] != made_by:
        if _kept is not None and _kept[1][1:] == made_by[1:]:
            warn("something besides the camera moves in this walkthrough: the lights are made anew")
        forget()
        _kept = (tempfile.mkdtemp(prefix="manylight_lights_"), made_by)
    file = os.path.join(_kept[0], "walk.lights")
    return {"lights_in" if os.path.exists(file) else "lights_out": file}


def forget():
    """Deletes the lights."""
    global _kept
    if _kept is not None:
        shutil.rmtree(_kept[0], ignore_errors=True)
        _kept = None
