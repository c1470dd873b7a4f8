"""Progress of computations longer than a second: a tqdm bar if installed, else a line."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import TracebackType
from typing import Any, Callable, Optional

from ._check import flag

# Callback that stops one of many parallel computations; these have no bar of their own.
BESIDE: ContextVar[Optional[Callable[[], None]]] = ContextVar("BESIDE", default=None)

_PATIENCE = 1.0
_shown: Optional[bool] = None


def progress(shown: Optional[bool]) -> None:
    """Turns progress bars on or off for this process.

    Args:
        shown: True or False; None, the initial setting, shows them on terminals and in notebooks only.

    Raises:
        InputError: another value.

    Example:
        >>> gfmd.progress(False)
        >>> gfmd.progress(None)
    """
    global _shown
    _shown = None if shown is None else flag("shown", shown)


def _wanted() -> bool:
    if _shown is not None:
        return _shown
    return "ipykernel" in sys.modules or (
        sys.stderr is not None
        and not sys.stderr.closed
        and sys.stderr.isatty()
        and "PYTEST_CURRENT_TEST" not in os.environ
    )


@contextmanager
def hidden(is_hidden: bool) -> Iterator[None]:
    """Shows no bar in the block, if `is_hidden`."""
    if not is_hidden:
        yield
        return
    token = BESIDE.set(lambda: None)
    try:
        yield
    finally:
        BESIDE.reset(token)


class Progress:
    """Bar over `total` pieces, with a note on the current one. A command counts its pieces itself."""

    def __init__(self, what: str, total: int = 1) -> None:
        self._what, self._total, self._done = what, total, 0
        self._started = time.monotonic()
        self._bar: Any = None
        self._beside = BESIDE.get()
        self._wanted = self._beside is None and _wanted()

    def tick(self, note: str = "", done: int = 0, count: int = 0) -> None:
        if count:
            self._done, self._total = done, count
        if self._beside is not None:
            self._beside()
        if not self._wanted or time.monotonic() - self._started < _PATIENCE:
            return
        try:
            self._show(note)
        except (OSError, ValueError):  # stderr is closed or cannot be written
            self._wanted, self._bar = False, None

    def _show(self, note: str) -> None:
        if self._bar is None:
            try:
                import importlib

                tqdm = importlib.import_module("tqdm.auto").tqdm

                self._bar = tqdm(total=self._total, desc=self._what, initial=self._done, leave=False)
            except ImportError:
                self._bar = False
        if self._bar:
            self._bar.total, self._bar.n = self._total, self._done
            self._bar.set_postfix_str(note)
        else:
            width = shutil.get_terminal_size().columns - 1
            line = f"{self._what}: {self._done} of {self._total}, {note}"[:width]
            print(f"\r{line:{width}}", end="", file=sys.stderr, flush=True)

    def piece(self) -> None:
        self._done += 1
        if self._bar:
            try:
                self._bar.update(1)
            except (OSError, ValueError):
                self._wanted, self._bar = False, None

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        try:
            if self._bar:
                self._bar.close()
            elif self._bar is False:
                print(file=sys.stderr)
        except (OSError, ValueError):
            pass
