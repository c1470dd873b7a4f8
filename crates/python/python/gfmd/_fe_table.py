"""Contact laws for finite elements, as text."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal, Optional, Union

import numpy as np

from . import _gfmd, _leak
from ._check import CONDUCTIVITY, Quantity, conductivities, flag, in_units, shown, word
from ._contact import Contact, Contacts
from ._errors import InputError
from ._hints import hinted

Given = Union[list[Optional[float]], str]


def _given(value: Any, error: Any = None, reason: str = "it was not measured") -> Given:
    """Returns a number with its grid error, or the reason why it is missing."""
    if value is None or not math.isfinite(value):
        return reason
    known = error is not None and math.isfinite(error)
    return [float(value), float(error) if known else None]


def _load(contact: Contact, conductivity: Optional[Sequence[float]], with_flow: bool) -> dict[str, Given]:
    """Returns the numbers of a load by name."""
    measured = contact._measured(statistics=True)[0]
    found: dict[str, Given] = {}
    for name in ("mean_gap", "area_fraction", "stiffness", "conductance"):
        of = contact if name in contact else measured
        reason = of.get("undefined", {}).get(name, "it was not measured")
        found[name] = _given(of.get(name), of.get(f"{name}_grid_error"), reason)
    conductance = found["conductance"]
    if conductivity is not None and not isinstance(conductance, str):
        resistivity = sum(1.0 / one for one in conductivity)
        found["contact_conductance"] = [None if part is None else part / resistivity for part in conductance]
    if with_flow:
        flow = contact.flow()
        gap_error = contact.get("mean_gap_grid_error", math.nan) / contact.mean_gap
        for axis, name in enumerate("xy"):
            through = float(flow.transmissivity[axis, axis])
            errors = flow.get("conductivity_grid_error")
            relative = math.nan
            if errors is not None and through > 0.0:
                relative = float(errors[axis, axis] / flow.conductivity[axis, axis]) + 3.0 * gap_error
            found[f"transmissivity_{name}"] = _given(through, through * relative)
    return found


def _realisation(contacts: Contacts, conductivity: Optional[Sequence[float]], with_flow: bool) -> dict[str, Any]:
    """Returns the numbers of the contacts of one surface."""
    for contact in contacts:
        refused = {
            "law": contact.law["name"] != "hard-wall",
            "boundary": contact.boundary != "periodic",
            "lower_surface": contact.lower_surface is not None,
            "profile": contact.surface.n[1] == 1,
        }
        for name, is_refused in refused.items():
            if is_refused:
                raise InputError(
                    f"a contact has a {name}; a law for finite elements is of a periodic surface, a hard wall and one"
                    " interface"
                )
    heights = contacts[0].surface.heights if len(contacts) else np.zeros(1)
    return {
        "pressure": [float(contact.mean_pressure) for contact in contacts],
        "first_gap": float(heights.max() - heights.mean()),
        "loads": [_load(contact, conductivity, with_flow) for contact in contacts],
    }


@hinted
def fe_table(
    results: Contacts | Iterable[Contacts],
    *,
    format: Literal["csv", "abaqus", "ansys"] = "csv",
    conductivity: Optional[Sequence[Quantity]] = None,
    flow: bool = False,
) -> str:
    """Returns a contact law for finite elements as text, as `gfmd contact --export-law` does.

    It contains pressure against mean gap, area, stiffness, conductance and transmissivity, in SI units, with errors.

    Args:
        results: contacts of one surface under two or more loads, or several of these, of surfaces of one kind (seeds)
            under the same loads; the numbers are then means, with standard errors.
        format: "csv" (table with all numbers), "abaqus" (keywords for surface behaviour and gap conductance), or
            "ansys" (APDL tables).
        conductivity: thermal conductivities of both bodies, W/(m K), for the contact conductance.
        flow: also compute the gap transmissivity, with one flow problem per load.

    Raises:
        InputError: one load only, unknown units, different loads, an attraction, free boundaries, two interfaces, a
            profile, or a gap that does not fall with the load (full contact).

    Example:
        >>> rough = gfmd.self_affine(n=64, size="100 um", unit="um")
        >>> joint = gfmd.contact(rough, gfmd.Body(young="70 GPa"), pressure=["10 MPa", "0.1 GPa", "1 GPa"])
        >>> text = gfmd.fe_table(joint, format="abaqus", conductivity=("16 W/(m K)", "16 W/(m K)"))
        >>> [line for line in text.splitlines() if line.startswith("*S")][1]
        '*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR'
    """
    all_of = [results] if isinstance(results, (Contact, Contacts)) else list(results)
    for found in all_of:
        if not isinstance(found, Contacts):
            raise InputError(f"results has a {type(found).__name__}; it must have Contacts, of two or more loads")
    units = {found.units for found in all_of}
    if len(units) > 1:
        raise InputError("results have different units; they must have the same")
    length, stress = next(iter(units), (None, None))
    pair = None
    if conductivity is not None:
        both = conductivities(conductivity, length)
        pair = [in_units("conductivity", value, CONDUCTIVITY, length, stress) for value in both]
        if len(pair) != 2 or not all(0.0 < one < math.inf for one in pair):
            raise InputError(f"conductivity is {shown(conductivity)}; it must be two numbers, positive and finite")
    given = [_realisation(found, pair, flag("flow", flow)) for found in all_of]
    return str(_gfmd.law_text(json.dumps(given), length, stress, word("format", format)))
