"""Options of functions, checked by their types in a generated table, and shown by `help`."""

from __future__ import annotations

import functools
import inspect
import json
import re
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from ._check import flag, integer, integers, number, numbers, path, plain, texts, word
from ._hints import argument

_Function = TypeVar("_Function", bound=Callable[..., Any])

# Type, default and meaning of each option, by the name of its class in `_options.py` and `_options_inside.py`.
TABLES: dict[str, dict[str, dict[str, Any]]] = json.loads(
    (Path(__file__).parent / "_options.json").read_text(encoding="utf-8")
)


def _text_or_number(name: str, value: object) -> Any:
    return word(name, value) if isinstance(value, str) else number(name, value)


# Checks for types that need no more; functions check the others themselves.
_CHECKS: dict[str, Callable[[str, Any], Any]] = {
    "bool": flag,
    "float": number,
    "float | Sequence[float]": numbers,
    "float | str": _text_or_number,
    "int": integer,
    "int | Sequence[int]": integers,
    "npt.ArrayLike": plain,
    "Quantity": _text_or_number,
    "Sequence[float]": numbers,
    "Sequence[int]": lambda name, values: [integer(name, value) for value in values],
    "str": word,
    "str | os.PathLike[str]": path,
}


def _checked(name: str, value: Any, of: str) -> Any:
    """Returns the value of an option if it has the type `of`."""
    if of.startswith("Literal["):
        return word(name, value)
    if of.startswith("Sequence[Literal["):
        return texts(name, value)
    return _CHECKS[of](name, value) if of in _CHECKS else value


def given(options: Mapping[str, Any], table: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Checks options by a table. Returns the options with a value."""

    def is_left_out(name: str, value: Any) -> bool:
        is_empty = value.size == 0 if isinstance(value, np.ndarray) else isinstance(value, (list, tuple)) and not value
        return value is None or table[name]["default"] == [] and is_empty

    there = {name: value for name, value in options.items() if not is_left_out(name, value)}
    return {name: _checked(name, value, table[name]["type"]) for name, value in there.items()}


def _documented(text: str, table: Mapping[str, Mapping[str, Any]]) -> str:
    """Returns the docstring of a function, with meanings added for options that it does not describe."""
    before, raises, behind = text.partition("\n\n    Raises:")
    lines = []
    for name, row in table.items():
        if not re.search(rf"\b{name}[,:]", before):
            meaning = f"{name}: {row['meaning'][:1].lower()}{row['meaning'][1:]}."
            lines += textwrap.wrap(meaning, 120, initial_indent=" " * 8, subsequent_indent=" " * 12)
    return "\n".join([before, *lines]) + raises + behind


def taking(options: type) -> Callable[[_Function], _Function]:
    """Decorates a function that takes the options of a class: checks them, and suggests the right name for an unknown
    one. Its signature and docstring have every option, unless it documents `options` as a whole.
    """
    table = {name: TABLES[options.__name__][name] for name in options.__annotations__}

    def decorated(function: _Function) -> _Function:
        signature = inspect.signature(function)
        own = [of for of in signature.parameters.values() if of.kind is not of.VAR_KEYWORD]
        names = [of.name for of in own if of.kind is of.KEYWORD_ONLY]

        @functools.wraps(function)
        def called(*arguments: Any, **others: Any) -> Any:
            further = {name: value for name, value in others.items() if name not in signature.parameters}
            for name in further:
                if name not in table:
                    listed = argument(name, [*names, *table])
                    raise TypeError(f"{function.__name__} has no argument {name!r}; {listed}")
            passed = {name: value for name, value in others.items() if name not in further}
            return function(*arguments, **passed, **given(further, table))

        text = function.__doc__ or ""
        if "\n        options: " not in text:
            kind, shown = inspect.Parameter.KEYWORD_ONLY, table.items()
            added = [
                inspect.Parameter(name, kind, default=row["default"], annotation=row["type"]) for name, row in shown
            ]
            setattr(called, "__signature__", signature.replace(parameters=[*own, *added]))
            called.__doc__ = _documented(text, table)
        return cast(_Function, called)

    return decorated
