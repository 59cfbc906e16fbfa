"""Virtual lights that ``manylight render --lights-out`` keeps, as arrays."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FileError

__all__ = ["Lights", "octahedral_directions", "read_lights"]

_TYPES = {"F32": np.dtype("<f4"), "U32": np.dtype("<u4")}
_DIGEST = "manylight.sha256"
_HEADER = "manylight.lights"


@dataclass(frozen=True, eq=False)
class Lights:
    """The virtual lights of a group of passes.

    Attributes:
        passes: The passes that shade with them.
        arrays: All arrays of the group by name; docs/kept_lights.md lists them.
        options: Method and options of virtual lights, by the names of the command.
    """

    passes: range
    arrays: Mapping[str, NDArray[Any]]
    options: Mapping[str, str]

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def positions(self) -> NDArray[np.float32]:
        """(n, 3), in m."""
        return self.arrays["lights.p"]

    @property
    def normals(self) -> NDArray[np.float32]:
        """(n, 3): geometric normals on the lit side, unit."""
        return self.arrays["lights.n"]

    @property
    def flux(self) -> NDArray[np.float32]:
        """(n, 3): flux that arrives at the light, in W."""
        return self.arrays["lights.flux"]

    @property
    def table_indices(self) -> NDArray[np.int64]:
        """(n,): which of ``tables()`` is that of a light; -1 for lights without a glossy part."""
        profiles = self.arrays["lights.profile"].astype(np.int64)
        return np.where(profiles == 0xFFFFFFFF, -1, profiles)

    def tables(self, indices: ArrayLike | None = None) -> NDArray[np.float32]:
        """Radiant intensity of glossy parts, in W/sr: (tables, side, side, 3), rows and columns as in
        ``octahedral_directions``. Only with ``--emission table``.

        Args:
            indices: Which tables; None: all.
        """
        scales = self.arrays["tables.scale"]
        side, storage = int(self.options["table-size"]), self.options["table-storage"]
        ends = np.concatenate([[0], self.arrays["tables.end"]])
        chosen = range(len(scales)) if indices is None else np.atleast_1d(indices)
        tables = np.empty((len(chosen), side, side, 3), np.float32)
        for i, table in enumerate(chosen):
            words = self.arrays["tables.texels"][ends[table] : ends[table + 1]]
            tables[i] = _TEXELS[storage](words, side) * scales[table]
        return tables


def _floats(words: NDArray[np.uint32], side: int) -> NDArray[np.float32]:
    return words.view(np.float32).reshape(side, side, 3)


def _shared_exponents(words: NDArray[np.uint32], side: int) -> NDArray[np.float32]:
    """Three mantissas of 9 bits with an exponent of 5 bits, as of EXT_texture_shared_exponent."""
    mantissas = np.stack([words >> shift & 511 for shift in (0, 9, 18)], axis=-1)
    exponents = (words >> 27).astype(np.int32) - 24
    return np.ldexp(mantissas.astype(np.float32), exponents[:, None]).reshape(side, side, 3)


def _blocks(words: NDArray[np.uint32], side: int) -> NDArray[np.float32]:
    """Blocks of 4 x 4 texels: a byte per block, then three words for each block that is stored."""
    across = -(-side // 4)
    numbers = words.view(np.uint8)[: across**2]
    low, header, high = words[-(-(across**2) // 4) :].reshape(-1, 3).T
    levels = np.concatenate([words[:, None] >> np.arange(0, 32, 4, dtype=np.uint32) & 15 for words in (low, high)], axis=1) / 15
    offset, red, blue = (header & 15) / 15, (header >> 4 & 127) / 127, (header >> 11 & 127) / 127
    largest = np.ldexp((header >> 18 & 31) + 32.0, (header >> 23).astype(np.int32) - 20)
    sums = (largest * offset)[:, None] + (largest * (1 - offset))[:, None] * levels
    colors = np.stack([red, np.maximum(1 - red - blue, 0), blue], axis=-1)
    texels = (sums[:, :, None] * colors[:, None, :]).astype(np.float32)[numbers]
    rows = texels.reshape(across, across, 4, 4, 3).swapaxes(1, 2).reshape(4 * across, 4 * across, 3)
    return rows[:side, :side]


_TEXELS = {"float": _floats, "shared": _shared_exponents, "blocks": _blocks}


def octahedral_directions(side: int) -> NDArray[np.float32]:
    """The unit directions of the centers of a table's texels: (side, side, 3).

    Source: Engelhardt and Dachsbacher, "Octahedron Environment Maps", VMV 2008.
    """
    grid = (np.arange(side, dtype=np.float32) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(grid, grid)
    z = 1 - np.abs(x) - np.abs(y)
    below = z < 0
    folded = np.copysign(1 - np.abs(y), x), np.copysign(1 - np.abs(x), y)
    w = np.stack([np.where(below, folded[0], x), np.where(below, folded[1], y), z], axis=-1)
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def read_lights(file: str | os.PathLike[str]) -> list[Lights]:
    """Reads virtual lights that ``manylight render --lights-out`` has written, group of passes by group.

    The arrays are views of the file, and cannot be changed.

    Raises:
        FileError: The file cannot be read, is damaged, or is none of virtual lights.
    """
    path = os.fspath(file)
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileError(error.strerror or str(error), file=path) from error
    head, start = _head(data, path)
    header = json.loads(head["__metadata__"][_HEADER])
    options = dict(word.removeprefix("--").split("=", 1) for word in header["options"])
    groups: dict[int, dict[str, NDArray[Any]]] = {}
    for name, info in head.items():
        if name == "__metadata__":
            continue
        _, group, own = name.split(".", 2)
        begin, end = info["data_offsets"]
        array = np.frombuffer(data[start + begin : start + end], dtype=_TYPES[info["dtype"]])
        groups.setdefault(int(group), {})[own] = array.reshape(info["shape"])
    return [Lights(range(*map(int, groups[group]["passes"])), groups[group], options) for group in sorted(groups)]


def _head(data: bytes, path: str) -> tuple[dict[str, Any], int]:
    """The header of a file, and where its arrays begin."""
    length = int.from_bytes(data[:8], "little")
    try:
        head = json.loads(data[8 : 8 + length])
        metadata = head["__metadata__"]
        digest = metadata[_DIGEST]
        metadata[_HEADER]
    except (ValueError, KeyError, TypeError) as error:
        raise FileError("found no file of virtual lights", file=path) from error
    stated = digest.encode()
    blank = data[: 8 + length].replace(stated, b"0" * len(stated), 1) + data[8 + length :]
    if hashlib.sha256(blank).hexdigest() != digest:
        raise FileError("the checksum does not fit the content: the file is damaged", file=path)
    return head, 8 + length
