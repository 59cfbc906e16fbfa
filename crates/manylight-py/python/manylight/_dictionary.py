"""Scenes in dictionaries as Mitsuba's ``load_dict`` takes them, written as XML with one element per line."""

from __future__ import annotations

import contextlib
import difflib
import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from ._plugins import TAGS
from .errors import Error, SceneError

# Most dictionaries within each other, fewer than the levels that a scene file may have.
_MOST_LEVELS = 90

# A character that XML cannot have: most control characters, and halves of surrogate pairs, which stand for bytes of file names.
_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

# Plugins that XML writes as values.
_VALUES = ("rgb", "srgb", "spectrum", "blackbody", "ref")


@dataclass(frozen=True)
class SceneText:
    """A scene in a file, and the keys of its lines."""

    path: str
    keys: list[str]

    def located(self, error: Error) -> Error:
        """The error with the keys of its line in the dictionary instead of a file."""
        if error.file != self.path:
            return error
        key = self._key(error.line)
        return type(error)(error.message, suggestion=error.suggestion, code=error.code, key=key)

    def warning(self, text: str) -> str:
        """A warning with the keys of its line instead of a file."""
        place = re.compile(re.escape(self.path) + r":(\d+):\d+")
        return place.sub(lambda found: self._key(int(found[1])), text)

    def _key(self, line: int | None) -> str:
        return self.keys[line - 1] if line is not None and line <= len(self.keys) else ""


@contextlib.contextmanager
def written(scene: Mapping) -> Iterator[SceneText]:
    """The scene in a temporary folder, with files for its arrays."""
    with tempfile.TemporaryDirectory(prefix="manylight-") as folder:
        writer = _Writer(folder)
        writer.root(scene)
        path = os.path.join(folder, "scene.xml")
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(writer.lines) + "\n")
        yield SceneText(path, writer.keys)


class _Writer:
    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.lines: list[str] = []
        self.keys: list[str] = []
        self.files = 0

    def line(self, text: str, keys: tuple[str, ...]) -> None:
        if found := _NOT_IN_XML.search(text):
            key = _NOT_IN_XML.sub("?", ".".join(keys))
            raise SceneError(f"found the character {found[0]!r}", suggestion="texts of a scene cannot have it", key=key)
        # A line break in a text would shift the lines that follow.
        self.lines.append(text.replace("\n", "&#10;"))
        self.keys.append(".".join(keys))

    def root(self, scene: Mapping) -> None:
        if not isinstance(scene, Mapping) or scene.get("type") != "scene":
            found = scene.get("type") if isinstance(scene, Mapping) else type(scene).__name__
            raise SceneError(f"found {found!r}", suggestion="expected a dictionary with 'type': 'scene'", key="type")
        self.line('<scene version="3.0.0">', ())
        self.children(scene, ())
        self.line("</scene>", ())

    def children(self, plugin: Mapping, keys: tuple[str, ...]) -> None:
        for key, value in plugin.items():
            if not isinstance(key, str):
                raise SceneError(f"found the key {key!r}", suggestion="expected text", key=".".join(keys))
            if key not in ("type", "id"):
                self.entry(key, value, (*keys, key))

    def entry(self, name: str, value: object, keys: tuple[str, ...]) -> None:
        if isinstance(value, Mapping):
            self.plugin(name, value, keys)
            return
        tag, text = _value(name, value, keys)
        if tag == "transform":
            self.line(f'<transform name={quoteattr(name)}><matrix value="{text}"/></transform>', keys)
        else:
            self.line(f"<{tag} name={quoteattr(name)} value={quoteattr(text)}/>", keys)

    def plugin(self, name: str, plugin: Mapping, keys: tuple[str, ...]) -> None:
        if len(keys) > _MOST_LEVELS:
            message = f"found more than {_MOST_LEVELS} dictionaries within each other"
            raise SceneError(message, suggestion="does one contain itself?", key=".".join((*keys[:4], "...")))
        kind = plugin.get("type")
        if not isinstance(kind, str):
            raise SceneError("found a dictionary without 'type'", suggestion="expected the name of a plugin", key=".".join(keys))
        if kind in _VALUES and not (kind == "spectrum" and "type" in plugin and len(plugin) == 1):
            self.line(_value_plugin(name, kind, plugin, keys), keys)
            return
        plugin = self.with_files(kind, plugin, keys)
        kind = plugin["type"]
        tag = _tag(kind, keys)
        # A child of the scene is known by its key.
        identity = plugin.get("id", name if len(keys) == 1 else None)
        attributes = f"type={quoteattr(kind)} name={quoteattr(name)}"
        if identity is not None:
            attributes += f" id={quoteattr(str(identity))}"
        self.line(f"<{tag} {attributes}>", keys)
        self.children(plugin, keys)
        self.line(f"</{tag}>", keys)

    def with_files(self, kind: str, plugin: Mapping, keys: tuple[str, ...]) -> Mapping:
        """The plugin with file names instead of arrays."""
        if kind == "mesh":
            arrays = {name: plugin[name] for name in ("vertices", "faces", "normals", "uvs") if name in plugin}
            path = self.new_file("ply")
            _write_ply(path, arrays, ".".join(keys))
            rest = {name: value for name, value in plugin.items() if name not in arrays and name != "type"}
            return {"type": "ply", "filename": path, **rest}
        if kind in ("bitmap", "envmap") and "data" in plugin:
            path = self.new_file("pfm")
            _write_pfm(path, plugin["data"], ".".join(keys))
            rest = {name: value for name, value in plugin.items() if name != "data"}
            return {**rest, "filename": path}
        return plugin

    def new_file(self, extension: str) -> str:
        self.files += 1
        return os.path.join(self.folder, f"{self.files}.{extension}")


def _tag(kind: str, keys: tuple[str, ...]) -> str:
    if kind in TAGS:
        return TAGS[kind]
    near = difflib.get_close_matches(kind, [*TAGS, "mesh", *_VALUES], n=1)
    suggestion = f"did you mean '{near[0]}'?" if near else "see `manylight list bsdfs`, `shapes`, `emitters` and others"
    raise SceneError(f"found the unknown plugin {kind!r}", suggestion=suggestion, code="scene::unknown_plugin", key=".".join(keys))


def _value_plugin(name: str, kind: str, plugin: Mapping, keys: tuple[str, ...]) -> str:
    attributes = []
    for key, value in plugin.items():
        if key != "type":
            attributes.append(f"{key}={quoteattr(_value_text(kind, key, value, keys))}")
    return f"<{kind} name={quoteattr(name)} {' '.join(attributes)}/>"


def _value_text(kind: str, key: str, value: Any, keys: tuple[str, ...]) -> str:
    if key == "filename":
        return os.path.abspath(os.fspath(value))
    is_table = kind == "spectrum" and isinstance(value, Sequence) and not isinstance(value, str)
    if is_table and all(np.size(pair) == 2 for pair in value):
        return ", ".join(f"{float(length)!r}:{float(v)!r}" for length, v in value)
    if isinstance(value, str):
        return value
    numbers = np.asarray(value)
    if numbers.dtype.kind in "iuf" and numbers.ndim <= 1:
        return " ".join(repr(float(number)) for number in np.atleast_1d(numbers))
    raise _unexpected(value, keys)


def _value(name: str, value: object, keys: tuple[str, ...]) -> tuple[str, str]:
    """Tag and text of a value."""
    if isinstance(value, (bool, np.bool_)):
        return "boolean", str(bool(value)).lower()
    if isinstance(value, (int, np.integer)):
        return "integer", str(int(value))
    if isinstance(value, (float, np.floating)):
        return "float", repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        text = os.fspath(value)
        return "string", os.path.abspath(text) if name == "filename" else text
    if value is None:
        raise _unexpected(value, keys)
    try:
        numbers = _numbers(value)
    except (TypeError, ValueError, AttributeError, OverflowError, RecursionError):
        raise _unexpected(value, keys) from None
    if numbers.shape in ((4, 4), (3, 3)):
        return "transform", " ".join(map(repr, numbers.ravel().tolist()))
    if numbers.shape == (3,):
        return "vector", " ".join(map(repr, numbers.tolist()))
    if numbers.size == 1:
        return "float", repr(float(numbers.item()))
    raise _unexpected(value, keys)


def _numbers(value: Any) -> np.ndarray:
    """An array of numbers; of the matrix for transforms of Mitsuba."""
    try:
        return np.asarray(value, dtype=np.float64)
    except TypeError:
        return np.asarray(value.matrix, dtype=np.float64)


def _unexpected(value: object, keys: tuple[str, ...]) -> Error:
    shape = getattr(value, "shape", None)
    found = type(value).__name__ if shape is None else f"an array of shape {tuple(shape)}"
    return SceneError(
        f"found {found}",
        suggestion="expected a number, text, a boolean, three numbers, a 4x4 matrix, or a dictionary with 'type'",
        key=".".join(keys),
    )


def _finite(value: object, kind: type, key: str) -> np.ndarray:
    """A copy of an array of finite numbers, as an array of this type."""
    try:
        given = value.filled(np.nan) if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value) else np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        raise SceneError("found rows of different lengths, or other values", suggestion="expected an array of numbers", key=key) from None
    if given.dtype.kind not in "iuf":
        raise SceneError(f"found an array of {given.dtype}", suggestion="expected an array of numbers", key=key)
    is_float = np.issubdtype(kind, np.floating)
    with np.errstate(over="ignore", invalid="ignore"):
        array: np.ndarray = np.array(given, dtype=kind, order="C")
        # Indices may come as floating-point numbers, but each is an integer.
        fits = np.isfinite(array) if is_float else array == given
    if not np.all(fits):
        first = tuple(np.argwhere(~fits)[0].tolist())
        expected = "finite numbers of 32 bits" if is_float else "integers"
        raise SceneError(f"found {given[first]} at {list(first)}", suggestion=f"expected {expected}", key=key)
    return array


def _array(value: object, kind: type, shape: tuple[int | None, ...], key: str) -> np.ndarray:
    """An array of finite numbers of this shape, in which None is any length."""
    array = _finite(value, kind, key)
    fits = array.ndim == len(shape) and all(want is None or have == want for have, want in zip(array.shape, shape))
    if not fits:
        raise _misshapen(array, "(" + ", ".join("n" if length is None else str(length) for length in shape) + ")", key)
    return array


def _misshapen(array: np.ndarray, expected: str, key: str) -> Error:
    return SceneError(f"found an array of shape {array.shape}", suggestion=f"expected {expected}", key=key)


def _write_ply(path: str, arrays: Mapping[str, object], key: str) -> None:
    """A binary PLY file of triangles."""
    for name in ("vertices", "faces"):
        if name not in arrays:
            raise SceneError(f"found no '{name}'", suggestion="a mesh has the arrays 'vertices' and 'faces'", key=key)
    vertices = _array(arrays["vertices"], np.float32, (None, 3), f"{key}.vertices")
    faces = _array(arrays["faces"], np.int64, (None, 3), f"{key}.faces")
    outside = faces[(faces < 0) | (faces >= len(vertices))]
    if outside.size:
        raise SceneError(f"found the index {outside[0]} of {len(vertices)} vertices", key=f"{key}.faces")
    columns, names = [vertices], ["x", "y", "z"]
    if "normals" in arrays:
        columns.append(_array(arrays["normals"], np.float32, (len(vertices), 3), f"{key}.normals"))
        names += ["nx", "ny", "nz"]
    if "uvs" in arrays:
        columns.append(_array(arrays["uvs"], np.float32, (len(vertices), 2), f"{key}.uvs"))
        names += ["u", "v"]
    triangles = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode() + b"\n")
        file.write(np.hstack(columns).astype("<f4").tobytes())
        file.write(triangles.tobytes())


def _write_pfm(path: str, data: object, key: str) -> None:
    """A portable float map of linear values."""
    key = f"{key}.data"
    pixels = _finite(data, np.float32, key)
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[:, :, 0]
    is_image = pixels.ndim == 2 or (pixels.ndim == 3 and pixels.shape[2] == 3)
    if not is_image or pixels.size == 0:
        raise _misshapen(pixels, "(height, width) or (height, width, 3), with at least one pixel", key)
    height, width = pixels.shape[:2]
    with open(path, "wb") as file:
        file.write(f"{'PF' if pixels.ndim == 3 else 'Pf'}\n{width} {height}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(pixels[::-1], dtype="<f4").tobytes())
