"""Contacts as functions of heights and load, for adapters to automatic differentiation packages."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._body import Body, as_body
from ._check import Array
from ._contact import Contact, Gradient
from ._errors import InputError
from ._solve import contact
from ._surface import Surface

# Differentiable fields and numbers, in the order of the outputs.
FIELDS = ("pressure", "gap")
NUMBERS = ("mean_pressure", "approach", "mean_gap", "elastic_energy")


class Outputs(NamedTuple):
    """Fields [x, y] and numbers of a contact, as arrays of the automatic differentiation package."""

    pressure: Any
    gap: Any
    mean_pressure: Any
    approach: Any
    mean_gap: Any
    elastic_energy: Any


class Solver:
    """Contact of one body under one kind of load, as a function of heights and load."""

    def __init__(self, body: Body, size: Any, control: str, options: dict[str, Any]) -> None:
        self.body, self.size, self.control, self.options = as_body(body), size, control, options

    def __call__(self, heights: Array, load: float) -> Contact:
        surface = Surface(np.asarray(heights, dtype=np.float64), size=self.size)
        options: dict[str, Any] = {self.control: float(load), **self.options}
        found: Contact = contact(surface, self.body, **options)
        return found

    def outputs(self, found: Contact) -> list[Array]:
        """Returns the fields and numbers as arrays, in the order of `Outputs`."""
        numbers = [np.asarray(found[name], dtype=np.float64) for name in NUMBERS]
        return [found.pressure, np.where(found.pressure > 0.0, 0.0, found.gap), *numbers]

    def pull(self, found: Contact, given: list[Any]) -> Gradient:
        """Returns the derivatives with respect to heights and load from the derivatives with respect to the outputs."""
        fields = dict(zip(FIELDS, (np.asarray(field, dtype=np.float64) for field in given[:2])))
        numbers = dict(zip(NUMBERS, (float(value) for value in given[2:])))
        return found.vjp(**fields, **numbers, fixed=self.control)  # type: ignore[arg-type]


def controlled(pressure: Any, approach: Any) -> tuple[str, Any]:
    """Returns the kind and value of the load."""
    given = [(name, value) for name, value in (("pressure", pressure), ("approach", approach)) if value is not None]
    if len(given) != 1:
        raise InputError("the load must be given by one of pressure, approach")
    return given[0]
