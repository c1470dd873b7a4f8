"""Result files: those of the program."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np

from . import _check, _gfmd
from ._body import Body, Law
from ._check import Array
from ._contact import LATERAL, LOWER, REPULSION, Contact, Contacts, Settings
from ._errors import InputError
from ._record import json_of, of_load
from ._surface import Surface, _surface

_CONTROLS = ("pressure", "p_star", "displacement")


def _others(body: Body) -> dict[str, Any]:
    """What the configuration says of the base, further layers and a second body."""
    names = ("base", "base_young", "base_poisson", "second_body")
    found = {name: body[name] for name in names if body.get(name) not in (None, "bonded")}
    return {**found, **({"layer": body.layers} if body.layers else {})}


def _asked(contacts: Sequence[Contact]) -> dict[str, list[float]]:
    """The prescribed loads; the mean pressures if they were prescribed by different quantities."""
    given = [contact._settings.load for contact in contacts]
    if None not in given and len({load[0] for load in given if load}) == 1:
        return {given[0][0]: [load[1] for load in given if load]}  # type: ignore[index]
    return {"pressure": [contact["mean_pressure"] for contact in contacts]}


def config(contacts: Sequence[Contact]) -> dict[str, Any]:
    """The configuration of contacts of one surface, as a file has it."""
    first = contacts[0]
    body, law = first.body, first.law
    return {
        "length": list(first.surface.size),
        "poisson": body.poisson,
        ("young" if body._given[2] is None else "e_star"): body._given[0] if body._given[2] is None else body._given[2],
        "height": "inf" if body.height is None else body.height,
        **_others(body),
        **_asked(contacts),
        "boundary": first.boundary,
        **({} if first.components == "normal" else {"components": first.components}),
        **({} if first.hardness is None else {"hardness": first.hardness if isinstance(first.hardness, float) else "array"}),
        **({"finite_slope": True} if first.finite_slope else {}),
        **({} if first.lower_surface is None else {"lower_surface": "array"}),
        "solver": first._settings.solver,
        "tol": first._settings.tolerance,
        "law": law.name,
        **({"param": [[name, value] for name, value in law.parameters.items()]} if law.parameters else {}),
    }


def save(name: Any, contacts: Sequence[Contact]) -> None:
    if not contacts:
        raise InputError("there are no contacts to write")
    first = contacts[0]
    loads = [(json_of(contact._values), list(contact._fields().values())) for contact in contacts]
    field = None if first.hardness is None or isinstance(first.hardness, float) else first.hardness
    lower = None if first.lower_surface is None else _given(first.lower_surface)
    _gfmd.save(_check.path("path", name), _given(first.surface), loads, config(contacts), field, lower)


def _given(surface: Surface) -> tuple[Array, tuple[float, float], Optional[str], str]:
    return surface.heights, surface.size, surface.unit, surface.description


def _stored(name: str, group: str, length: Sequence[float]) -> Surface:
    """A surface of a file; `length` is that of the configuration."""
    heights, size, unit, *_ = _gfmd.read(f"{name}:{group}/height")
    if len(length) == 2:
        size = (length[0], length[1])
    elif size is not None and len(length) == 1:
        size = (length[0], size[1])
    return _surface(heights, size or (1.0, 1.0), unit, _gfmd.read_text(name, group, "description"))


def _array(name: str, dataset: str, shape: tuple[int, ...]) -> Array:
    """An array of a file, which has this shape."""
    found = _gfmd.read_array(name, dataset)
    if found.shape != shape:
        raise InputError(f"{name}: {dataset} has the shape {list(found.shape)}; it must be {list(shape)}")
    return found


def load(path: Union[str, "os.PathLike[str]"]) -> Union[Contact, Contacts]:
    """Returns the contact, or the contacts of several loads, of a file of `gfmd contact --out`, `Contact.save` or `Contacts.save`.

    Args:
        path: the name of the HDF5 file.

    Raises:
        InputError: not such a file.

    Example:
        >>> c.save("c.h5")
        >>> gfmd.load("c.h5").area_fraction == c.area_fraction
        True
    """
    name = _check.path("path", path)
    # Of keys and types that results have; a file may come from anyone.
    config = json.loads(_gfmd.read_config(name))
    length = [] if "second_surface" in config else config.get("length", [])
    surface = _stored(name, "/surface", length)
    hardness = config.get("hardness")
    hardness = _check.frozen(_array(name, "/surface/hardness", surface.heights.shape)) if isinstance(hardness, str) else hardness and float(hardness)
    between = "lower_surface" in config or "lower_seed" in config
    lower = _stored(name, "/lower", length) if between else None
    finite_slope = bool(config.get("finite_slope", False))
    height = config.get("height", "inf")
    e_star = config.get("e_star")
    below = {name: config[name] for name in ("base", "base_young", "base_poisson", "second_body") if name in config}
    young, height = None if e_star is not None else config.get("young"), None if height == "inf" else height
    body = Body(young, config.get("poisson", 0.0), e_star=e_star, height=height, layers=config.get("layer", ()), **below)
    law = Law(config.get("law", "hard-wall"), {key: float("nan" if value is None else value) for key, value in config.get("param", [])})
    records = [of_load(record) for record in _gfmd.read_records(name)]
    shape = (len(records), *surface.heights.shape)
    components = str(config.get("components", "normal"))
    fields = [_array(name, f"/fields/{field}", shape) for field in ("pressure", "displacement_z", "gap")]

    lateral = LATERAL[: 1 if surface.n[1] == 1 else 2] if components == "all" or finite_slope else ()
    further = (*(() if hardness is None else ("plastic_depth",)), *lateral, *(LOWER if between else ()))
    others = {field: _array(name, f"/fields/{field}", shape) for field in further}
    if law.name != "hard-wall":
        try:
            others[REPULSION] = _array(name, f"/fields/{REPULSION}", shape)
        except InputError:  # a law without a wall, or a file of an earlier version
            pass
    told = (str(config.get("solver", "auto")), float(config.get("tol", 1e-8)), str(config.get("boundary", "periodic")))
    settings = Settings(*told, hardness, components, finite_slope, lower)
    control, asked = next(((key, config[key]) for key in _CONTROLS if config.get(key)), ("", []))

    def contact(index: int) -> Contact:
        pressure, displacement, gap = (np.ascontiguousarray(field[index]) for field in fields)
        own = {field: np.ascontiguousarray(column[index]) for field, column in others.items()}
        load = (control, float(asked[index])) if index < len(asked) and asked[index] is not None else None
        return Contact(records[index], (surface, body, law), (pressure, displacement, gap), settings._replace(load=load), None, own)

    contacts = [contact(index) for index, record in enumerate(records) if np.isfinite(record["mean_pressure"])]
    return contacts[0] if len(contacts) == 1 else Contacts(contacts)
