"""Paths, punches, fields below the surface, Green's functions, kappa sweeps: the commands of the program in this process."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path as File
from typing import Any, Optional, Union

import numpy as np

from . import _gfmd
from ._body import Body, as_body, as_law
from ._check import Array, frozen, integer, number, numbers, word
from ._contact import Contact
from ._errors import InputError, Interrupted, NotConverged
from ._progress import Progress
from ._record import Record, parsed
from ._surface import Surface, as_surface


class Path(Record):
    """A contact along a path. `steps` is a Record of arrays over the steps (`path.steps.mean_pressure`); `pressure`, `gap` and,
    with lateral motion, `shear_x`, `shear_y` are [waypoint, x, y]."""

    def plot(self, x: str = "displacement", y: str = "mean_pressure", ax: Any = None) -> Any:
        """One scalar of the steps against another, with matplotlib. Returns the axes.

        Example:
            >>> loop.plot("displacement", "mean_pressure")
        """
        from . import _show

        ax = _show.axes(ax)
        ax.plot(self["steps"][x], self["steps"][y], ".-")
        ax.set_xlabel(x.replace("_", " "))
        ax.set_ylabel(y.replace("_", " "))
        return ax

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the scalars [step].

        Example:
            >>> loop.to_xarray().dissipated
        """
        from . import _show

        steps = {name: (("step", "axis")[: values.ndim], values) for name, values in self["steps"].items()}
        return _show._needed("xarray", "to_xarray").Dataset(steps)


class Punch(Record):
    """A flat punch on a body: the keys of `gfmd punch --json`, and `displacement`, `traction` [x, y, component]."""


class FieldsBelow(Record):
    """Fields below a surface: `displacement` [depth, x, y, component], `strain`, `stress` [depth, x, y, tensor],
    `von_mises`, `energy_density` [depth, x, y], and `levels`."""


class Green(Record):
    """The elasticity of one wave vector: complex matrices by the keys of `gfmd green --json`."""


class KappaSweep(Record):
    """A kappa sweep: `points` (a list of Records), `fit`, `fits`, `theory`."""

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the points [point].

        Example:
            >>> gfmd.kappa_sweep("smoke").to_xarray().kappa
        """
        from . import _show

        names = dict.fromkeys(name for point in self["points"] for name in point)
        columns = {name: ("point", [point.get(name, np.nan) for point in self["points"]]) for name in names}
        return _show._needed("xarray", "to_xarray").Dataset(columns)

    def plot(self, ax: Any = None) -> Any:
        """Kappa of every point over its number of points along a side, and the limit, with matplotlib. Returns the axes.

        Example:
            >>> gfmd.kappa_sweep("smoke").plot()
        """
        from . import _show

        ax = _show.axes(ax)
        points = self["points"]
        errors = [np.nan if point["kappa_sem"] is None else point["kappa_sem"] for point in points]
        ax.errorbar([point["n"] for point in points], [point["kappa"] for point in points], errors, fmt="o", label="sweep")
        fit = self["fit"]
        ax.axhline(fit["kappa_tfc"], color="k", label=r"limit $\kappa_\mathrm{TFC}$")
        if fit["total_ci95"] is not None:
            ax.axhspan(*fit["total_ci95"], color="k", alpha=0.15, label="95 % with the error of the form")
        ax.set_xscale("log", base=2)
        ax.set_xlabel("points along a side")
        ax.set_ylabel(r"$\kappa$")
        ax.legend()
        return ax


def _records(value: Any) -> Any:
    if isinstance(value, dict):
        return Record({name: _records(entry) for name, entry in value.items()})
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        return [_records(entry) for entry in value]
    return value


def _flags(**values: Any) -> list[str]:
    """Flags of the program; a number is written so that it reads back to the same bits."""
    words = []
    for name, value in values.items():
        if value is None:
            continue
        entries = value if isinstance(value, list) else [value]
        text = ",".join(entry if isinstance(entry, str) else repr(entry) for entry in entries)
        words.append(f"--{name.replace('_', '-')}={text}")
    return words


def _run(command: str, words: list[str], threads: Optional[int] = None) -> tuple[dict[str, Any], Optional[tuple[str, str]]]:
    count = 0 if threads is None else integer("threads", threads, 0, 4096)
    with Progress(command) as progress:
        text, failure = _gfmd.run([command, *words], count, progress.tick)
    values = parsed(text)
    for name in ("out", "plots", "peak_bytes"):
        values.pop(name, None)
    return values, failure


def _ended(result: Any, failure: Optional[tuple[str, str]]) -> Any:
    if failure is None:
        return result
    raise (Interrupted if failure[0] == "interrupted" else NotConverged)(failure[1], result)


def _body_flags(body: Body) -> list[str]:
    young, poisson, e_star, height = body._given
    elastic = _flags(young=young) if e_star is None else _flags(e_star=e_star)
    return [*elastic, *_flags(poisson=poisson, height="inf" if height is None else height)]


def _written(surface: Surface, folder: str) -> list[str]:
    """The flags of a surface, whose heights go through a file bit by bit."""
    file = os.path.join(folder, "heights.npy")
    np.save(file, surface.heights if surface.n[1] > 1 else surface.heights[:, 0])
    return [f"--surface={file}", *_flags(length=list(surface.size) if surface.n[1] > 1 else [surface.size[0], 1.0])]


def path(
    surface: Any,
    body: Body,
    *,
    mean_pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    lateral: Any = None,
    direction: float = 0.0,
    law: Any = None,
    friction: Optional[float] = None,
    shear_strength: Optional[float] = None,
    steps: int = 20,
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    energy_tolerance: Optional[float] = None,
    energy_solves: Optional[int] = None,
    threads: Optional[int] = None,
) -> Path:
    """Follows a contact along a path of loads, approaches and lateral displacements, each step from the last.

    Args:
        mean_pressure, p_star, approach: the waypoints of one of the three (stress, 1, length); negative ones pull.
        lateral: lateral displacements of the rigid surface, length, in the `direction` (degrees from x).
        law: as of `contact`; or `friction`, a coefficient (Coulomb), or `shear_strength`, stress (Tresca).
        steps: steps from one waypoint to the next.
        energy_tolerance, energy_solves: accuracy of the dissipated energy, see docs/interface.md.

    Raises:
        InputError; NotConverged and Interrupted with the path so far in `.state`.

    Example:
        >>> loop = gfmd.path(s, body, law=gfmd.law("morse", gamma=2e-4, range=1.2e-3), approach=[-0.004, 0.004, -0.007])
        >>> loop.steps.mean_pressure.min()
    """
    made, elastic, given = as_surface(surface), as_body(body), as_law(law)
    drive = {"pressure": mean_pressure, "p_star": p_star, "displacement": approach}
    if sum(value is not None for value in drive.values()) != 1:
        raise InputError("the path must be given by one of mean_pressure, p_star, approach")
    names = {"pressure": "mean_pressure", "p_star": "p_star", "displacement": "approach"}
    words = _flags(**{name: None if value is None else numbers(names[name], value) for name, value in drive.items()})
    words += _flags(
        lateral=None if lateral is None else numbers("lateral", lateral),
        direction=number("direction", direction),
        steps=integer("steps", steps, 1, 2**32 - 1),
        tol=number("tolerance", tolerance),
        max_iter=integer("max_iterations", max_iterations),
        energy_tol=None if energy_tolerance is None else number("energy_tolerance", energy_tolerance),
        energy_solves=None if energy_solves is None else integer("energy_solves", energy_solves),
        friction=None if friction is None else number("friction", friction),
        shear_strength=None if shear_strength is None else number("shear_strength", shear_strength),
    )
    if law is not None:
        words += _flags(law=given.name)
        words += [f"--param={name}={value!r}" for name, value in given.parameters.items()]
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "path.h5")
        values, failure = _run("path", [*_written(made, folder), *_body_flags(elastic), *words, f"--out={file}"], threads)
        rows = [{**step, **{f"residual_{part}": value for part, value in step.pop("residual").items()}} for step in values["steps"]]
        names_of = dict.fromkeys(name for row in rows for name in row)
        columns = {name: np.array([np.nan if row.get(name) is None else row[name] for row in rows]) for name in names_of}
        fields = _fields(file, ("pressure", "gap", "shear_x", "shear_y")) if os.path.exists(file) else {}
    values["surface"] = made
    result = Path({**{name: _records(value) for name, value in values.items()}, "steps": Record(columns), **fields})
    return _ended(result, failure)  # type: ignore[no-any-return]


def friction(
    surface: Any,
    body: Body,
    *,
    coefficient: Optional[float] = None,
    shear_strength: Optional[float] = None,
    mean_pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    lateral: Any = (0.0,),
    **options: Any,
) -> Path:
    """A contact with friction pushed sideways: a `path` behind a hard wall.

    Args:
        coefficient: Coulomb's coefficient; or `shear_strength`, stress (Tresca).
        lateral: lateral displacements of the rigid surface at the waypoints, length; the rest as of `path`.

    Raises:
        InputError; NotConverged and Interrupted with the path so far in `.state`.

    Example:
        >>> f = gfmd.friction(s, body, coefficient=0.3, p_star=0.05, lateral=[0, 0.002])
        >>> f.sliding[0].friction_coefficient
    """
    if (coefficient is None) == (shear_strength is None):
        raise InputError("friction must be given by one of coefficient, shear_strength")
    loads = {"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach}
    return path(surface, body, friction=coefficient, shear_strength=shear_strength, lateral=lateral, **loads, **options)


def _fields(file: str, names: Sequence[str]) -> dict[str, Array]:
    found = {}
    for name in names:
        try:
            found[name] = frozen(_gfmd.read_array(file, f"/fields/{name}"))
        except InputError:
            continue
    return found


def punch(
    body: Optional[Body] = None,
    *,
    length: float = 1.27,
    n: int = 128,
    dim: int = 3,
    punch_fraction: float = 0.25,
    depth: float = 0.005,
    contact: str = "sticking",
    nodes: str = "strict",
    solver: str = "auto",
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    refine: int = 1,
    threads: Optional[int] = None,
) -> Punch:
    """Presses a flat rigid punch on a body: all components of displacement and traction.

    Args:
        body: the body; by default that of `gfmd punch` (E = 70, Poisson's ratio 0.33, height = length).
        length: side of the cell, length. n: points along a side. dim: 3, or 2 for a strip.
        punch_fraction: width of the punch over that of the cell. depth: how deep it is pressed, length.
        contact: "sticking" or "frictionless". nodes: "strict" or "inclusive" of the points on its edge.
        refine: number of grids, each twice as fine, from which the mean pressure is extrapolated.

    Raises:
        InputError; NotConverged and Interrupted with the result so far in `.state`.

    Example:
        >>> gfmd.punch(n=64, nodes="inclusive").mean_pressure
    """
    words = [] if body is None else _body_flags(as_body(body))
    words += _flags(
        length=number("length", length),
        n=integer("n", n),
        dim=integer("dim", dim, 2, 3),
        punch_fraction=number("punch_fraction", punch_fraction),
        depth=number("depth", depth),
        contact=word("contact", contact),
        nodes=word("nodes", nodes),
        solver=word("solver", solver),
        tol=number("tolerance", tolerance),
        max_iter=integer("max_iterations", max_iterations),
        refine=integer("refine", refine, 1, 8),
    )
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "punch.h5")
        values, failure = _run("punch", [*words, f"--out={file}"], threads)
        fields = _fields(file, ("displacement", "traction")) if os.path.exists(file) else {}
    return _ended(Punch({**{name: _records(value) for name, value in values.items()}, **fields}), failure)  # type: ignore[no-any-return]


def interior(
    source: Union[Contact, Punch],
    depths: Optional[Sequence[float]] = None,
    *,
    levels: Optional[int] = None,
    deepest: Optional[float] = None,
    quantities: Sequence[str] = ("displacement", "strain", "stress", "von-mises", "energy-density"),
    along: Optional[str] = None,
    threads: Optional[int] = None,
) -> FieldsBelow:
    """Displacement, strain and stress below the surface of a contact or a punch.

    Args:
        source: a contact (the lateral displacement of a surface without friction is added) or a punch.
        depths: depths below the surface, length; or `levels`, evenly to the base or to the `deepest`.
        quantities: of "displacement", "strain", "stress", "von-mises", "energy-density".
        along: "y=Y" or "x=X", the nearest row of points only.

    Raises:
        InputError: depths outside the body, an unknown quantity.

    Example:
        >>> gfmd.interior(gfmd.punch(n=64), depths=[0.1]).von_mises.max()
    """
    words = _flags(
        depths=None if depths is None else numbers("depths", depths),
        levels=None if levels is None else integer("levels", levels, 1),
        deepest=None if deepest is None else number("deepest", deepest),
        quantities=[word("quantities", name) for name in quantities],
        slice=None if along is None else word("along", along),
    )
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(source, Contact):
            given = os.path.join(folder, "contact.h5")
            source.save(given)
            words += _body_flags(source.body)
        elif isinstance(source, Punch):
            given = os.path.join(folder, "punch.npy")
            shown = source["displacement"]
            np.save(given, shown if shown.ndim == 3 and shown.shape[1] > 1 else shown.reshape(shown.shape[0], shown.shape[-1]))
            height = source["height"]
            words += _flags(length=source["length"][0], young=source["young"], poisson=source["poisson"], height="inf" if height == "inf" else height)
        else:
            raise InputError(f"source is {type(source).__name__}; it must be a Contact or a Punch")
        file = os.path.join(folder, "below.h5")
        values, failure = _run("body", [f"--surface={given}", *words, f"--out={file}"], threads)
        fields = _fields(file, ("displacement", "strain", "stress", "von_mises", "energy_density"))
    values.pop("surface", None)
    return _ended(FieldsBelow({**{name: _records(value) for name, value in values.items()}, **fields}), failure)  # type: ignore[no-any-return]


def green(body: Body, *, qx: float, qy: float = 0.0, dim: int = 3, z: Optional[float] = None, depth: Optional[float] = None, base: str = "bonded") -> Green:
    """The elasticity of one wave vector: `stiffness`, `compliance` (complex matrices), `normal_compliance`.

    Args:
        qx, qy: wave vector, rad/length.
        dim: 3, or 2 for plane strain.
        z: height above the base, or `depth` below the surface, for `displacement_transfer` and `stress_transfer`.
        base: "bonded" or "sliding".

    Raises:
        InputError: a value out of its range.

    Example:
        >>> gfmd.green(gfmd.Body(), qx=3.0, qy=4.0).normal_compliance
        0.4
    """
    young, poisson, e_star, height = as_body(body)._given
    modulus = young if e_star is None else as_body(body).young
    words = _flags(young=modulus, poisson=poisson, height="inf" if height is None else height)
    words += _flags(qx=number("qx", qx), qy=number("qy", qy), dim=integer("dim", dim, 2, 3), base=word("base", base))
    words += _flags(z=None if z is None else number("z", z), depth=None if depth is None else number("depth", depth))
    values, _ = _run("green", words)
    for name in ("stiffness", "compliance", "displacement_transfer", "stress_transfer"):
        if values.get(name) is not None:
            pairs = np.array(values[name], dtype=np.float64)
            values[name] = pairs[..., 0] + 1j * pairs[..., 1]
    return Green({name: _records(value) for name, value in values.items()})


def kappa_sweep(
    config: Union[str, "os.PathLike[str]", Mapping[str, Any]] = "default",
    *,
    out: Union[str, "os.PathLike[str]", None] = None,
    resume: bool = False,
    threads: Optional[int] = None,
) -> KappaSweep:
    """Many contacts, one kappa in the thermodynamic, fractal and continuum limit, with its uncertainty.

    Args:
        config: the name of a preset ("smoke", "default" ...), the path of a TOML file, or a dict of its contents.
        out: the HDF5 file to keep, with figures beside it; nothing is kept by default.
        resume: continue a sweep to `out` that was interrupted.

    Raises:
        InputError: an unusable configuration. NotConverged: a contact of the sweep. Interrupted: finished runs are kept beside `out`.

    Example:
        >>> k = gfmd.kappa_sweep("smoke")
        >>> k.fit.kappa_tfc, k.fit.ci95
    """
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(config, Mapping):
            file = os.path.join(folder, "sweep.toml")
            try:
                File(file).write_text(_gfmd.json_to_toml(json.dumps(dict(config))))
            except TypeError as error:
                raise InputError(f"config has a value that TOML has not: {error}") from error
            words = [f"--config={file}"]
        elif isinstance(config, str) and not config.endswith(".toml"):
            words = [f"--preset={config}"]
        else:
            words = [f"--config={os.fspath(config)}"]
        kept = os.path.join(folder, "kappa.h5") if out is None else os.fspath(out)
        words += [f"--out={kept}", *(["--resume"] if resume else [])]
        values, failure = _run("kappa-sweep", words, threads)
    return _ended(KappaSweep({name: _records(value) for name, value in values.items()}), failure)  # type: ignore[no-any-return]


