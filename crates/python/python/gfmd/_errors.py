"""The exceptions of the package."""

from __future__ import annotations

import os
import re
import sys
import warnings
from typing import Any

__all__ = ["Error", "InputError", "Interrupted", "NotConverged"]


class Error(Exception):
    """The base class of all errors of this package except `Interrupted`."""


class InputError(Error, ValueError):
    """Invalid input. The message has the argument, the value found and the allowed values. Nothing was computed."""


class NotConverged(Error):
    """A solve that did not reach its tolerance. `state` is the partial result, or None.

    For a path or a punch, `state.not_converged` has the unmet criteria, the residual against the iterations, and
    advice.
    """

    def __init__(self, text: str, state: Any = None) -> None:
        super().__init__(text)
        self.state = state

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.state)


class Interrupted(KeyboardInterrupt):
    """A computation stopped by Ctrl-C. `state` is the partial result, or None.

    It is a `KeyboardInterrupt`, so that `except Exception` does not swallow it.
    """

    def __init__(self, text: str, state: Any = None) -> None:
        super().__init__(text)
        self.state = state

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.state)


# Arguments that have other names than the flags of the program.
_NAMES = {"param": "law"}


# Values of flags in messages: numbers with their unit, and names of choices.
_VALUE = r"[+-]?\d(?:[^\s,;:)]*[^\s,;:).])?|(?:inf|um|nm|refine|none|all|held|free|half-space|table|mirror|harmonic)\b"


def _spoken(text: str) -> str:
    """Replaces flags in a message by Python arguments: `young="70GPa"` for `--young 70GPa`."""

    def argument(flag: re.Match[str]) -> str:
        words, parameter, value = flag[1].replace("-", "_"), flag[2], flag[3]
        name = _NAMES.get(words, words)
        if value is None:
            return name
        is_number = re.fullmatch(r"[+-]?[\d.]+(?:e[+-]?\d+)?", value)
        given = value if is_number else f'"{value}"'
        return f"{parameter or name}={given}"

    flags = rf"--([a-z](?:[a-z0-9-]*[a-z0-9])?)(?:[ =](?:([a-z_]+)=)?({_VALUE}))?"
    return re.sub(flags, argument, text).replace("\n", " ")


# The native module calls these.
def refused(text: str) -> InputError:
    return InputError(_spoken(text))


def failed(text: str) -> NotConverged | Error:
    return NotConverged(text) if "converge" in text else Error(_spoken(text))


def unreached(text: str) -> NotConverged:
    return NotConverged(_spoken(text))


def interrupted(text: str) -> Interrupted:
    return Interrupted(text)


def warned(lines: str) -> None:
    """Issues warnings at the line that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        level, frame = level + 1, frame.f_back
    for line in lines.splitlines():
        warnings.warn(_spoken(line.strip()), UserWarning, stacklevel=level)
