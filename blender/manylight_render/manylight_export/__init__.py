# SPDX-License-Identifier: GPL-3.0-or-later
"""From a Blender scene to files that manylight reads. `worker` runs in a background Blender; the other modules serve it."""
