"""The folder that the driver and all workers see: part files, what they are parts of, and counts of attempts.

| file | holds |
|---|---|
| ``render.json`` | scene digest, version, settings, and instruction set of the workers; a call with others is refused |
| ``blocks-00004-00008.part`` | the blocks 4 to 7, written whole or not at all |
| ``blocks-00004-00008.part.ATTEMPT.passes`` | passes that an attempt has rendered, for the count of repeated work |
"""

import contextlib
import json
import os
import shutil
import tempfile
import time
import uuid
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import manylight as ml

from .shares import blocks_of, disjoint, part_name

_MANIFEST = "render.json"
_ATTEMPT = ".passes"
#: Seconds that a file of another machine may take to be seen. NFS keeps attributes of folders up to 60 s by default.
_VISIBLE_AFTER = 90.0


class Folder:
    """The folder of one render. ``temporary`` folders are deleted at the end, whatever happens."""

    def __init__(self, path: os.PathLike | None, render: Mapping[str, Any]):
        self.temporary = path is None
        if path is None:
            self.path = Path(tempfile.mkdtemp(prefix="manylight-"))
        else:
            self.path = Path(path).absolute()
        made = not self.path.exists()
        _attempt_io(self.path, lambda: self.path.mkdir(parents=True, exist_ok=True))
        self.claim("render", render)
        if "folder" not in self._manifest():
            self.claim("folder", {"made": made})

    def claim(self, section: str, values: Mapping[str, Any]) -> None:
        """Writes what the parts have in common, or compares it with what the folder has.

        Raises UsageError if the folder has parts of another render.
        """
        values = json.loads(json.dumps(values, default=str))
        manifest = self.path / _MANIFEST
        found = self._manifest()
        if section not in found:
            if section == "render" and self.found():
                raise ml.UsageError(
                    f"folder: {self.path} has part files, but no {_MANIFEST} that says of which render",
                    suggestion="give another folder",
                )
            _write(manifest, json.dumps({**found, section: values}, indent=1, sort_keys=True))
            return
        old = found[section]
        differences = [
            f"{key}: found {json.dumps(old.get(key))}, expected {json.dumps(values.get(key))}"
            for key in sorted({*old, *values})
            if old.get(key) != values.get(key)
        ]
        if differences:
            raise ml.UsageError(
                f"folder: {self.path} has parts of another render ({'; '.join(differences)})",
                suggestion="give another folder, or delete this one",
            )

    def _manifest(self) -> dict[str, dict[str, Any]]:
        manifest = self.path / _MANIFEST
        if not manifest.exists():
            return {}
        text = _attempt_io(manifest, manifest.read_text)
        try:
            return {section: dict(values) for section, values in json.loads(text).items()}
        except (ValueError, AttributeError, TypeError) as error:
            raise ml.FileError(f"damaged: {error}", file=str(manifest), suggestion="delete the folder, or give another") from None

    def part(self, blocks: range) -> Path:
        """Path of the part file of a share."""
        return self.path / part_name(blocks)

    def found(self) -> list[range]:
        """The shares with a part file, without those that overlap one before them. The files are not read."""
        shares = (blocks_of(name) for name in _attempt_io(self.path, lambda: os.listdir(self.path)))
        return disjoint(blocks for blocks in shares if blocks is not None)

    def passes_of_attempts(self) -> dict[str, int]:
        """Passes that each attempt has rendered, by the name of its file."""
        counts = {}
        for file in self.path.glob(f"*{_ATTEMPT}"):
            try:
                counts[file.name] = int(file.read_text() or 0)
            except (OSError, ValueError):
                counts[file.name] = 0
        return counts

    def wait_for(self, files: Iterable[Path]) -> None:
        """Waits until this machine sees the files, which another machine may have written a moment ago."""
        deadline = time.monotonic() + _VISIBLE_AFTER
        for file in files:
            while not file.exists() and time.monotonic() < deadline:
                # Reading the folder makes network file systems look for new files.
                os.listdir(self.path)
                time.sleep(0.1)

    def clean(self) -> None:
        """Deletes the files of the render, and the folder if a call has made it."""
        if self.temporary:
            shutil.rmtree(self.path, ignore_errors=True)
            return
        made = self._manifest().get("folder", {}).get("made", False)
        # The manifest goes last: parts without it would be refused.
        for name in sorted(os.listdir(self.path), key=lambda name: name == _MANIFEST):
            if name == _MANIFEST or blocks_of(name) is not None or name.endswith(_ATTEMPT):
                (self.path / name).unlink(missing_ok=True)
        if made:
            with contextlib.suppress(OSError):
                self.path.rmdir()


class Attempt:
    """The count of passes of one attempt at a share, in a file beside the part."""

    #: Least seconds between two writes.
    INTERVAL = 0.5

    def __init__(self, part: Path):
        self._path = part.with_name(f"{part.name}.{uuid.uuid4().hex[:12]}{_ATTEMPT}")
        self._written = float("-inf")

    def count(self, passes: int, last: bool = False) -> None:
        """Writes the count, if the last write was some time ago or none will follow."""
        now = time.monotonic()
        if last or now - self._written >= self.INTERVAL:
            self._written = now
            _attempt_io(self._path, lambda: self._path.write_text(str(passes)))


def _write(path: Path, text: str) -> None:
    """Writes a file as a whole."""
    temporary = path.with_name(f"{path.name}.{uuid.uuid4().hex[:12]}.tmp")

    def write() -> None:
        temporary.write_text(text)
        os.replace(temporary, path)

    _attempt_io(path, write)


def _attempt_io(path: Path, action: Any) -> Any:
    """Does what may fail in the file system; failures are FileErrors that name the path."""
    try:
        return action()
    except OSError as error:
        raise ml.FileError(error.strerror or str(error), file=str(path)) from error
