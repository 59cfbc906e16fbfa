"""Renders on a Dask cluster, with the bits of one run of `manylight.render`.

Workers render shares of the blocks of passes to part files in a folder that all machines see. Only paths and hashes go
over the network. The calling process merges the parts. See docs/farms/dask.md.

Needs the package ``distributed``: ``pip install manylight[distributed]``.
"""

from .driver import Report, render
from .frames import render_frames

__all__ = ["Report", "render", "render_frames"]
