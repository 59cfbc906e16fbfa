"""Checks of the settings of a render, before anything is sent."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import manylight as ml
from manylight._native import pass_limit, relative_error, seconds
from manylight._options import is_given

#: Options of `manylight.render` that need the whole image.
_NOT_IN_SHARES = ("denoise", "checkpoint", "checkpoint_every", "resume", "preview", "shard", "blocks", "lights_out")


@dataclass(frozen=True)
class Goal:
    """When the render ends."""

    passes: int | None
    time: float | None
    target_error: float | None


def goal_of(passes: int | None, time: float | str | None, target_error: float | str | None) -> Goal:
    """When the render ends. Raises UsageError."""
    open_ended = time is not None or target_error is not None
    if passes is not None and open_ended:
        raise ml.UsageError("passes: does not go with time or target_error on a cluster; give passes, or the others")
    if passes is None and not open_ended:
        passes = pass_limit([])
    if passes is not None and not (_is_integer(passes) and passes >= 1):
        raise ml.UsageError(f"passes: found {passes!r}, expected an integer from 1 on")
    return Goal(
        passes,
        None if time is None else _seconds(time),
        None if target_error is None else _relative_error(target_error),
    )


def check(block: int, shares: int | None, retries: int, options: Mapping[str, Any]) -> None:
    """Raises UsageError for other settings than could be right."""
    if not (_is_integer(block) and block >= 8 and block % 8 == 0):
        raise ml.UsageError(f"block: found {block!r}, expected a multiple of 8")
    if shares is not None and not (_is_integer(shares) and shares >= 1):
        raise ml.UsageError(f"shares: found {shares!r}, expected an integer from 1 on")
    check_retries(retries)
    refuse(options, _NOT_IN_SHARES, "shares of a render")


def refuse(options: Mapping[str, Any], names: Iterable[str], what: str) -> None:
    """Raises UsageError for given options that have no meaning for ``what``."""
    for name in names:
        if is_given(options.get(name)):
            raise ml.UsageError(f"{name}: does not go with {what}; leave it out")


def given(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options that are given. Workers refuse options of whole images, even with False."""
    return {name: value for name, value in options.items() if is_given(value)}


def check_retries(retries: int) -> None:
    """Raises UsageError for no number of retries."""
    if not (_is_integer(retries) and retries >= 0):
        raise ml.UsageError(f"retries: found {retries!r}, expected an integer from 0 on")


def _is_integer(value: Any) -> bool:
    return hasattr(value, "__index__") and not isinstance(value, bool)


def _is_number(value: Any) -> bool:
    return hasattr(value, "__float__") and not isinstance(value, bool)


def _seconds(time: float | str) -> float:
    """Seconds of a number, or of a text as the command takes it."""
    if isinstance(time, str):
        return _parsed("time", seconds, time)
    if not (_is_number(time) and 0 < time < math.inf):
        raise ml.UsageError(f"time: found {time!r}, expected seconds above 0, or a text such as '60s', '10m', '1h'")
    return float(time)


def _relative_error(error: float | str) -> float:
    """A relative error of a number, or of a text as the command takes it."""
    if not (isinstance(error, str) or _is_number(error)):
        raise ml.UsageError(f"target_error: found {error!r}, expected a number such as 0.02, or '2%'")
    return _parsed("target_error", relative_error, error if isinstance(error, str) else repr(float(error)))


def _parsed(name: str, parse: Callable[[str], float], text: str) -> float:
    """The number that ``parse`` finds in the text of an option."""
    try:
        return parse(text)
    except ml.UsageError as error:
        raise ml.UsageError(f"{name}: {error.message}", suggestion=error.suggestion) from None
