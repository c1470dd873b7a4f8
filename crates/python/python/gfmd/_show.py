"""Output for matplotlib, xarray, pandas, pyvista and notebooks, if these packages are installed."""

from __future__ import annotations

import base64
import html
import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import Any, Optional

import numpy as np

from ._check import Array, shown
from ._errors import Error, InputError
from ._record import Record
from ._types import Cell, Pressed
from ._units import Units, attributes, kind, readable


def needed(module: str, use: str) -> Any:
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Error(f"{use} needs {module.split('.')[0]}: pip install {module.split('.')[0]}") from error


# Style of the figures that the program draws: colours of Okabe and Ito, ticks inside on all sides.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#222222")
TICKS = {"xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True}
# Points of a pressure map without contact.
PALE = "#e9e9e6"


def axes(ax: Any) -> Any:
    """Returns the axes, or new ones in the style of the program unless the user has chosen a style."""
    if ax is not None:
        return ax
    pyplot, matplotlib = needed("matplotlib.pyplot", "plot"), needed("matplotlib", "plot")
    style = {**TICKS, "axes.prop_cycle": matplotlib.cycler(color=COLOURS)}
    usual = matplotlib.rcParamsDefault
    # The first figure makes a notebook interactive, which the end of the context would undo.
    figure = pyplot.figure()
    with pyplot.rc_context({key: value for key, value in style.items() if pyplot.rcParams[key] == usual[key]}):
        return figure.add_subplot()


def hue(index: int) -> str:
    """Returns a colour of the program, or of the style that the user has chosen."""
    matplotlib = needed("matplotlib", "plot")
    own = matplotlib.rcParams["axes.prop_cycle"]
    return COLOURS[index] if own == matplotlib.rcParamsDefault["axes.prop_cycle"] else f"C{index}"


def field(values: Array, surface: Cell, name: str, ax: Any, units: Optional[Units] = None, contact: Any = None) -> Any:
    """Draws a map, or a curve for a profile; points in `contact`, if given, have their own colour."""
    named, component = (name[:-2], name[-1]) if name[:-1].endswith("displacement_") else (name, None)
    return map_of(values, surface.size, named, component, units or (surface.unit, None), ax, contact=contact)


def map_of(
    values: Array,
    size: Sequence[float],
    name: str,
    component: Optional[str],
    units: Units,
    ax: Any,
    along: str = "x",
    contact: Any = None,
) -> Any:
    """Draws a map of a number [x, y] in a cell, or a curve if there is only one point across."""
    ax = axes(ax)
    nx, ny = values.shape
    side, unit = readable("length", size[: 1 if ny == 1 else 2], units)
    factor, in_unit = readable(kind(name), values, units)
    values = values * factor
    words = name.replace("_", " ")
    if component is not None:
        symbol = {"displacement": "u", "traction": "t", "strain": r"\epsilon", "stress": r"\sigma"}.get(words, "u")
        words = f"{words} ${symbol}_{component if len(component) == 1 else f'{{{component}}}'}$"
    label = f"{words} ({in_unit})"
    lx = size[0] * side
    if ny == 1:
        ax.plot(np.arange(nx) * lx / nx, values[:, 0])
        ax.set_ylabel(label)
    else:
        ly = size[1] * side
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
        colours: dict[str, Any] = {"cmap": "viridis"}
        if name.endswith("pressure"):
            ax.set_facecolor(PALE)
            values = np.where(values == 0, np.nan, values)
            colours["vmin"] = 0.0
            if (attraction := -np.nanmin(values, initial=0.0)) > 1e-6 * np.nanmax(values, initial=0.0):
                # The few largest pressures at sharp peaks would hide the attraction.
                end = max(attraction, np.quantile(values[values > 0], 0.995) if np.any(values > 0) else 0.0)
                colours = {"cmap": "RdBu", "vmin": -end, "vmax": end}
        image = ax.imshow(values.T, origin="lower", extent=(0, lx, 0, ly), interpolation="nearest", **colours)
        ax.figure.colorbar(image, ax=ax, label=label)
        ax.set_ylabel(f"y ({unit})")
    ax.set_xlabel(f"{along} ({unit})")
    return ax


def described(of: Any, name: str, units: Optional[Units] = None) -> dict[str, str]:
    """Returns the attributes of a record variable: the first sentence of its definition, and its unit."""
    found = attributes(name, of.units if units is None else units)
    defined = getattr(type(of), name, None)
    _, colon, text = (defined.__doc__ or "").partition(": ") if isinstance(defined, property) else ("", "", "")
    return {**found, "long_name": re.split(r"\. |\.$|;", text)[0]} if colon else found


def column(table: Record, name: Any) -> tuple[str, Array]:
    """Returns name and values of a step or state number."""
    table = flat(table)
    if not isinstance(name, str) or name not in table or table[name].ndim != 1:
        scalars = (key for key, values in table.items() if values.ndim == 1)
        raise InputError(f"the scalar is {shown(name)}; it must be one of {', '.join(scalars)}")
    return name, table[name]


def steps(result: Any, names: tuple[str, str], ax: Any) -> Any:
    """Draws one step number of a result against another."""
    x, y = (column(result.steps, name) for name in names)
    return loop(x, y, result.units, ax)


def states(result: Any, names: tuple[str, str], ax: Any) -> Any:
    """Draws one state number of a result against another, with one curve per load."""
    (along, x), (name, y) = (column(result.states, name) for name in names)
    ax = axes(ax)
    velocity = result.states.get("velocity", x)
    # The k-th state of each velocity has the k-th load.
    load = np.array([np.sum(velocity[:index] == value) for index, value in enumerate(velocity)], dtype=int)
    (x_factor, x_label), (y_factor, y_label) = (caption(*pair, result.units) for pair in ((along, x), (name, y)))
    for index in range(load.max(initial=-1) + 1):
        own = np.flatnonzero(load == index)
        own = own[np.argsort(x[own], kind="stable")]
        p_star = float(np.mean(result.states.p_star[own]))
        ax.plot(x[own] * x_factor, y[own] * y_factor, "o-", ms=4, label=f"$p^* = {p_star:.3g}$")
    if load.max(initial=0) > 0:
        ax.legend()
    if along == "velocity" and x.size and 0.0 < 10.0 * x.min() < x.max():
        ax.set_xscale("log")
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    return ax


def caption(name: str, values: Array, units: Units) -> tuple[float, str]:
    """Returns the factor to a readable unit, and the axis label."""
    factor, unit = readable(kind(name), values, units)
    words = name.replace("_", " ")
    return factor, words if unit == "1" else f"{words} ({unit})"


def flat(table: Record) -> Record:
    """Returns the columns of a table with groups flattened to `group_part`."""
    columns: dict[str, Any] = {}
    for name, values in table.items():
        parts = values.items() if isinstance(values, Record) else [("", values)]
        columns.update({f"{name}_{part}" if part else name: own for part, own in parts})
    return Record(columns)


def table_dataset(result: Any, table: Record, row: str, field_row: str) -> Any:
    """Returns the scalars [row] and fields [field_row, y, x] of a result as an xarray.Dataset."""
    table = flat(table)
    units, count = result.units, max((len(values) for values in table.values()), default=0)
    along = {"velocity"} & set(table)
    variables = {
        name: ((row, "axis")[: values.ndim], values, described(table, name, units))
        for name, values in table.items()
        if name not in along
    }
    for name in result._declared():
        if name in result:
            # A state that was not reached has a field, of NaN.
            values = result[name][:count] if field_row == row else result[name]
            variables[name] = ((field_row, "y", "x"), np.swapaxes(values, 1, 2), described(result, name))
    rows: dict[str, Any] = {row: (row, np.arange(count), {"long_name": row})}
    if field_row != row:
        reached = max((len(values) for name, values in result.items() if name in result._declared()), default=0)
        rows[field_row] = (field_row, np.arange(reached), {"long_name": field_row})
    if any(values.ndim == 2 for values in table.values()):
        rows["axis"] = ("axis", ["x", "y"])
    rows.update({name: (row, table[name], described(table, name, units)) for name in along})
    return needed("xarray", "to_xarray").Dataset(variables, {**coordinates(result.surface), **rows})


def table_frame(result: Any, columns: Record) -> Any:
    """Returns step or state numbers as a pandas.DataFrame; names of vector components end in the axis."""
    found: dict[str, Array] = {}
    names: dict[str, str] = {}
    for name, values in flat(columns).items():
        parts = (
            [(name, values)] if values.ndim == 1 else [(f"{name}_{axis}", values[:, k]) for k, axis in enumerate("xy")]
        )
        found.update(parts)
        names.update({part: name for part, _ in parts})
    return framed(found, names, result.units)


def framed(columns: Any, names: dict[str, str], units: Units) -> Any:
    """Returns a pandas.DataFrame with the units of its columns, which are numbers by `names`, in `attrs["units"]`."""
    made = needed("pandas", "to_dataframe").DataFrame(columns)
    found = {column: attributes(name, units).get("units") for column, name in names.items()}
    made.attrs["units"] = {column: unit for column, unit in found.items() if unit is not None}
    return made


def loop(x: tuple[str, Array], y: tuple[str, Array], units: Units, ax: Any) -> Any:
    """Draws step numbers: filled points where x rises, hollow points and a dashed line where it falls."""
    ax = axes(ax)
    (along, x_label), (values, y_label) = (
        (of * factor, label) for name, of in (x, y) for factor, label in [caption(name, of, units)]
    )
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
            color=hue(int(falls)),
            label=None if label in labelled else label,
            **style,
        )
        labelled.add(label)
    if len(labelled) > 1:
        ax.legend()
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    return ax


def losses(x: tuple[str, Array], energies: dict[str, Array], units: Units, ax: Any) -> Any:
    """Draws the energy lost by each cause, and the sum, in one unit."""
    ax = axes(ax)
    x_factor, x_label = caption(*x, units)
    factor, label = caption("dissipated", np.concatenate(list(energies.values())), units)
    for name, lost in energies.items():
        is_sum = name == "dissipated"
        style: dict[str, Any] = {"color": "k", "ls": "--"} if is_sum else {"marker": "o", "ms": 4}
        words = "all" if is_sum else name.partition("_")[2].replace("_", " ")
        ax.plot(x[1] * x_factor, lost * factor, label=words, **style)
    ax.legend()
    ax.set_xlabel(x_label)
    ax.set_ylabel(label.replace("dissipated", "energy lost so far"))
    return ax


def area(contacts: Sequence[Pressed], ax: Any) -> Any:
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


def coordinates(surface: Cell) -> dict[str, Any]:
    """Returns the coordinates x and y of the points."""
    return places(surface.size, surface.n, surface.unit)


def places(size: Sequence[float], n: Sequence[int], unit: Optional[str]) -> dict[str, Any]:
    """Returns the point coordinates of a cell along x, and along y if both lengths are given."""
    own = {} if unit is None else {"units": unit}
    return {
        axis: (axis, np.arange(points) * length / points, {"long_name": axis, **own})
        for axis, length, points in zip("xy", size, n)
    }


def _columns(records: Sequence[Any], before: str = "") -> Iterator[tuple[str, list[Any]]]:
    """Yields the numbers of records as columns; nested names are prefixed with the outer name."""
    for name, value in records[0].items():
        column = [record[name] for record in records] if name != "undefined" else []
        if isinstance(value, Record):
            yield from _columns(column, f"{before}{name}_")
        elif column:
            yield f"{before}{name}", column


def dataset(contacts: Sequence[Pressed]) -> Any:
    xarray = needed("xarray", "to_xarray")
    surface = contacts[0].surface
    units = contacts[0].units
    variables: dict[str, Any] = {"height": (("y", "x"), surface.heights.T, attributes("height", units))}
    for name in contacts[0]._fields:
        values = np.stack([contact._fields[name].T for contact in contacts])
        variables[name] = (("load", "y", "x"), values, described(contacts[0], name))
    for name, of_loads in _columns(contacts):
        variables[name] = (("load", "axis")[: np.ndim(of_loads)], of_loads, described(contacts[0], name))
    load = {"load": ("load", np.arange(len(contacts)), {"long_name": "load step"})}
    return xarray.Dataset(variables, {**coordinates(surface), **load})


def frame(contacts: Sequence[Pressed]) -> Any:
    """Returns the numbers of contacts as a pandas.DataFrame."""
    columns = {name: values for name, values in _columns(contacts) if not isinstance(values[0], (list, dict))}
    return framed(columns, dict(zip(columns, columns)), contacts[0].units)


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


def grid(surface: Cell, fields: dict[str, Array]) -> Any:
    """Returns a pyvista.ImageData with fields as point data, x fastest as in VTK."""
    pyvista = needed("pyvista", "to_pyvista")
    (lx, ly), (nx, ny) = surface.size, surface.n
    image = pyvista.ImageData(dimensions=(nx, ny, 1), spacing=(lx / nx, ly / ny, 1.0))
    for name, values in fields.items():
        image.point_data[name] = values.flatten(order="F")
    return image
