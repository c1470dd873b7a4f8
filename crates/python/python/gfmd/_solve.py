"""Contacts of a rigid rough surface with an elastic body, brought to rest under given loads."""

from __future__ import annotations

import math
from typing import Any, Optional
from weakref import WeakKeyDictionary

import numpy.typing as npt

from . import _gfmd
from ._body import Body, Law, as_body, as_law
from ._check import flag, integer, number, numbers, word
from ._command import body_keys
from ._contact import LATERAL, LOWER, REPULSION, Contact, Contacts, Settings
from ._errors import InputError, Interrupted, NotConverged, warned
from ._progress import Progress
from ._record import of_load
from ._surface import Surface, as_hardness, as_lower, as_surface


# The surroundings of a surface.
BOUNDARIES = ("periodic", "free")

# The components of the surface displacement that are unknown.
COMPONENTS = ("normal", "all", "held")

# The problem of a surface that is in use, and what it was made for.
_LAST: WeakKeyDictionary[Surface, tuple[tuple[Any, ...], Any]] = WeakKeyDictionary()

# The loads by the names that they have in a file.
_FLAGS = {"mean_pressure": "pressure", "p_star": "p_star", "approach": "displacement"}

_RANGED = ("exponential", "morse", "dugdale")


class _Setup:
    """A surface against a body, checked, with the numbers of the solve."""

    def __init__(
        self, surface: Any, body: Any, *, boundary: Any, law: Any, hardness: Any, components: Any, finite_slope: Any, lower_surface: Any, coarse: Any,
        range_continuation: Any, solver: Any, tolerance: Any, max_iterations: Any, threads: Any, start: Any
    ) -> None:  # fmt: skip
        self.surface, self.body, self.law = as_surface(surface), as_body(body), as_law(law)
        self.solver, self.tolerance = word("solver", solver), number("tolerance", tolerance)
        self.boundary = word("boundary", boundary)
        self.hardness = as_hardness(hardness, self.surface)
        self.components = word("components", components)
        if self.components not in COMPONENTS:
            raise InputError(f"components is {components!r}; it must be one of {', '.join(map(repr, COMPONENTS))}")
        if self.boundary not in BOUNDARIES:
            raise InputError(f"boundary is {boundary!r}; it must be one of {', '.join(map(repr, BOUNDARIES))}")
        if self.solver not in _gfmd.solvers():
            raise InputError(f"solver is {solver!r}; it must be one of {', '.join(_gfmd.solvers())}")
        if not 1e-15 <= self.tolerance <= 0.1:
            raise InputError(f"tolerance is {self.tolerance}; it must be between 1e-15 and 0.1")
        self.finite_slope, self.coarse = flag("finite_slope", finite_slope), flag("coarse", coarse)
        self.lower_surface = as_lower(lower_surface, self.surface)
        self.range_continuation = flag("range_continuation", range_continuation)
        if self.range_continuation and self.law.name not in _RANGED:
            raise InputError(f"range_continuation: the law {self.law.name} has no range; it must be one of {', '.join(_RANGED)}")
        if self.range_continuation and start is not None:
            raise InputError("range_continuation and start are both given; give one of the two")
        self.max_iterations = integer("max_iterations", max_iterations)
        self.threads = 0 if threads is None else integer("threads", threads, 0, 4096)
        if start is not None and not isinstance(start, Contact):
            raise InputError(f"start is {type(start).__name__}; it must be a contact")
        self.problem = self._problem()
        self.start = None if start is None else self._state(start)

    def _problem(self) -> Any:
        """The spectrum of the surface and the tables of the body: those of the last contact of this surface if it was the same."""
        bound = self.hardness if self.hardness is None or isinstance(self.hardness, float) else self.hardness.tobytes()
        lower = None if self.lower_surface is None else self.lower_surface.heights.tobytes()
        asked = (self.body, self.law, self.boundary, self.solver, bound, self.components, self.finite_slope, lower, self.coarse)
        last = _LAST.get(self.surface)
        if last is None or last[0] != asked:
            last = asked, self._posed(self.law, self.coarse)
            _LAST[self.surface] = last
        return last[1]

    def _posed(self, law: Law, coarse: Optional[bool]) -> Any:
        """A problem; whether its grid is too coarse is not asked if `coarse` is None."""
        heights, size, given = self.surface.heights, self.surface.size, body_keys(self.body)
        lower = None if self.lower_surface is None else self.lower_surface.heights
        how = (self.hardness, lower, self.finite_slope, coarse, self.boundary, self.components, self.solver, self.threads)
        return _gfmd.Problem(heights, size, given, law._native, *how)

    def _state(self, start: Contact) -> Any:
        if start.surface.n != self.surface.n:
            raise InputError(f"start has {list(start.surface.n)} points; the surface has {list(self.surface.n)}")
        if start.boundary != self.boundary:
            raise InputError(f"start has the boundary {start.boundary}; it must be {self.boundary} as of the contact")
        if (start.law["name"] == "hard-wall") != (self.law["name"] == "hard-wall"):
            raise InputError(f"start has the law {start.law['name']}; a hard wall and a law do not start from each other")
        if start.components != self.components:
            raise InputError(f"start has the components {start.components}; they must be {self.components} as of the contact")
        if start.finite_slope != self.finite_slope:
            raise InputError(f"start has finite_slope={start.finite_slope}; it must be {self.finite_slope} as of the contact")
        if (start.lower_surface is None) != (self.lower_surface is None):
            raise InputError(f"start has {'no' if start.lower_surface is None else 'a'} lower_surface; it must be as of the contact")
        if start._state is not None:
            return start._state
        return self.problem.recall(start.pressure, start.displacement_z, start.gap, start.approach, start.lower_pressure)

    def first(self, control: str, value: float, progress: Progress) -> Any:
        """The state to start from: the one given, or that of longer and longer ranges of the law."""
        state = self.start
        for factor in _gfmd.RANGES if self.range_continuation else ():
            parameters = {**self.law.parameters, "range": factor * self.law.parameters["range"]}
            longer = self._posed(Law(self.law.name, parameters), None)
            try:
                state = self.solved(longer, control, value, state, progress)._state
            except (NotConverged, Interrupted) as error:
                raise type(error)(f"range times {factor:g}: {error}", error.state) from error
        return state

    def check(self, control: str, value: float) -> None:
        pulls = self.law["name"] != "hard-wall"
        if not math.isfinite(value) or not (pulls or value > 0.0):
            raise InputError(f"{control} is {value}; it must be {'finite' if pulls else 'positive and finite'}")

    def solve(self, control: str, value: float, start: Any, progress: Progress) -> Contact:
        contact = self.solved(self.problem, control, value, start, progress)
        progress.piece()
        return contact

    def tell(self, done: list[Contact]) -> None:
        """Warns of slopes that are not small."""
        told = self.problem.slopes(max((contact.max_pressure for contact in done), default=0.0))
        if told is not None:
            warned(told)

    def solved(self, problem: Any, control: str, value: float, start: Any, progress: Progress) -> Contact:
        state, record, failure, raised = problem.solve(control, value, self.tolerance, self.max_iterations, start, self.threads, progress.tick)
        values = of_load(record)
        parts = (self.surface, self.body, self.law)
        pressure, displacement, gap = state.fields
        load = (_FLAGS[control], value)
        settings = Settings(self.solver, self.tolerance, self.boundary, self.hardness, self.components, self.finite_slope, self.lower_surface, load)
        others = dict(zip(LATERAL, state.lateral)) if state.plastic_depth is None else {"plastic_depth": state.plastic_depth}
        others.update(zip(LOWER, state.lower or ()))
        if state.repulsion is not None:
            others[REPULSION] = state.repulsion
        contact = Contact(values, parts, (pressure, displacement, gap), settings, state, others)
        if isinstance(raised, KeyboardInterrupt):
            raise Interrupted(f"interrupted after {contact['iterations']} iterations", contact) from raised
        if raised is not None:
            raise raised
        if failure is not None:
            raise NotConverged(failure[1], contact)
        return contact


def _control(given: dict[str, Any]) -> tuple[str, Any]:
    found = [(name, value) for name, value in given.items() if value is not None]
    if len(found) != 1:
        names = ", ".join(name for name, _ in found) or "none"
        raise InputError(f"the load is given by {names}; it must be given by one of mean_pressure, p_star, approach")
    return found[0]


def contact(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    mean_pressure: Optional[float] = None,
    p_star: Optional[float] = None,
    approach: Optional[float] = None,
    boundary: str = "periodic",
    law: Law | str | None = None,
    hardness: float | npt.ArrayLike | None = None,
    components: str = "normal",
    finite_slope: bool = False,
    lower_surface: Surface | npt.ArrayLike | None = None,
    coarse: bool = False,
    range_continuation: bool = False,
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
        mean_pressure: mean pressure over the whole surface, stress (with free boundaries the force over the area); or
        p_star: mean pressure over E* times the rms gradient; or
        approach: rigid approach beyond first touch, length.
        boundary: "periodic", or "free": the surface is a patch on an unbounded half-space, slab or stack of layers; its rms
            gradient is that of differences, and the approach that against points far away.
        law: what acts across the gap (`gfmd.law`); a hard wall by default.
        hardness: largest pressure, stress, of a hard wall, a number or an array of the shape of the heights; where it is
            reached the surfaces are pressed into each other.
        components: the components of the surface displacement that are unknown, of a hard wall: "normal" (u_z; u_x and u_y follow
            from the pressure), "all" (all are moved by damped dynamics, under a mean pressure; the same u_z at a higher cost),
            or "held" (u_z, with u_x and u_y held at zero).
        finite_slope: points of the body meet the height at their displaced place, and pressures act along the normal of the
            surface (a hard wall with periodic boundaries, one body, no hardness).
        lower_surface: heights [nx, ny] of a second rigid surface below a slab, in place of its base, peaks towards the slab: a
            Surface with the points, cell and unit of the upper one, or an array. It may be flat.
        coarse: solve a law whose process zone is narrower than a tenth of a grid step, too: single points jump.
        range_continuation: start from the states of 8, 4 and 2 times the range of the law with the same work, one after the
            other. Their iterations are not counted.
        solver: a name of docs/solvers.md.
        tolerance: largest residual, 1e-15 to 0.1.
        max_iterations: iterations after which the search is given up.
        threads: number of threads; all cores by default. Results do not depend on it.
        start: a contact of the same surface to start from, such as that of a smaller load, an interrupted one, or one from
            a file.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged: the tolerance was not reached, or the surfaces part; `.state` is the contact as far as it came.
        Interrupted: Ctrl-C; `.state` as above.

    Example:
        >>> c = gfmd.contact(gfmd.self_affine(n=64), gfmd.Body(young=70e9, poisson=0.33), p_star=0.05)
        >>> round(c.area_fraction, 3), c.pressure.shape
        (0.128, (64, 64))
    """
    control, given = _control({"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach})
    value = number(control, given)
    setup = _Setup(
        surface, body, boundary=boundary, law=law, hardness=hardness, components=components, finite_slope=finite_slope, lower_surface=lower_surface,
        coarse=coarse, range_continuation=range_continuation, solver=solver, tolerance=tolerance, max_iterations=max_iterations, threads=threads,
        start=start,
    )  # fmt: skip
    setup.check(control, value)
    with Progress("contact") as progress:
        done = setup.solve(control, value, setup.first(control, value, progress), progress)
    setup.tell([done])
    return done


def contacts(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    mean_pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    boundary: str = "periodic",
    law: Law | str | None = None,
    hardness: float | npt.ArrayLike | None = None,
    components: str = "normal",
    finite_slope: bool = False,
    lower_surface: Surface | npt.ArrayLike | None = None,
    coarse: bool = False,
    range_continuation: bool = False,
    solver: str = "auto",
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    threads: Optional[int] = None,
    start: Optional[Contact] = None,
) -> Contacts:
    """Contacts under several loads, one after the other, each started from the last.

    Args:
        surface, body: as of `contact`.
        mean_pressure, p_star, approach: the loads, one of the three, a sequence (stress, 1, length).
        boundary, law, hardness, components, finite_slope, lower_surface, coarse, solver, tolerance, max_iterations, threads, start: as
            of `contact`.
        range_continuation: as of `contact`, for the first load.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Contacts so far, of which the last has not converged.

    Example:
        >>> cs = gfmd.contacts(gfmd.self_affine(n=64), gfmd.Body(), p_star=[0.01, 0.05, 0.2])
        >>> [c.converged for c in cs], cs.kappa.shape
        ([True, True, True], (3,))
    """
    control, given = _control({"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach})
    values = numbers(control, given)
    setup = _Setup(
        surface, body, boundary=boundary, law=law, hardness=hardness, components=components, finite_slope=finite_slope, lower_surface=lower_surface,
        coarse=coarse, range_continuation=range_continuation, solver=solver, tolerance=tolerance, max_iterations=max_iterations, threads=threads,
        start=start,
    )  # fmt: skip
    for value in values:
        setup.check(control, value)
    done: list[Contact] = []
    state = None
    with Progress("contacts", len(values)) as progress:
        for index, value in enumerate(values):
            try:
                state = setup.first(control, value, progress) if index == 0 else state
                done.append(setup.solve(control, value, state, progress))
            except (NotConverged, Interrupted) as error:
                kept = [*done, error.state] if error.state is not None else done
                raise type(error)(f"load {index}: {error}", Contacts(kept)) from error
            except KeyboardInterrupt as error:  # between two solves
                raise Interrupted(f"load {index}: interrupted", Contacts(done)) from error
            state = done[-1]._state
    setup.tell(done)
    return Contacts(done)
