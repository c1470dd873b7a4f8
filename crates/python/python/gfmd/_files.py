"""Result files, in the format of the program."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection
from typing import Any, Literal, Optional, Union

import numpy as np

from . import _check, _gfmd
from ._below import FieldsBelow, Punch, below_of, punch_of
from ._body import body_of, law_of
from ._check import Array
from ._command import body_keys
from ._contact import Contact, Contacts, Settings
from ._errors import InputError
from ._gfmd import StoredFile
from ._kappa import KappaSweep
from ._kappa import made_of as _sweep_of
from ._load import LOADS, of_load
from ._parts import Wear
from ._path import Path, gathered
from ._prony import PronyFit
from ._prony import loaded as _prony_of
from ._record import parsed
from ._result import Contents
from ._slide import Slide
from ._slide import made_of as _slide_of
from ._study import Study
from ._study import made_of as _study_of
from ._surface import Surface, _surface

# Datasets of a problem in a file, by the keys of their options.
_ARRAYS = {
    "hardness": "/surface/hardness",
    "base_displacement": "/base/displacement",
    "base_traction": "/base/traction",
}


def _stored(file: StoredFile, group: str) -> Surface:
    """Reads a surface from a file."""
    size, unit = file.cell(group)
    return _surface(file.array(f"{group}/height"), size, unit, file.text(group, "description"))


def _read(
    file: StoredFile, wanted: Optional[Collection[str]] = None
) -> tuple[dict[str, Any], dict[str, Any], Contents]:
    """Reads the report in a file, its fields by name (the `wanted` ones, all by default), and the bytes of the file."""
    text, names = file.report()
    values = parsed(text)
    names = [field for field in names if wanted is None or field in wanted]
    fields: dict[str, Any] = {field: _check.frozen(file.array(f"/fields/{field}")) for field in names}
    for of_the_run in ("peak_bytes", "plots", "scan", "out"):
        values.pop(of_the_run, None)
    values["warnings"] = _warnings(file)
    return values, fields, Contents(file.bytes())


def _reported(file: StoredFile) -> tuple[dict[str, Any], dict[str, Any], Contents]:
    """Reads the report in a file, its surfaces and fields by name, and the bytes of the file."""
    values, found, contents = _read(file)
    found["surface"] = _stored(file, "/surface")
    if values.get("hardness") is not None and not isinstance(values["hardness"], float):
        found["hardness"] = _check.frozen(file.array("/surface/hardness"))
    if "lower" in values:
        found["lower_surface"] = _stored(file, "/lower")
        values["lower"]["surface"] = file.text("/lower", "description")
    return values, found, contents


def _field(file: StoredFile, field: str, shape: tuple[int, ...]) -> Array:
    """Reads a field from a file and checks its shape."""
    found = file.array(f"/fields/{field}")
    if found.shape != shape:
        raise InputError(f"{file.path}: /fields/{field} has the shape {list(found.shape)}; it must be {list(shape)}")
    return found


def _warnings(file: StoredFile) -> list[dict[str, str]]:
    """Reads the warnings of a file."""
    lines = (line.partition(": ") for line in file.text("/", "warnings").splitlines())
    return [{"code": code, "text": text} for code, _, text in lines]


def _path(file: StoredFile) -> Path:
    """Reads a path from its file."""
    values, found, contents = _reported(file)
    if values.get("coefficient") is not None:
        is_by_slip = 'wear_by = "slip"' in file.text("/", "config")
        by: Literal["distance", "slip"] = "slip" if is_by_slip else "distance"
        found["wear"] = Wear(values["coefficient"], by=by)
    # A file has the largest part of each residual alone.
    for step, largest in zip(values["steps"], file.array("/path/residual")):
        step["residual"] = {"largest": largest}
    return Path({**gathered(values), "unit": found["surface"].unit, **found}, contents)


def _slide(file: StoredFile) -> Slide:
    """Reads steady sliding from its file."""
    values, found, contents = _reported(file)
    for state, largest in zip(values["states"], file.array("/states/residual")):
        state["residual"] = {"largest": largest}
    return _slide_of(values, found, (found.pop("surface"), found.pop("hardness", None)), contents)


def _study(file: StoredFile) -> Study:
    """Reads a study from its file."""
    values, _, contents = _read(file)
    return _study_of(values, contents)


def _sweep(file: StoredFile) -> KappaSweep:
    """Reads a kappa sweep from its file."""
    values, _, contents = _read(file)
    return _sweep_of(values, contents)


def _punch(file: StoredFile) -> Punch:
    """Reads a punch from its file."""
    return punch_of(*_read(file, ("displacement", "traction", "under_punch")))


def _below(file: StoredFile) -> FieldsBelow:
    """Reads fields below a surface from their file."""
    return below_of(*_read(file, ("displacement", "strain", "stress", "von_mises", "energy_density")))


def _heights(file: StoredFile) -> Surface:
    """Reads a surface from its file, which has the positions of its points but not the size of its cell."""
    heights, size, unit, *_ = _gfmd.read(f"{file.path}:/surface/height")
    return _surface(heights, size or (1.0, 1.0), unit, file.text("/surface", "source"))


_Loaded = Union[FieldsBelow, KappaSweep, Path, Punch, Slide, Study, Surface]

# Readers by kind of a file; a contact has more than a report.
_READERS: dict[str | None, Callable[[StoredFile], _Loaded]] = {
    "path": _path,
    "slide": _slide,
    "study": _study,
    "kappa-sweep": _sweep,
    "punch": _punch,
    "body": _below,
    "surface": _heights,
}


def _is_json(name: str) -> bool:
    """Returns True for a file that begins as a JSON object."""
    try:
        with open(name, "rb") as file:
            return file.read(64).lstrip().startswith(b"{")
    except (OSError, ValueError):  # A name with a zero byte is a ValueError.
        return False


def load(
    path: Union[str, "os.PathLike[str]"],
) -> Union[Contact, Contacts, FieldsBelow, KappaSweep, Path, PronyFit, Punch, Slide, Study, Surface]:
    """Reads the result in a file of this package or the program, as the function of its command returned it.

    The file comes from `save`, `out=` or `--out`: a contact, contacts under several loads, a path (also wear and
    friction), steady sliding, a punch, fields below a surface, a kappa sweep, a study, the surface of `gfmd
    surface`, or the Prony series of `gfmd prony --json`. Nothing is solved. Paths and steady sliding have only the
    largest part of each residual, and paths with wear no unit of their coefficient, as their files do.

    Args:
        path: name of an HDF5 file, of a Prony series a JSON file.

    Raises:
        InputError: not a file of these results, or a file that was damaged or changed.

    Example:
        >>> c.save("c.h5")
        >>> gfmd.load("c.h5").area_fraction == c.area_fraction
        True
        >>> loop.save("loop.h5")
        >>> bool((gfmd.load("loop.h5").steps.mean_pressure == loop.steps.mean_pressure).all())
        True
        >>> punch.save("punch.h5")
        >>> gfmd.load("punch.h5") == punch
        True
    """
    name = _check.path("path", path)
    if _is_json(name):
        return _prony_of(name)
    file = StoredFile(name)
    file.check()
    if file.kind in _READERS:
        return _READERS[file.kind](file)
    # Checked for keys and types, as a file may come from anyone.
    config = json.loads(file.config())
    surface = _stored(file, "/surface")
    lower = _stored(file, "/lower") if "lower_surface" in config or "lower_seed" in config else None
    body, law = body_of(config), law_of(config)
    options = {
        key: value
        for key, value in config.items()
        if (key in _gfmd.options() or key == "stress_unit") and key != "lower_seed"
    }
    arrays = {
        key: _check.frozen(file.array(dataset)) for key, dataset in _ARRAYS.items() if isinstance(config.get(key), str)
    }
    if lower is not None:
        options["lower_surface"], arrays["lower_surface"] = "array", lower.heights
    settings = Settings({"size": list(surface.size), **body_keys(body), **options}, arrays, lower)
    reported, names = file.records()
    records = [of_load(record) for record in reported]
    shape = (len(records), *surface.heights.shape)
    fields = {field: _field(file, field, shape) for field in names}
    control, asked = next(((key, config[key]) for key in LOADS if config.get(key)), ("", []))

    def contact(index: int) -> Contact:
        own = {field: np.ascontiguousarray(column[index]) for field, column in fields.items()}
        load = (control, float(asked[index])) if index < len(asked) and asked[index] is not None else None
        return Contact(records[index], (surface, body, law), own, settings._replace(load=load))

    contacts = [contact(index) for index, record in enumerate(records) if np.isfinite(record["mean_pressure"])]
    return contacts[0] if len(contacts) == 1 else Contacts(contacts)
