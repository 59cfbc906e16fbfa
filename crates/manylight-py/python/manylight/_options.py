"""Keywords as words of the command line of ``manylight render``. The native module knows the options: names, help and defaults."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from . import _native

#: The options of a render by keyword: help, default (None if there is none), and whether they belong to loading the scene.
OPTIONS = _native.options()

# Options of the command that have another form here, or belong to its messages.
_OTHERWISE = {
    "output": "save the image by `Image.save`",
    "shard": "see `render_part`",
    "json": "see `Image.metadata`",
    "preview": "use the command `manylight render --preview`",
    "cameras": "see `frames`",
    "frames": "see `frames`",
    "skip_existing": "see `distributed.render_frames`",
    "quiet": "nothing is printed",
    "verbose": "see `Image.metadata`",
} | {name: "give it to `load_file`" for name, (_, _, loads_scene) in OPTIONS.items() if loads_scene}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def default(name: str) -> Any:
    """The value of an option of a render where it is not given."""
    return OPTIONS[name][1]


def with_options(function: _Function) -> _Function:
    """Appends the options that ``function`` takes beyond its own arguments to its documentation."""
    own = inspect.signature(function).parameters
    others = [f"    {name}: {text}." for name, (text, _, _) in OPTIONS.items() if name not in own and name not in _OTHERWISE]
    if function.__doc__ is not None:
        function.__doc__ = "\n".join([inspect.cleandoc(function.__doc__), "", "Options:", *others, ""])
    return function


def render_words(options: Mapping[str, object]) -> list[str]:
    """The words of options of a render. None and False stand for an option that is not given.

    Raises:
        TypeError: A keyword belongs to another function, or its value has no text.
    """
    for name in options:
        if name in _OTHERWISE:
            raise TypeError(f"unexpected keyword {name!r}: {_OTHERWISE[name]}")
    return words(options)


def is_given(value: object) -> bool:
    """Whether an option is given; None and False mean that it is not."""
    return value is not None and value is not False


def words(options: Mapping[str, object]) -> list[str]:
    """The words of any options."""
    result: list[str] = []
    for name, value in options.items():
        if not is_given(value):
            continue
        option = "--" + name.replace("_", "-")
        result.append(option if value is True else f"{option}={_text(name, value)}")
    return result


def _text(name: str, value: object) -> str:
    if isinstance(value, Mapping):
        return ",".join(f"{key}={_text(name, item)}" for key, item in value.items())
    if isinstance(value, (tuple, list)):
        return ",".join(_text(name, item) for item in value)
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if hasattr(value, "item"):  # a number of numpy
        value = value.item()
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return repr(value)
    raise TypeError(f"{name}: found {type(value).__name__}, expected a number, text, or a sequence or dictionary of them")
