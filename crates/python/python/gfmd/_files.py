"""Result files: those of the program."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, Union

import numpy as np

from . import _check, _gfmd
from ._body import Body, Law
from ._check import Array
from ._contact import Contact, Contacts
from ._errors import InputError
from ._record import Residual
from ._surface import _surface

_COUNTS = ("contact_nodes", "boundary_links", "iterations")
_FLAGS = ("converged", "passed_instability")
_STIFFNESS = ("stiffness", "stiffness_error")
_RESIDUALS = ("complementarity", "penetration", "negative_pressure", "load")


def _toml(values: dict[str, Any]) -> str:
    """Scalars as TOML, which has NaN."""

    def text(value: Any) -> str:
        return str(value).lower() if isinstance(value, bool) else repr(value)

    rows = [f"{name} = {text(value)}" for name, value in values.items() if name != "residual"]
    rows += ["[residual]", *(f"{name} = {text(value)}" for name, value in values["residual"].items())]
    return "\n".join(rows)


def _others(body: Body) -> dict[str, Any]:
    """What the configuration says of the base, further layers and a second body."""
    names = ("base", "base_young", "base_poisson", "second_body")
    found = {name: body[name] for name in names if body.get(name) not in (None, "bonded")}
    return {**found, **({"layer": body.layers} if body.layers else {})}


def save(name: Any, contacts: Sequence[Contact]) -> None:
    if not contacts:
        raise InputError("there are no contacts to write")
    first = contacts[0]
    surface, body, law = first.surface, first.body, first.law
    config: dict[str, Any] = {
        "length": list(surface.size),
        "poisson": body.poisson,
        ("young" if body._given[2] is None else "e_star"): body._given[0] if body._given[2] is None else body._given[2],
        "height": "inf" if body.height is None else body.height,
        **_others(body),
        "pressure": [contact["mean_pressure"] for contact in contacts],
        "boundary": first.boundary,
        **({} if first.components == "normal" else {"components": first.components}),
        **({} if first.hardness is None else {"hardness": first.hardness if isinstance(first.hardness, float) else "array"}),
        "solver": first._settings[0],
        "tol": first._settings[1],
        "law": law.name,
        "param": [[name, value] for name, value in law.parameters.items()],
    }
    def fields_of(contact: Contact) -> list[Array]:
        depth = contact.plastic_depth
        return [contact.pressure, contact.displacement_z, contact.gap, *([] if depth is None else [depth]), *contact._lateral]

    loads = [(_toml(contact._values), fields_of(contact)) for contact in contacts]
    given = (surface.heights, surface.size, surface.unit, surface.description)
    field = None if first.hardness is None or isinstance(first.hardness, float) else first.hardness
    _gfmd.save(_check.path("path", name), given, loads, _gfmd.json_to_toml(json.dumps(config)), field)


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
    config = json.loads(_gfmd.toml_to_json(_gfmd.read_text(name, "/", "config")))
    for key in ("finite_slope", "lower_surface", "lower_seed"):
        if key in config:
            raise InputError(f"{name} was made with --{key.replace('_', '-')}; it must be a contact of `gfmd.contact` (other tools read its fields)")
    hardness = config.get("hardness")
    hardness = _check.frozen(_gfmd.read_array(name, "/surface/hardness")) if isinstance(hardness, str) else hardness and float(hardness)
    heights, size, unit, *_ = _gfmd.read(f"{name}:/surface/height")
    length = [] if "second_surface" in config else config.get("length", [])
    if len(length) == 2:
        size = (length[0], length[1])
    elif size is not None and len(length) == 1:
        size = (length[0], size[1])
    surface = _surface(heights, size or (1.0, 1.0), unit, _gfmd.read_text(name, "/surface", "description"))
    height = config.get("height", "inf")
    e_star = config.get("e_star")
    below = {name: config[name] for name in ("base", "base_young", "base_poisson", "second_body") if name in config}
    young, height = None if e_star is not None else config.get("young"), None if height == "inf" else height
    body = Body(young, config.get("poisson", 0.0), e_star=e_star, height=height, layers=config.get("layer", ()), **below)
    law = Law(config.get("law", "hard-wall"), {name: float(value) for name, value in config.get("param", [])})
    names = ["mean_pressure", "p_star", "displacement", "area_fraction", "area_fraction_corrected", "kappa", "kappa_corrected"]
    names += ["contact_nodes", "boundary_links", "mean_gap", "max_pressure", "mean_pressure_in_contact", "pressure_deviation_in_contact"]
    names += ["pressure_moment_2", "elastic_energy", "stiffness", "stiffness_error", "iterations", "transform_pairs", "converged", "residual", "seconds"]
    if law.name != "hard-wall":
        names += ["interface_energy", "passed_instability", "lowest_curvature", "residual_equilibrium"]
    if config.get("boundary") == "free":
        names.append("force")
    if hardness is not None:
        names += ["plastic_fraction", "plastic_volume"]
    components = str(config.get("components", "normal"))
    parts = _RESIDUALS if hardness is None else (*_RESIDUALS, "saturation")
    parts = (*parts, "lateral_traction") if components == "all" else parts
    residuals = {part: _gfmd.read_array(name, f"/loads/residual_{part}") for part in parts}
    columns = {key: _gfmd.read_array(name, f"/loads/{key}") for key in names if key != "residual" and key not in _STIFFNESS}
    for key in _STIFFNESS:
        try:
            column = _gfmd.read_array(name, f"/loads/{key}")
        except InputError:  # a file of an earlier version
            column = np.full_like(columns["mean_pressure"], np.nan)
        # Infinite in full contact: no number, as in JSON.
        columns[key] = np.where(np.isinf(column), np.nan, column)
    fields = [_gfmd.read_array(name, f"/fields/{field}") for field in ("pressure", "displacement_z", "gap")]

    def scalar(key: str, index: int) -> Any:
        if key == "residual":
            return Residual({part: float(values[index]) for part, values in residuals.items()})
        value = float(columns[key][index])
        if key in _COUNTS and np.isfinite(value):
            return int(value)
        return bool(value) if key in _FLAGS else value

    depths = None if hardness is None else _gfmd.read_array(name, "/fields/plastic_depth")
    settings = (str(config.get("solver", "auto")), float(config.get("tol", 1e-8)), str(config.get("boundary", "periodic")), hardness, components)
    axes = () if components != "all" else ("x",) if surface.n[1] == 1 else ("x", "y")
    lateral = [_gfmd.read_array(name, f"/fields/displacement_{axis}") for axis in axes]
    contacts = [
        Contact({key: scalar(key, index) for key in names}, (surface, body, law), tuple(np.ascontiguousarray(field[index]) for field in fields), settings, None, None if depths is None else np.ascontiguousarray(depths[index]), tuple(np.ascontiguousarray(field[index]) for field in lateral))  # type: ignore[arg-type]
        for index in range(len(fields[0]))
        if np.isfinite(columns["mean_pressure"][index])
    ]
    return contacts[0] if len(contacts) == 1 else Contacts(contacts)
