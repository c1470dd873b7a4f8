"""Output with matplotlib, xarray, pandas, pyvista and for notebooks, if these packages are installed."""

from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _gfmd
from ._check import Array
from ._errors import Error, InputError
from ._record import Record

if TYPE_CHECKING:
    from ._contact import Contact
    from ._surface import Surface


# Length unit and stress unit.
Units = tuple[Optional[str], Optional[str]]


def needed(module: str, use: str) -> Any:
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Error(f"{use} needs {module.split('.')[0]}: pip install {module.split('.')[0]}") from error


def axes(ax: Any) -> Any:
    if ax is not None:
        return ax
    return needed("matplotlib.pyplot", "plot").subplots()[1]


def kind(name: str) -> str:
    """Returns the kind of a number or field."""
    return "length" if name == "height" else _KINDS.get(name, "1")


_KINDS: dict[str, str] = dict(_gfmd.kinds())


def read(of: str, values: Any, units: Units) -> tuple[float, str]:
    """Returns the factor and the name of a readable unit for values of a kind."""
    finite = np.abs(np.asarray(values, dtype=np.float64))
    largest = float(np.max(finite[np.isfinite(finite)], initial=0.0))
    return _gfmd.readable(of, largest, *units) or (1.0, _gfmd.unit_name(of, *units))


def attributes(name: str, units: Units) -> dict[str, str]:
    """Returns the attributes of a variable: its unit, if known."""
    of = kind(name)
    unit = _gfmd.unit_name(of, units[0], units[1] or ("Pa" if units[0] == "m" else None))
    return {"units": unit} if unit != of or of == "1" else {}


def field(
    values: Array, surface: Surface, name: str, ax: Any, units: Optional[Units] = None, contact: Any = None
) -> Any:
    """Draws a map, or the curve of a profile; points in `contact`, if given, have their own colour."""
    ax = axes(ax)
    known = units or (surface.unit, None)
    nx, ny = surface.n
    side, unit = read("length", surface.size[: 1 if ny == 1 else 2], known)
    lx, ly = (length * side for length in surface.size)
    factor, shown = read(kind(name), values, known)
    values = values * factor
    lengthwise = name[:-1].endswith("displacement_")
    words = f"{name[:-2].replace('_', ' ')} $u_{name[-1]}$" if lengthwise else name.replace("_", " ")
    label = f"{words} ({shown})"
    if ny == 1:
        ax.plot(np.arange(nx) * lx / nx, values[:, 0])
        ax.set_ylabel(label)
    else:
        if contact is not None and np.any(contact):
            image = ax.imshow(
                np.where(contact.T, 1.0, np.nan),
                origin="lower",
                extent=(0, lx, 0, ly),
                cmap="Oranges",
                vmin=0,
                vmax=1.5,
            )
            ax.plot([], [], "s", color=image.cmap(1.0 / 1.5), label="contact")
            ax.legend(loc="upper right")
            values = np.where(contact, np.nan, values)
        colours = "magma" if name.endswith("pressure") else "viridis"
        image = ax.imshow(values.T, origin="lower", extent=(0, lx, 0, ly), cmap=colours, interpolation="nearest")
        ax.figure.colorbar(image, ax=ax, label=label)
        ax.set_ylabel(f"y ({unit})")
    ax.set_xlabel(f"x ({unit})")
    return ax


def steps(result: Any, names: tuple[str, str], ax: Any) -> Any:
    """Draws one scalar of the steps of a result against another."""
    for name in names:
        if name not in result.steps:
            raise InputError(f"the scalar is {name!r}; it must be one of {', '.join(result.steps)}")
    x, y = ((name, result.steps[name]) for name in names)
    return loop(x, y, (result.surface.unit, None), ax)


def steps_dataset(result: Any) -> Any:
    """Returns an xarray.Dataset of the scalars of the steps and the fields of a result."""
    units = (result.unit, result.get("stress_unit"))
    axes = ("step", "axis")
    columns = result.steps.items()
    variables = {name: (axes[: values.ndim], values, attributes(name, units)) for name, values in columns}
    for name in result._declared():
        if name in result:
            variables[name] = (("waypoint", "y", "x"), np.swapaxes(result[name], 1, 2), attributes(name, units))
    return needed("xarray", "to_xarray").Dataset(variables, coordinates(result.surface))


def steps_frame(result: Any, columns: Any) -> Any:
    """Returns the numbers of steps or states as a pandas.DataFrame; vector components end in the name of the axis."""
    pandas = needed("pandas", "to_dataframe")
    units = (result.unit, result.get("stress_unit"))
    found: dict[str, Array] = {}
    names: dict[str, str] = {}
    for name, values in columns.items():
        parts = (
            [(name, values)] if values.ndim == 1 else [(f"{name}_{axis}", values[:, k]) for k, axis in enumerate("xy")]
        )
        found.update(parts)
        names.update({part: unit for part, _ in parts for unit in attributes(name, units).values()})
    made = pandas.DataFrame(found)
    made.attrs["units"] = names
    return made


def loop(x: tuple[str, Array], y: tuple[str, Array], units: Units, ax: Any) -> Any:
    """Draws numbers of steps: filled points where x rises, hollow points and a dashed line where it falls."""
    ax = axes(ax)
    shown = []
    for name, values in (x, y):
        factor, unit = read(kind(name), values, units)
        label = name.replace("_", " ")
        shown.append((values * factor, label if unit == "1" else f"{label} ({unit})"))
    (along, x_label), (values, y_label) = shown
    # The first step has no direction and takes the second one's. A step of zero length keeps the last direction.
    signs = np.sign(np.diff(along, prepend=along[:1]))
    for k in range(1, len(signs)):
        signs[k] = signs[k] or signs[k - 1]
    turns = [k for k in range(1, len(signs) - 1) if signs[k + 1] * signs[k] < 0]
    labelled = set()
    for start, end in zip([0, *turns], [*turns, len(along) - 1]):
        falls = bool(signs[end] < 0)
        label = "falling" if falls else "rising"
        style = {"ls": "--", "mfc": "none"} if falls else {"ls": "-"}
        ax.plot(
            along[start : end + 1],
            values[start : end + 1],
            marker="o",
            ms=4,
            color="C1" if falls else "C0",
            label=None if label in labelled else label,
            **style,
        )
        labelled.add(label)
    if len(labelled) > 1:
        ax.legend()
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    return ax


def area(contacts: Sequence[Contact], ax: Any) -> Any:
    ax = axes(ax)
    p_star = [contact["p_star"] for contact in contacts]
    ax.plot(p_star, [contact["area_fraction"] for contact in contacts], "o-", label="counted points")
    ax.plot(
        p_star,
        [contact["area_fraction_corrected"] for contact in contacts],
        "o",
        mfc="none",
        label="perimeter corrected",
    )
    ax.set_xlabel("reduced pressure $p/(E^* g)$")
    ax.set_ylabel("contact area fraction")
    ax.legend()
    return ax


def kappa(points: Sequence[Any], fit: Any, ax: Any) -> Any:
    ax = axes(ax)
    points = [point for point in points if point["p_star"] == fit["p_star"]]
    errors = [np.nan if point["kappa_sem"] is None else point["kappa_sem"] for point in points]
    ax.errorbar(
        [point["n"] for point in points],
        [point["kappa"] for point in points],
        errors,
        fmt="o",
        label=f"$p^* = {fit['p_star']:g}$",
    )
    ax.axhline(fit["kappa_tfc"], color="k", label=r"limit $\kappa_\mathrm{TFC}$")
    if fit["total_ci95"] is not None:
        ax.axhspan(*fit["total_ci95"], color="k", alpha=0.15, label="95 %, with the error of the form")
    ax.set_xscale("log", base=2)
    ax.set_xlabel("points along a side")
    ax.set_ylabel(r"$\kappa$")
    ax.legend()
    return ax


def coordinates(surface: Surface) -> dict[str, Any]:
    (lx, ly), (nx, ny) = surface.size, surface.n
    unit = {} if surface.unit is None else {"units": surface.unit}
    return {"x": ("x", np.arange(nx) * lx / nx, unit), "y": ("y", np.arange(ny) * ly / ny, unit)}


def _columns(records: Sequence[Any], before: str = "") -> Iterator[tuple[str, list[Any]]]:
    """Yields the numbers of records as columns; nested names are prefixed with the outer name."""
    for name, value in records[0].items():
        column = [record[name] for record in records]
        if isinstance(value, Record):
            yield from _columns(column, f"{before}{name}_")
        else:
            yield f"{before}{name}", column


def dataset(contacts: Sequence[Contact]) -> Any:
    xarray = needed("xarray", "to_xarray")
    surface = contacts[0].surface
    units = contacts[0].units
    variables: dict[str, Any] = {"height": (("y", "x"), surface.heights.T, attributes("height", units))}
    for name in contacts[0]._fields:
        values = np.stack([contact._fields[name].T for contact in contacts])
        variables[name] = (("load", "y", "x"), values, attributes(name, units))
    for name, of_loads in _columns(contacts):
        variables[name] = (("load", "axis")[: np.ndim(of_loads)], of_loads, attributes(name, units))
    return xarray.Dataset(variables, coordinates(surface))


def frame(contacts: Sequence[Contact]) -> Any:
    """Returns the numbers of contacts as a pandas.DataFrame."""
    pandas = needed("pandas", "to_dataframe")
    columns = {name: values for name, values in _columns(contacts) if not isinstance(values[0], (list, dict))}
    found = pandas.DataFrame(columns)
    found.attrs["units"] = {name: unit for name in columns for unit in attributes(name, contacts[0].units).values()}
    return found


def _png(values: Array) -> bytes:
    """Returns a greyscale PNG, x to the right and y up, of fewer than 256 points along a side."""
    step = max(1, max(values.shape) // 128)
    part = values[::step, ::step]
    low, high = float(part.min()), float(part.max())
    grey = np.zeros(part.shape, np.uint8) if high == low else (255.0 * ((part - low) / (high - low))).astype(np.uint8)
    rows = np.ascontiguousarray(grey.T[::-1])
    raw = b"".join(b"\x00" + row.tobytes() for row in rows)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def map_html(values: Array, caption: str) -> str:
    """Returns a small map; only the caption for a profile."""
    if values.shape[1] == 1:
        return f"<p>{html.escape(caption)}</p>"
    image = f'<img width="128" src="data:image/png;base64,{base64.b64encode(_png(values)).decode()}">'
    return f"<figure>{image}<figcaption>{html.escape(caption)}</figcaption></figure>"


def table_html(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    cells = ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
    names = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    return f"<table><tr>{names}</tr>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def grid(surface: Surface, fields: dict[str, Array]) -> Any:
    """Returns a pyvista.ImageData with fields as point data, x fastest as in VTK."""
    pyvista = needed("pyvista", "to_pyvista")
    (lx, ly), (nx, ny) = surface.size, surface.n
    image = pyvista.ImageData(dimensions=(nx, ny, 1), spacing=(lx / nx, ly / ny, 1.0))
    for name, values in fields.items():
        image.point_data[name] = values.flatten(order="F")
    return image
