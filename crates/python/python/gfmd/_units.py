"""Kinds and units of numbers and fields."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any, Optional

import numpy as np

from . import _gfmd

# Length unit and stress unit, None where unknown.
Units = tuple[Optional[str], Optional[str]]

# Classes of result numbers and fields, with their definitions.
DEFINED: dict[str, Any] = json.loads(Path(__file__).with_name("_columns.json").read_text(encoding="utf-8"))


def _defined_kind(text: str) -> Optional[str]:
    """Returns the kind before the colon of a definition, such as "stress*length"; None if it has none."""
    head, colon, _ = text.partition(":")
    words = re.sub(r" \[.*?\]| along x and y| by component", "", head).lower().replace(" * ", "*")
    named = {"without unit": "1", "count": "1", "flag": "1", "seconds": "s"}
    return named.get(words, words.replace("per ", "1/")) if colon else None


# Kinds of numbers and fields, by name.
KINDS: dict[str, str] = {
    **{
        name: kind
        for made in DEFINED["classes"].values()
        for name, text in made["attributes"].items()
        for kind in [_defined_kind(text)]
        if kind is not None
    },
    **dict(_gfmd.kinds()),
    **dict.fromkeys(("height", "displacement", "max_displacement", "range", "process_zone"), "length"),
    **dict.fromkeys(("traction", "stress", "von_mises", "energy_density", "mean_energy_density"), "stress"),
    **dict.fromkeys(("max_von_mises", "lowest_mean_pressure"), "stress"),
    "tangential_stiffness": "stress/length",
    "work": "stress*length",
    "transmissivity": "length^3",
}


def metre(unit: Optional[str]) -> float:
    """Returns the length unit in metres; 1 if unknown."""
    return 1.0 if unit is None else _gfmd.in_units("unit", f"1 {unit}", "length", "m") or 1.0


def known(unit: Optional[str], stress: Optional[str] = None) -> Units:
    """Returns both units; stresses are in Pa by default if lengths are in m."""
    return unit, stress or ("Pa" if unit == "m" else None)


def kind(name: str) -> str:
    """Returns the kind of a number or field."""
    return KINDS.get(name, "1")


def readable(of: str, values: Any, units: Units) -> tuple[float, str]:
    """Returns the factor and the name of a readable unit for values of a kind."""
    finite = np.abs(np.asarray(values, dtype=np.float64))
    largest = float(np.max(finite[np.isfinite(finite)], initial=0.0))
    return _gfmd.readable(of, largest, *units) or (1.0, _gfmd.unit_name(of, *units))


def label(words: str, name: str, values: Any, units: Units) -> tuple[float, str]:
    """Returns the factor to a readable unit, and `words` with its name, if it has one."""
    of = kind(name)
    factor, unit = readable(of, values, units)
    return factor, words if unit in ("1", of) else f"{words} / {unit}"


def attributes(name: str, units: Units) -> dict[str, str]:
    """Returns the attributes of a variable: its name in words, and its unit, if known."""
    of = kind(name)
    unit = _gfmd.unit_name(of, *known(*units))
    return {"long_name": name.replace("_", " "), **({"units": unit} if unit != of or of in ("1", "s") else {})}


def text(name: str, value: float, units: Units, limit: Optional[float] = None, error: float = math.nan) -> str:
    """Formats a number with its unit, to the digits that its grid error leaves certain, if it has a limit."""
    of = KINDS.get(name)
    unit = _gfmd.readable(of, value, *units) if of is not None and math.isfinite(value) else None
    factor, after = (1.0, "") if unit is None else (unit[0], f" {unit[1]}")
    if limit is not None and math.isfinite(value):
        return _gfmd.with_limit(value * factor, limit * factor, error * factor) + after
    return f"{float(f'{value * factor:.6g}'):g}{after}" if after else f"{value:.6g}"
