"""Exceptions of manylight.

Every exception says what was found and what was expected. Its fields have the place and a suggestion.
"""

from __future__ import annotations

__all__ = ["Error", "UsageError", "SceneError", "FileError", "ComponentError", "RenderError"]


class Error(Exception):
    """An error of manylight.

    Attributes:
        message: What was found.
        suggestion: What was expected, or what to do instead; None if nothing is known.
        code: Stable identifier of the problem, such as ``scene::unknown_plugin``; None if it has none.
        file: Path of the file; None if the error belongs to no file.
        line: Line in the file, counted from 1; None if it is unknown.
        column: Column in the file, counted from 1; None if it is unknown.
        key: Keys of the entry in the dictionary of the scene, such as ``floor.bsdf.reflectance``; None for scenes from files.
    """

    def __init__(
        self,
        message: str,
        *,
        suggestion: str | None = None,
        code: str | None = None,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        key: str | None = None,
    ) -> None:
        Exception.__init__(self, message)
        self.message = message
        self.suggestion = suggestion
        self.code = code
        self.file = file
        self.line = line
        self.column = column
        self.key = key

    @property
    def place(self) -> str | None:
        """``file:line:column`` as far as they are known, or the keys in the dictionary."""
        if self.key is not None:
            return self.key
        known = [part for part in (self.file, self.line, self.column) if part is not None]
        return ":".join(map(str, known)) or None

    def __str__(self) -> str:
        text = f"{self.place}: {self.message}" if self.place else self.message
        return f"{text}\n  {self.suggestion}" if self.suggestion else text

    def __reduce__(self) -> tuple:
        return _restore, (type(self), self.message, self._fields())

    def _fields(self) -> dict:
        names = ("suggestion", "code", "file", "line", "column", "key")
        return {name: getattr(self, name) for name in names}


def _restore(kind: type[Error], message: str, fields: dict) -> Error:
    return kind(message, **fields)


class UsageError(Error, ValueError):
    """The arguments do not fit each other or the scene."""


class SceneError(Error, ValueError):
    """The scene is invalid, or uses an unsupported feature under ``strict``."""


class FileError(Error, OSError):
    """A file cannot be read or written, or is damaged."""


class ComponentError(Error):
    """An optional component, such as the denoiser, is missing."""


class RenderError(Error, RuntimeError):
    """An internal error of the renderer."""
