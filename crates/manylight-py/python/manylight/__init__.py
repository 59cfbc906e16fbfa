"""manylight: a photorealistic renderer for glossy interiors, indirect light and very many emitters.

    import manylight as ml

    scene = ml.load_file("scene.xml")
    image = ml.render(scene, passes=64, progress=True)
    image.save("scene.exr")

Radiance is linear RGB in W/(m² sr); arrays have the shape (height, width, channels), rows from top to bottom.
Names and meanings of options are those of the command ``manylight render``, which the package contains, too.
"""

from . import transforms
from ._frames import frames, keeps_lights
from ._lights import Lights, octahedral_directions, read_lights
from ._maps import LightPositions, Maps, maps
from ._native import Image, __version__, instruction_set
from ._render import Comparison, compare, merge, part_info, read_image, render, render_part
from ._scene import Scene, load_dict, load_file
from .errors import ComponentError, Error, FileError, RenderError, SceneError, UsageError

__all__ = [
    "Comparison",
    "ComponentError",
    "Error",
    "FileError",
    "Image",
    "LightPositions",
    "Lights",
    "Maps",
    "RenderError",
    "Scene",
    "SceneError",
    "UsageError",
    "__version__",
    "compare",
    "frames",
    "instruction_set",
    "keeps_lights",
    "load_dict",
    "load_file",
    "maps",
    "merge",
    "octahedral_directions",
    "part_info",
    "read_image",
    "read_lights",
    "render",
    "render_part",
    "transforms",
]
