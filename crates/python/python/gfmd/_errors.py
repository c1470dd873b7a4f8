"""Exceptions of the package."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any, Optional

__all__ = ["Error", "InputError", "Interrupted", "NotConverged"]


class Error(Exception):
    """Base class of all errors of this package except `Interrupted`."""


class InputError(Error, ValueError):
    """Invalid input; nothing was computed. The message names the argument, the value found and the allowed values.

    Attributes:
        argument: argument name, or None if the message is not about a single argument.
        found: value found, as text, or None.
        allowed: allowed values in words, or None.
    """

    def __init__(
        self, text: str, argument: Optional[str] = None, found: Optional[str] = None, allowed: Optional[str] = None
    ) -> None:
        super().__init__(text)
        self.argument, self.found, self.allowed = argument, found, allowed

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.argument, self.found, self.allowed)


class NotConverged(Error):
    """A solve that did not reach its tolerance, with the partial result in `state`, or None.

    For a path or punch, `state.not_converged` has the unmet criteria, the residual against iterations, and advice.
    """

    def __init__(self, text: str, state: Any = None) -> None:
        super().__init__(text)
        self.state = state

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.state)


class Interrupted(KeyboardInterrupt):
    """A computation stopped by Ctrl-C, with the partial result in `state`, or None.

    It is a `KeyboardInterrupt`, so that `except Exception` does not swallow it.
    """

    def __init__(self, text: str, state: Any = None) -> None:
        super().__init__(text)
        self.state = state

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.state)


# The native module calls these.
def refused(text: str, *found: Optional[str]) -> InputError:
    return InputError(text.replace("\n", " "), *found)


def failed(text: str) -> Error:
    return Error(text)


def unreached(text: str) -> NotConverged:
    return NotConverged(text)


def interrupted(text: str) -> Interrupted:
    return Interrupted(text)


def warned(lines: str) -> None:
    """Issues warnings at the line that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        level, frame = level + 1, frame.f_back
    for line in lines.splitlines():
        warnings.warn(line.strip(), UserWarning, stacklevel=level)
