"""Keywords as words of the command line of ``manylight render``."""

from __future__ import annotations

import os
from collections.abc import Mapping

# Options of the command that have another form here, or belong to its messages.
_OTHERWISE = {
    "output": "save the image by `Image.save`",
    "shard": "see `render_part`",
    "json": "see `Image.metadata`",
    "preview": "use the command `manylight render --preview`",
    "quiet": "nothing is printed",
    "verbose": "see `Image.metadata`",
    "strict": "give it to `load_file`",
    "light_units": "give it to `load_file`",
    "environment": "give it to `load_file`",
    "environment_scale": "give it to `load_file`",
    "variant": "give it to `load_file`",
}


def render_words(options: Mapping[str, object]) -> list[str]:
    """The words of options of a render. None and False stand for an option that is not given.

    Raises:
        TypeError: A keyword belongs to another function, or its value has no text.
    """
    for name in options:
        if name in _OTHERWISE:
            raise TypeError(f"unexpected keyword {name!r}: {_OTHERWISE[name]}")
    return words(options)


def words(options: Mapping[str, object]) -> list[str]:
    """The words of any options."""
    result: list[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        option = "--" + name.replace("_", "-")
        result.append(option if value is True else f"{option}={_text(name, value)}")
    return result


def _text(name: str, value: object) -> str:
    if name == "size" and isinstance(value, (tuple, list)):
        return "x".join(str(edge) for edge in value)
    if isinstance(value, (tuple, list)):
        return ",".join(_text(name, item) for item in value)
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if hasattr(value, "item"):  # a number of numpy
        value = value.item()
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return repr(value)
    raise TypeError(f"{name}: found {type(value).__name__}, expected a number, text, or a sequence of them")
