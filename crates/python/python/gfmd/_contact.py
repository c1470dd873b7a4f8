"""Contacts of a rigid rough surface with an elastic body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Optional, Union, overload

import numpy as np

from . import _gfmd
from ._body import Body, Law, as_body, as_law
from ._check import Array, frozen, integer, number, numbers, word
from ._errors import InputError, Interrupted, NotConverged
from ._progress import Progress
from ._record import Record, Residual, parsed, without_null
from ._surface import Surface, as_surface

CONTROLS = ("mean_pressure", "p_star", "approach")


class Contact(Record):
    """A contact at rest under one load. It cannot be changed, and it pickles.

    A number that does not exist is NaN. Lengths and stresses are in the units of the surface and the body.

    Attributes:
        surface, body, law: those given.
        mean_pressure: mean pressure over the whole surface, stress; with a law, attraction included.
        p_star: mean pressure over E* times the rms gradient.
        displacement, approach: rigid approach beyond first touch, length.
        area_fraction: points in contact (with a law: repelled) over all points.
        area_fraction_corrected: the same less the excess of the pixels along the perimeter.
        kappa, kappa_corrected: area_fraction, area_fraction_corrected over p_star.
        contact_nodes, boundary_links: points in contact; neighbouring pairs of which one is in contact.
        mean_gap: mean distance between the surfaces, length.
        max_pressure: largest pressure, stress.
        mean_pressure_in_contact, pressure_deviation_in_contact: mean and standard deviation over the points in contact, stress.
        pressure_moment_2: mean square pressure over the whole surface, stress^2.
        elastic_energy: elastic energy per area, stress * length.
        iterations, transform_pairs: effort of the solve.
        converged: True if no residual exceeds the tolerance.
        residual: a `Residual`, recomputed from the final fields; `float(c.residual)` is the largest part.
        seconds: wall time of the solve.
        interface_energy: energy of the law per area, stress * length; as the rest, with a law only.
        passed_instability: True if the surfaces jumped on the way from `start`.
        lowest_curvature: over the elastic one, positive in a stable state; NaN after dynamics.
        residual_equilibrium: largest unbalanced force per area over the scale of stress.

    Example:
        >>> c = gfmd.contact(s, gfmd.Body(), p_star=0.05)
        >>> c.pressure.shape, c.converged
        ((64, 64), True)
    """

    surface: Surface
    body: Body
    law: Law
    mean_pressure: float
    p_star: float
    displacement: float
    area_fraction: float
    area_fraction_corrected: float
    kappa: float
    kappa_corrected: float
    contact_nodes: int
    boundary_links: int
    mean_gap: float
    max_pressure: float
    mean_pressure_in_contact: float
    pressure_deviation_in_contact: float
    pressure_moment_2: float
    elastic_energy: float
    iterations: int
    transform_pairs: float
    converged: bool
    residual: Residual
    seconds: float
    interface_energy: float
    passed_instability: bool
    lowest_curvature: float
    residual_equilibrium: float
    _pressure: Array
    _displacement_z: Array
    _gap: Array
    _settings: tuple[str, float]
    _problem: Any
    _state: Any

    def __init__(
        self,
        values: dict[str, Any],
        parts: tuple[Surface, Body, Law],
        fields: tuple[Array, Array, Array],
        settings: tuple[str, float] = ("auto", 1e-8),
        native: tuple[Any, Any] = (None, None),
    ) -> None:
        super().__init__(values)
        names = ("surface", "body", "law", "_pressure", "_displacement_z", "_gap", "_settings", "_problem", "_state")
        for name, value in zip(names, (*parts, *(frozen(field) for field in fields), settings, *native)):
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        fields = (self._pressure, self._displacement_z, self._gap)
        return Contact, (self._values, (self.surface, self.body, self.law), fields, self._settings)

    @property
    def pressure(self) -> Array:
        """Pressure on the elastic surface [x, y], stress, compression positive; attraction is negative. Read-only."""
        return self._pressure

    @property
    def displacement_z(self) -> Array:
        """Normal displacement of the elastic surface [x, y], length, negative downwards. Read-only."""
        return self._displacement_z

    @property
    def gap(self) -> Array:
        """Distance between the surfaces [x, y], length. Read-only."""
        return self._gap

    @property
    def approach(self) -> float:
        """Rigid approach beyond first touch, length: the key `displacement`."""
        return float(self["displacement"])

    @property
    def touching(self) -> "np.typing.NDArray[np.bool_]":
        """The points with positive pressure [x, y]."""
        return np.asarray(self._pressure > 0.0)

    def interior(self, depths: Sequence[float], **options: Any) -> Any:
        """Displacement, strain and stress below the surface; see `gfmd.interior`.

        Example:
            >>> c.interior(depths=[0.01, 0.02]).von_mises.max()
        """
        from ._commands import interior

        return interior(self, depths, **options)

    def save(self, path: Any) -> None:
        """Writes the file that `gfmd contact --out` writes; `gfmd.load` reads it.

        Raises:
            InputError, Error: a file that cannot be written. An older file under that name stays.

        Example:
            >>> c.save("c.h5")
        """
        from ._files import save

        save(path, [self])

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the fields, with coordinates x and y, and the scalars as attributes.

        Example:
            >>> c.to_xarray().pressure.sel(x=0.5, method="nearest")
        """
        from . import _show

        return _show.dataset([self]).isel(load=0)

    def plot(self, field: str = "pressure", ax: Any = None) -> Any:
        """A map (a curve of a line contact) of "pressure", "gap" or "displacement_z" with matplotlib. Returns the axes.

        Example:
            >>> c.plot("gap")
        """
        from . import _show

        if field not in ("pressure", "gap", "displacement_z"):
            raise InputError(f"field is {field!r}; it must be one of 'pressure', 'gap', 'displacement_z'")
        return _show.field(getattr(self, field), self.surface, field, ax)

    def _repr_html_(self) -> str:
        from . import _show

        return _show.map_html(self._pressure, "pressure") + super()._repr_html_()


class Contacts(Sequence[Contact]):
    """Contacts one after the other. Scalars are arrays over the loads: `cs.area_fraction`."""

    __slots__ = ("_contacts",)
    _contacts: tuple[Contact, ...]

    def __init__(self, contacts: Sequence[Contact]) -> None:
        object.__setattr__(self, "_contacts", tuple(contacts))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("Contacts cannot be changed")

    def __reduce__(self) -> tuple[Any, ...]:
        return Contacts, (self._contacts,)

    @overload
    def __getitem__(self, index: int) -> Contact: ...
    @overload
    def __getitem__(self, index: slice) -> Contacts: ...
    def __getitem__(self, index: Union[int, slice]) -> Union[Contact, Contacts]:
        if isinstance(index, slice):
            return Contacts(self._contacts[index])
        return self._contacts[index]

    def __len__(self) -> int:
        return len(self._contacts)

    def __getattr__(self, name: str) -> Array:
        if not name.startswith("_") and self._contacts and name in self._contacts[0]:
            if name == "residual":
                return np.array([float(contact.residual) for contact in self._contacts])
            return np.array([contact[name] for contact in self._contacts])
        raise AttributeError(f"Contacts has no {name}")

    def save(self, path: Any) -> None:
        """Writes the file that `gfmd contact --out` writes with these loads.

        Example:
            >>> cs.save("loads.h5")
        """
        from ._files import save

        save(path, self._contacts)

    def to_xarray(self) -> Any:
        """An xarray.Dataset: fields [load, x, y], scalars [load].

        Example:
            >>> cs.to_xarray().area_fraction
        """
        from . import _show

        return _show.dataset(self._contacts)

    def plot(self, ax: Any = None) -> Any:
        """Contact area against reduced pressure, with matplotlib. Returns the axes.

        Example:
            >>> cs.plot()
        """
        from . import _show

        return _show.area(self._contacts, ax)

    def __repr__(self) -> str:
        rows = "".join(
            f"\n{contact['p_star']:>11.4e} {contact['displacement']:>11.4e} {contact['area_fraction']:>9.6f} {contact['kappa']:>7.4f} {contact['mean_gap']:>11.4e} {contact['iterations']:>7}"
            for contact in self._contacts
        )
        return f"{len(self)} contacts\n{'p_star':>11} {'approach':>11} {'area':>9} {'kappa':>7} {'mean gap':>11} {'steps':>7}{rows}"


class _Setup:
    """A surface against a body, checked, with the numbers of the solve."""

    def __init__(self, surface: Any, body: Any, law: Any, solver: Any, tolerance: Any, max_iterations: Any, threads: Any, start: Any) -> None:
        self.surface, self.body, self.law = as_surface(surface), as_body(body), as_law(law)
        self.solver, self.tolerance = word("solver", solver), number("tolerance", tolerance)
        if self.solver not in _gfmd.solvers():
            raise InputError(f"solver is {solver!r}; it must be one of {', '.join(_gfmd.solvers())}")
        if not 1e-15 <= self.tolerance <= 0.1:
            raise InputError(f"tolerance is {self.tolerance}; it must be between 1e-15 and 0.1")
        self.max_iterations = integer("max_iterations", max_iterations)
        self.threads = 0 if threads is None else integer("threads", threads, 0, 4096)
        if start is not None and not isinstance(start, Contact):
            raise InputError(f"start is {type(start).__name__}; it must be a contact")
        mine = (self.surface, self.body, self.law, self.solver)
        if start is not None and (start.surface, start.body, start.law, start._settings[0]) == mine and start._problem:
            self.problem = start._problem
        else:
            heights, size, given = self.surface.heights, self.surface.size, self.body._given
            self.problem = _gfmd.Problem(heights, size, given, self.law._native, self.solver, self.threads)
        self.start = None if start is None else self._state(start)

    def _state(self, start: Contact) -> Any:
        if start.surface.n != self.surface.n:
            raise InputError(f"start has {list(start.surface.n)} points; the surface has {list(self.surface.n)}")
        if (start.law["name"] == "hard-wall") != (self.law["name"] == "hard-wall"):
            raise InputError(f"start has the law {start.law['name']}; a hard wall and a law do not start from each other")
        if start._state is not None:
            return start._state
        return self.problem.recall(start.pressure, start.displacement_z, start.gap, start.approach)

    def check(self, control: str, value: float) -> None:
        pulls = self.law["name"] != "hard-wall"
        if not math.isfinite(value) or not (pulls or value > 0.0):
            raise InputError(f"{control} is {value}; it must be {'finite' if pulls else 'positive and finite'}")

    def solve(self, control: str, value: float, start: Any, progress: Progress) -> Contact:
        state, record, pressure, displacement, gap, failure, raised = self.problem.solve(
            control, value, self.tolerance, self.max_iterations, start, self.threads, progress.tick
        )
        values = parsed(record)
        values["residual"] = Residual(without_null(values["residual"]))
        parts = (self.surface, self.body, self.law)
        contact = Contact(without_null(values), parts, (pressure, displacement, gap), (self.solver, self.tolerance), (self.problem, state))
        if isinstance(raised, KeyboardInterrupt):
            raise Interrupted(f"interrupted after {contact['iterations']} iterations", contact) from raised
        if raised is not None:
            raise raised
        if failure is not None:
            raise NotConverged(failure[1], contact)
        progress.piece()
        return contact


def _control(given: dict[str, Any]) -> tuple[str, Any]:
    found = [(name, value) for name, value in given.items() if value is not None]
    if len(found) != 1:
        names = ", ".join(name for name, _ in found) or "none"
        raise InputError(f"the load is given by {names}; it must be given by one of mean_pressure, p_star, approach")
    return found[0]


def contact(
    surface: Any,
    body: Body,
    *,
    mean_pressure: Optional[float] = None,
    p_star: Optional[float] = None,
    approach: Optional[float] = None,
    law: Union[Law, str, None] = None,
    solver: str = "auto",
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    threads: Optional[int] = None,
    start: Optional[Contact] = None,
) -> Contact:
    """Presses a rigid surface on an elastic body: the contact at rest under one load.

    Args:
        surface: a Surface, an array [nx, ny] or [n] (cell length 1), or a SurfaceTopography object.
        body: the elastic body.
        mean_pressure: mean pressure over the whole surface, stress; never a force. Or
        p_star: mean pressure over E* times the rms gradient. Or
        approach: rigid approach beyond first touch, length.
        law: what acts across the gap (`gfmd.law`); a hard wall by default.
        solver: a name of docs/solvers.md.
        tolerance: the largest residual, 1e-15 to 0.1.
        max_iterations: iterations after which the search is given up.
        threads: number of threads; all cores by default. Results do not depend on it.
        start: a contact to start from, such as that of a smaller load.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged: the tolerance was not reached, or the surfaces part; `.state` is the contact as far as it came.
        Interrupted: Ctrl-C; `.state` as above.

    Example:
        >>> c = gfmd.contact(gfmd.self_affine(n=256), gfmd.Body(), p_star=0.05)
        >>> c.area_fraction, c.pressure.max()
    """
    control, given = _control({"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach})
    value = number(control, given)
    setup = _Setup(surface, body, law, solver, tolerance, max_iterations, threads, start)
    setup.check(control, value)
    with Progress("contact") as progress:
        return setup.solve(control, value, setup.start, progress)


def contacts(
    surface: Any,
    body: Body,
    *,
    mean_pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    law: Union[Law, str, None] = None,
    solver: str = "auto",
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    threads: Optional[int] = None,
    start: Optional[Contact] = None,
) -> Contacts:
    """Contacts under several loads, one after the other, each started from the last.

    Args:
        mean_pressure, p_star, approach: the loads, one of the three, a sequence; the other arguments as of `contact`.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Contacts so far, of which the last has not converged.

    Example:
        >>> gfmd.contacts(gfmd.self_affine(n=256), gfmd.Body(), p_star=[0.01, 0.05, 0.2]).area_fraction
    """
    control, given = _control({"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach})
    values = numbers(control, given)
    setup = _Setup(surface, body, law, solver, tolerance, max_iterations, threads, start)
    for value in values:
        setup.check(control, value)
    done: list[Contact] = []
    state = setup.start
    with Progress("contacts", len(values)) as progress:
        for index, value in enumerate(values):
            try:
                done.append(setup.solve(control, value, state, progress))
            except (NotConverged, Interrupted) as error:
                kept = [*done, error.state] if error.state is not None else done
                raise type(error)(f"load {index}: {error}", Contacts(kept)) from error
            state = done[-1]._state
    return Contacts(done)


__all__ = ["Contact", "Contacts", "contact", "contacts"]
