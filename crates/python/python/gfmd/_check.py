"""Checks of arguments. Errors name the value found and the values allowed."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _gfmd
from ._errors import InputError

Array = npt.NDArray[np.float64]


def shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def unmasked(name: str, value: object) -> None:
    """Refuses masked entries, whose numbers mean nothing."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        count = int(np.ma.getmaskarray(value).sum())
        raise InputError(f"{name} has {count} masked of {value.size} entries; every entry must be a number")


def number(name: str, value: object) -> float:
    """Checks a Python or NumPy number other than NaN; strings are refused."""
    unmasked(name, value)
    if not isinstance(value, (str, bytes, bool, np.bool_)):
        try:
            array = np.asarray(value)
            if array.shape == () and array.dtype.kind in "fiu":
                found = float(array)
                if not math.isnan(found):
                    return found
            elif isinstance(value, int):
                return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    raise InputError(f"{name} is {shown(value)}; it must be a number")


def optional(name: str, value: object) -> Optional[float]:
    return None if value is None else number(name, value)


# A number, or a string with a unit, such as "70GPa".
Quantity = Union[float, str]


# Kinds of the numbers of options in turn, by argument, for options whose numbers may have a unit.
KINDS = _gfmd.option_kinds()

# Kind of a thermal conductivity.
CONDUCTIVITY = "stress*length^2/time/temperature"


def kind_of(name: str, place: int = 0) -> str:
    """Returns the kind of a number of an option, by its place in the list of them."""
    kinds = KINDS.get(name, ["1"])
    return kinds[place % len(kinds)]


def in_units(
    name: str, value: object, kind: Optional[str] = None, unit: Optional[str] = "m", stress: Optional[str] = "Pa"
) -> float:
    """Converts a string with a unit of this kind (default: the kind of the option `name`) to these units (default SI).
    Returns a number unchanged.
    """
    if not isinstance(value, str):
        return number(name, value)
    found = _gfmd.in_units(name, word(name, value), kind_of(name) if kind is None else kind, unit, stress)
    if found is None:
        raise InputError(f"{name} is {shown(value)}; it must be a number, or a text with a unit")
    return found


def quantity(name: str, value: object, kind: Optional[str] = None) -> Quantity:
    """Checks a number, or a string with a unit of this kind, by default the kind of the option `name`."""
    found = in_units(name, value, kind)
    return value if isinstance(value, str) else found


def quantities(name: str, value: Any, kind: Optional[str] = None) -> list[Quantity]:
    """Checks one or several quantities of this kind, by default the kind of the option `name`."""
    entries = several(name, value)
    if entries is None:
        return [quantity(name, value, kind)]
    if hasattr(value, "dtype") or not any(isinstance(entry, str) for entry in entries):
        return [*numbers(name, entries)]
    return [quantity(name, entry, kind) for entry in entries]


def integer(name: str, value: Any, least: int = 0, most: int = 2**63 - 1) -> int:
    unmasked(name, value)
    if not isinstance(value, (bool, np.bool_)):
        try:
            found = operator.index(value)
            if least <= found <= most:
                return found
        except (TypeError, ValueError, OverflowError):
            pass
    is_large = isinstance(value, int) and value > most
    limits = f"between {least} and {most}" if most < 2**63 - 1 or is_large else f"at least {least}"
    raise InputError(f"{name} is {shown(value)}; it must be a whole number, {limits}")


def word(name: str, value: object) -> str:
    """Checks a string that UTF-8 can encode, which excludes lone surrogates."""
    try:
        if isinstance(value, str):
            value.encode()
            return value
    except UnicodeEncodeError:
        pass
    raise InputError(f"{name} is {shown(value)}; it must be a text")


def path(name: str, value: Any) -> str:
    """Checks the path of a file."""
    try:
        return word(name, os.fsdecode(value))
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is {shown(value)}; it must be the path of a file") from error


def flag(name: str, value: object) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} is {shown(value)}; it must be True or False")
    return bool(value)


def is_sequence(value: Any) -> bool:
    """Returns True for several values, False for one: a number, a text or an array without dimensions."""
    return isinstance(value, Iterable) and not isinstance(value, (str, bytes)) and getattr(value, "shape", None) != ()


def several(name: str, value: Any, kind: str = "number") -> list[Any] | None:
    """Returns the values of a sequence, at least one; None for a single value."""
    unmasked(name, value)
    if not is_sequence(value):
        return None
    try:
        found = list(value)
    except Exception as error:
        raise InputError(f"{name} is {shown(value)}; it must be {kind}s") from error
    if not found:
        raise InputError(f"{name} is empty; it must have at least one {kind}")
    return found


def conductivities(values: Any, unit: Optional[str]) -> list[Quantity]:
    """Checks thermal conductivities: strings with a unit, or numbers in W/(m K) if the surface has a unit."""
    found = quantities("conductivity", values, CONDUCTIVITY)
    return [one if isinstance(one, str) or unit is None else f"{one!r} W/(m K)" for one in found]


def texts(name: str, value: Any) -> list[str]:
    """Checks one or several strings."""
    entries = [value] if isinstance(value, str) else several(name, value, "text")
    if entries is None:
        raise InputError(f"{name} is {shown(value)}; it must be texts")
    return [word(name, entry) for entry in entries]


def numbers(name: str, value: Any) -> list[float]:
    """Checks one or several numbers."""
    entries = several(name, value)
    return [number(name, entry) for entry in ([value] if entries is None else entries)]


def integers(name: str, value: Any) -> list[int]:
    """Checks one or several whole numbers from 1."""
    entries = several(name, value)
    return [integer(name, entry, 1) for entry in ([value] if entries is None else entries)]


def heights(value: Any) -> tuple[Array, int]:
    """Copies heights to [x, y], row-major, with NaN at undefined points. Also returns their number."""
    wanted = "an array of 1 or 2 dimensions of finite numbers"
    if isinstance(value, (str, bytes)):
        raise InputError(f"heights is the text {shown(value)}; it must be {wanted} (gfmd.read reads files)")
    try:
        given = np.ma.asarray(value) if isinstance(value, np.ma.MaskedArray) else np.asarray(value)
    except Exception as error:
        raise InputError(f"heights is {shown(value)}; it must be {wanted}") from error
    if given.dtype.kind not in "fiu":
        raise InputError(f"heights has the type {given.dtype}; it must be {wanted}")
    if given.ndim == 1:
        given = given[:, np.newaxis]
    elif given.ndim != 2:
        raise InputError(f"heights has the shape {list(given.shape)}; it must be {wanted}")
    nx, ny = given.shape
    if nx == 1 and ny > 1:
        raise InputError(f"heights has the shape [1, {ny}]; a profile has the shape [{ny}] or [{ny}, 1]")
    if nx < 2 or ny < 1:
        raise InputError(f"heights has the shape [{nx}, {ny}]; it must have at least 2 points along each axis")
    with np.errstate(all="ignore"):
        copy = np.array(np.ma.getdata(given), dtype=np.float64, order="C", copy=True, subok=False)
    if isinstance(given, np.ma.MaskedArray):
        copy[np.ma.getmaskarray(given)] = np.nan
    if np.isfinite(copy).all():
        return copy, 0
    if np.isinf(copy).any():
        i, j = (int(k) for k in np.argwhere(np.isinf(copy))[0])
        raise InputError(
            f"heights has {int(np.isinf(copy).sum())} infinite points, the first at [{i}, {j}]; every height must be"
            " finite"
        )
    return copy, int(np.isnan(copy).sum())


def whole(name: str, found: Array, undefined: int, lengths: tuple[float, float], fill: Optional[str]) -> Array:
    """Fills the undefined points of heights."""
    how = None if fill is None else word("fill", fill)
    if how is not None and how not in ("harmonic", "nearest"):
        raise InputError(f"fill is {how!r}; it must be 'harmonic', 'nearest' or None")
    if not undefined:
        return found
    if how is None:
        i, j = (int(k) for k in np.argwhere(np.isnan(found))[0])
        raise InputError(
            f"{name} has {undefined} undefined points of {found.size}, the first at [{i}, {j}]; every point needs a"
            " height: fill='harmonic' or 'nearest' gives one, and gfmd.read_heights reads a file with NaN there,"
            " to cut the good part out"
        )
    return _gfmd.fill(found, lengths, how)


def array(name: str, value: Any) -> Array:
    """Copies an array of real numbers or flags to float64."""
    unmasked(name, value)
    try:
        given = np.asarray(value)
        if given.dtype.kind in "fiub":
            return np.array(given, dtype=np.float64)
    except Exception as error:
        raise InputError(f"{name} is {shown(value)}; it must be an array of numbers") from error
    raise InputError(f"{name} has the type {given.dtype}; it must be an array of numbers")


def plain(name: str, value: Any) -> Any:
    """Checks the value of an option: a string, a flag, a number, a list of these, or an array."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return array(name, value)
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, str):
        return word(name, value)
    if isinstance(value, (list, tuple)):
        return [plain(name, entry) for entry in value]
    return (
        integer(name, value, -(2**63)) if hasattr(value, "__index__") and np.ndim(value) == 0 else number(name, value)
    )


def frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array


def size(value: Any, shape: tuple[int, ...], unit: Optional[str] = None) -> tuple[float, float]:
    """Returns the cell lengths for None (1), L along x, or (Lx, Ly). L alone gives equal spacing along both axes."""
    nx, ny = shape
    given = (
        [] if value is None else [in_units("size", length, None, unit, None) for length in quantities("size", value)]
    )
    if len(given) > 2:
        raise InputError(f"size is {shown(value)}; it must be L or (Lx, Ly)")
    along_x = given[0] if given else 1.0
    along_y = given[1] if len(given) == 2 else (1.0 if ny == 1 else along_x * ny / nx)
    for length in (along_x, along_y):
        if not (0.0 < length < math.inf):
            raise InputError(f"size is {shown(value)}; lengths must be positive and finite")
    return along_x, along_y
