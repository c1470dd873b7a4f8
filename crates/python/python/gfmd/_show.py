"""Figures, notebooks, xarray: used if they are installed."""

from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._check import Array
from ._errors import Error
from ._record import Record

if TYPE_CHECKING:
    from ._contact import Contact
    from ._surface import Surface


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


def units(name: str, surface: Surface) -> str:
    """The unit of a field."""
    return "stress" if name.endswith("pressure") else surface.unit or "length"


def field(values: Array, surface: Surface, name: str, ax: Any) -> Any:
    ax = axes(ax)
    unit = surface.unit or "length"
    (lx, ly), (nx, ny) = surface.size, surface.n
    lengthwise = name[:-1].endswith("displacement_")
    words = f"{name[:-2].replace('_', ' ')} $u_{name[-1]}$" if lengthwise else name.replace("_", " ")
    label = f"{words} ({units(name, surface)})"
    if ny == 1:
        ax.plot(np.arange(nx) * lx / nx, values[:, 0])
        ax.set_ylabel(label)
    else:
        colours = "magma" if name.endswith("pressure") else "viridis"
        image = ax.imshow(values.T, origin="lower", extent=(0, lx, 0, ly), cmap=colours, interpolation="nearest")
        ax.figure.colorbar(image, ax=ax, label=label)
        ax.set_ylabel(f"y ({unit})")
    ax.set_xlabel(f"x ({unit})")
    return ax


def area(contacts: Sequence[Contact], ax: Any) -> Any:
    ax = axes(ax)
    p_star = [contact["p_star"] for contact in contacts]
    ax.plot(p_star, [contact["area_fraction"] for contact in contacts], "o-", label="counted points")
    ax.plot(p_star, [contact["area_fraction_corrected"] for contact in contacts], "o", mfc="none", label="perimeter corrected")
    ax.set_xlabel("reduced pressure $p/(E^* g)$")
    ax.set_ylabel("contact area fraction")
    ax.legend()
    return ax


def kappa(points: Sequence[Any], fit: Any, ax: Any) -> Any:
    ax = axes(ax)
    points = [point for point in points if point["p_star"] == fit["p_star"]]
    errors = [np.nan if point["kappa_sem"] is None else point["kappa_sem"] for point in points]
    ax.errorbar([point["n"] for point in points], [point["kappa"] for point in points], errors, fmt="o", label=f"$p^* = {fit['p_star']:g}$")
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
    length = surface.unit or "length"
    return {"x": ("x", np.arange(nx) * lx / nx, {"units": length}), "y": ("y", np.arange(ny) * ly / ny, {"units": length})}


def _columns(records: Sequence[Any], before: str = "") -> Iterator[tuple[str, list[Any]]]:
    """The numbers of records as columns; parts of a part have its name before theirs."""
    for name, value in records[0].items():
        column = [record[name] for record in records]
        if isinstance(value, Record):
            yield from _columns(column, f"{before}{name}_")
        else:
            yield f"{before}{name}", column


def dataset(contacts: Sequence[Contact]) -> Any:
    xarray = needed("xarray", "to_xarray")
    surface = contacts[0].surface
    length = surface.unit or "length"
    variables: dict[str, Any] = {"height": (("x", "y"), surface.heights, {"units": length})}
    for name in contacts[0]._fields:
        values = np.stack([contact._fields[name] for contact in contacts])
        variables[name] = (("load", "x", "y"), values, {"units": units(name, surface)})
    for name, of_loads in _columns(contacts):
        variables[name] = (("load", "axis")[: np.ndim(of_loads)], of_loads)
    return xarray.Dataset(variables, coordinates(surface))


def _png(values: Array) -> bytes:
    """A grey map, x to the right and y upwards, of at most 128 points along a side."""
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


_MOST_MAPS = 6


def maps_html(fields: Sequence[Array], caption: str) -> str:
    """Small maps side by side, of at most six of the fields; of profiles, the caption alone."""
    if not fields or fields[0].shape[1] == 1:
        return f"<p>{html.escape(caption)}</p>"
    kept = [fields[round(k)] for k in np.linspace(0, len(fields) - 1, min(len(fields), _MOST_MAPS))]
    images = "".join(f'<img width="128" src="data:image/png;base64,{base64.b64encode(_png(field)).decode()}"> ' for field in kept)
    return f"<figure>{images}<figcaption>{html.escape(caption)}</figcaption></figure>"


def table_html(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    cells = ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
    names = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    return f"<table><tr>{names}</tr>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def grid(surface: Surface, fields: dict[str, Array]) -> Any:
    """Fields as point data of a pyvista.ImageData, x fastest as VTK has it."""
    pyvista = needed("pyvista", "to_pyvista")
    (lx, ly), (nx, ny) = surface.size, surface.n
    image = pyvista.ImageData(dimensions=(nx, ny, 1), spacing=(lx / nx, ly / ny, 1.0))
    for name, values in fields.items():
        image.point_data[name] = values.flatten(order="F")
    return image
