"""The commands of the program in this process: problems in, JSON and fields out."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, TypeVar

import numpy as np

from . import _gfmd
from ._body import Body
from ._check import Array, frozen, integer
from ._errors import InputError, Interrupted, NotConverged
from ._progress import Progress
from ._record import Record, parsed
from ._surface import Surface

Failure = Optional[tuple[str, str]]
Result = TypeVar("Result")


def body_keys(body: Body) -> dict[str, Any]:
    """The keys of a body, as it was given."""
    young, poisson, e_star, height = body._given
    elastic = {"young": young} if e_star is None else {"e_star": e_star}
    return {**elastic, "poisson": poisson, "height": height_key(height), **other_keys(body, body.layers)}


def other_keys(values: Mapping[str, Any], layers: Sequence[Sequence[float]]) -> dict[str, Any]:
    """The keys of what lies below the top layer of a body, and of a second body."""
    found = {name: values.get(name) for name in ("base", "base_young", "base_poisson", "second_body")}
    return {**found, "layer": [list(layer) for layer in layers]}


def height_key(height: Optional[float]) -> Any:
    return "inf" if height is None or math.isinf(height) else height


def surface_keys(surface: Surface, folder: str) -> dict[str, Any]:
    """The keys of a surface, whose heights go through a file bit by bit."""
    file = os.path.join(folder, "heights.npy")
    np.save(file, surface.heights if surface.n[1] > 1 else surface.heights[:, 0])
    return {"surface": file, "length": list(surface.size) if surface.n[1] > 1 else [surface.size[0], 1.0]}


def solve(command: str, problem: dict[str, Any], out: Optional[str] = None, threads: Optional[int] = None) -> tuple[dict[str, Any], Failure]:
    """The report of a command on a problem with the keys of its flags, and the kind and the text of its failure."""
    return _reported(command, threads, lambda count, tick: _gfmd.solve(command, problem, out, count, tick))


def run(command: str, words: list[str], threads: Optional[int] = None) -> tuple[dict[str, Any], Failure]:
    """The report of the words of a command, and the kind and the text of its failure."""
    return _reported(command, threads, lambda count, tick: _gfmd.run([command, *words], count, tick))


def _reported(command: str, threads: Optional[int], call: Callable[[int, Any], tuple[str, Failure]]) -> tuple[dict[str, Any], Failure]:
    count = 0 if threads is None else integer("threads", threads, 0, 4096)
    with Progress(command) as progress:
        text, failure = call(count, progress.tick)
    values = parsed(text)
    for name in ("out", "plots", "peak_bytes", "scan"):  # of files that are removed with their folder, and of the process
        values.pop(name, None)
    return values, failure


def ended(result: Result, failure: Failure) -> Result:
    """The result, or the exception that carries it."""
    if failure is None:
        return result
    text = failure[1].split("; kept in ")[0]  # a file that is removed with its folder
    raise (Interrupted if failure[0] == "interrupted" else NotConverged)(text, result)


def records(value: Any) -> Any:
    """Objects of JSON as Records, at any depth."""
    if isinstance(value, dict):
        return Record({name: records(entry) for name, entry in value.items()})
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        return [records(entry) for entry in value]
    return value


def fields(file: str, names: Sequence[str]) -> dict[str, Array]:
    """The fields of a file that it has."""
    found = {}
    for name in names if os.path.exists(file) else ():
        try:
            found[name] = frozen(_gfmd.read_array(file, f"/fields/{name}"))
        except InputError:
            continue
    return found
