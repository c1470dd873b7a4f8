"""Commands of the program, run in this process, from a problem to JSON and fields."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Optional, TypeVar

from . import _gfmd
from ._body import Body, Law
from ._check import Array, frozen, integer, path
from ._errors import Interrupted, NotConverged
from ._progress import Progress
from ._record import Record, parsed
from ._result import File
from ._surface import Surface

Failure = Optional[tuple[str, str]]
Result = TypeVar("Result")


def body_keys(body: Body) -> dict[str, Any]:
    """Returns the configuration keys of a body, as given."""
    young, poisson, e_star, height = body._given
    elastic: dict[str, Any] = {"young": young} if e_star is None else {"e_star": e_star}
    elastic.update({name: body[name] for name in ("material", "second_material") if name in body})
    keys = {**elastic, "poisson": poisson, "height": height_key(height), **other_keys(body, body.layers)}
    if "compliance" in body:
        keys.update(compliance=[list(row) for row in body["compliance"]], uniform_compliance=body["uniform_compliance"])
    return keys


def relaxation_keys(body: Body) -> dict[str, Any]:
    """Returns the configuration keys of viscoelastic relaxation; empty for an elastic body."""
    if not body.prony:
        return {}
    return {"prony": [list(branch) for branch in body.prony], "moduli": body.moduli, "relaxes": body.relaxes}


def plasticity_keys(body: Body) -> dict[str, Any]:
    """Returns the configuration keys of yield stress and hardening; empty for a body that does not yield."""
    if "yield_stress" not in body:
        return {}
    curve = [list(point) for point in body.hardening_curve]
    found = {name: body[name] for name in ("yield_stress", "hardening", "kinematic_hardening")}
    return {**found, "hardening_curve": curve, "layer_yield": list(body.layer_yield)}


def law_keys(law: Law) -> dict[str, Any]:
    """Returns the configuration keys of a law."""
    table = {"law_table": [list(row) for row in law.table]} if law.table else {}
    return {"law": law.name, "param": [[name, value] for name, value in law.parameters.items()], **table}


def other_keys(values: Mapping[str, Any], layers: Sequence[Sequence[Any]]) -> dict[str, Any]:
    """Returns the configuration keys of the base, the layers below the top one, and the second body."""
    found = {name: values.get(name) for name in ("base", "base_young", "base_poisson", "second_body")}
    return {**found, "layer": [list(layer) for layer in layers]}


def height_key(height: Any) -> Any:
    return "inf" if height is None or height == math.inf else height


def solve(
    command: str,
    problem: dict[str, Any],
    arrays: Optional[dict[str, Any]] = None,
    threads: Optional[int] = None,
    out: Any = None,
    surface: Optional[Surface] = None,
) -> tuple[dict[str, Any], Failure, dict[str, Array], File]:
    """Runs a command. Returns its report, the kind and text of its failure, the fields by name, and the file.

    The keys of the problem are the flags of the command. The file, with the description of the `surface`, is also
    written to `out`, if given.
    """
    count = 0 if threads is None else integer("threads", threads, 0, 4096)
    target = None if out is None else path("out", out)
    if surface is not None and target is not None:
        surface._keeps("out", target)
    words = None if surface is None else surface.description
    with Progress(command) as progress:
        text, failure, fields, draft = _gfmd.solve(command, problem, arrays, count, progress.tick, target, words)
    values = parsed(text)
    for name in ("out", "plots", "peak_bytes", "scan"):  # about the files of a sweep, the process, and an array
        values.pop(name, None)
    kept = {name: frozen(field) for name, field in fields.items()}
    return values, failure, kept, File(draft, kept)


def ended(result: Result, failure: Failure) -> Result:
    """Returns the result, or raises the exception that carries it."""
    if failure is None:
        return result
    raise (Interrupted if failure[0] == "interrupted" else NotConverged)(failure[1], result)


def records(value: Any) -> Any:
    """Converts JSON objects to Records, at any depth."""
    if isinstance(value, dict):
        return Record({name: records(entry) for name, entry in value.items()})
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        return [records(entry) for entry in value]
    return value
