"""Differences with named causes: patterns of case names, the kind of the cause, and the cause.

Kinds: `ours` and `theirs` (the values of that program are wrong), `lenient` (we read what Mitsuba refuses), `approximated` (a limit
that docs/formats/mitsuba.md states), `unsupported` (with one warning).
"""

KNOWN: list[tuple[tuple[str, ...], str, str]] = []
