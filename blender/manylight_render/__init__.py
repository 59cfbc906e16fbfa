# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine "manylight" of Blender: renders by the Python package `manylight`."""

from . import engine, panels, settings


def register():
    settings.register()
    engine.register()
    panels.register()


def unregister():
    panels.unregister()
    engine.unregister()
    settings.unregister()
