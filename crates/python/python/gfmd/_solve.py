"""Contacts of a rigid rough surface with an elastic body, brought to rest under given loads."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Optional, overload
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from . import _gfmd
from ._body import Body, Law, as_body, as_law, body_of, law_of
from ._check import Array, Quantity, integer, is_sequence, number, quantities
from ._command import body_keys, law_keys
from ._contact import Contact, Contacts, Settings
from ._errors import InputError, Interrupted, NotConverged, warned
from ._given import taking
from ._progress import Progress
from ._load import LOADS, of_load
from ._options import ContactOptions
from ._record import parsed
from ._surface import Surface, as_hardness, as_lower, as_surface

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Last problem of each surface in use, with its inputs.
_LAST: WeakKeyDictionary[Surface, tuple[tuple[Any, ...], Any]] = WeakKeyDictionary()


class _Setup:
    """Checked description of a contact problem, and the native problem."""

    def __init__(
        self,
        surface: Any,
        body: Any,
        *,
        loads: Any = (),
        law: Any = None,
        hardness: Any = None,
        lower_surface: Any = None,
        threads: Any = None,
        start: Any = None,
        **options: Any,
    ) -> None:
        self.surface, self.body, self.law = as_surface(surface), as_body(body), as_law(law)
        self.lower_surface = as_lower(lower_surface, self.surface)
        self.threads = 0 if threads is None else integer("threads", threads, 0, 4096)
        problem: dict[str, Any] = {
            "unit": self.surface.unit,
            "size": list(self.surface.size),
            **body_keys(self.body),
            **law_keys(self.law),
        }
        arrays: dict[str, Array] = {} if self.lower_surface is None else {"lower_surface": self.lower_surface.heights}
        for name, value in {"hardness": as_hardness(hardness, self.surface), **options}.items():
            (arrays if isinstance(value, np.ndarray) else problem)[name] = value
        if loads and problem.get("stress_unit") is None and self.surface.unit != "m":
            problem["stress_unit"] = "Pa"
        if start is not None and not isinstance(start, Contact):
            raise InputError(f"start is {type(start).__name__}; it must be a contact")
        if start is not None and problem.get("range_continuation"):
            raise InputError("range_continuation and start are both given; give one of the two")
        self.problem = self._posed(problem, arrays)
        self.settings = Settings(parsed(self.problem.description), arrays, self.lower_surface)
        # In the units of the problem, as in a file.
        self.body = body_of(self.settings.description)
        if texts(self.law.parameters.values()) or texts(self.law.table):
            self.law = law_of(self.settings.description)
        self.start = None if start is None else self._state(start)

    def _posed(self, problem: dict[str, Any], arrays: dict[str, Array]) -> Any:
        """Returns the native problem, reused from the last contact of the surface if its inputs are the same."""
        asked = (problem, {name: values.tobytes() for name, values in arrays.items()})
        last = _LAST.get(self.surface)
        if last is None or last[0] != asked:
            last = asked, _gfmd.Problem(problem, {**arrays, "surface": self.surface.heights}, self.threads)
            _LAST[self.surface] = last
        return last[1]

    def _state(self, start: Contact) -> Any:
        if start.surface.n != self.surface.n:
            raise InputError(f"start has {list(start.surface.n)} points; the surface has {list(self.surface.n)}")
        if (start.law["name"] == "hard-wall") != (self.law["name"] == "hard-wall"):
            raise InputError(
                f"start has the law {start.law['name']}; a hard wall and a law do not start from each other"
            )
        for name, default in (("boundary", None), ("components", "normal"), ("finite_slope", False)):
            found, allowed = (settings.description.get(name, default) for settings in (start._settings, self.settings))
            if found != allowed:
                raise InputError(f"start has {name}={found!r}; it must be {allowed!r} as of the contact")
        if (start.lower_surface is None) != (self.lower_surface is None):
            raise InputError(
                f"start has {'no' if start.lower_surface is None else 'a'} lower_surface; it must be as of the contact"
            )
        return self.problem.recall(start._fields, start.approach) if start._state is None else start._state

    def values(self, control: str, given: list[Quantity]) -> list[float]:
        """Converts the loads to the units of the problem and checks their signs."""
        found = [
            self.problem.value(control, value, LOADS[control]) if isinstance(value, str) else value for value in given
        ]
        for value, written in zip(found, given):
            self.check(control, value, written)
        return found

    def check(self, control: str, value: float, written: Quantity) -> None:
        """Checks the sign of a load; the message shows it as it was written."""
        pulls = self.law["name"] != "hard-wall"
        if not math.isfinite(value) or not (pulls or value > 0.0):
            raise InputError(f"{control} is {written}; it must be {'finite' if pulls else 'positive and finite'}")

    def tell(self, done: list[Contact], control: str, values: list[float]) -> None:
        """Warns about large slopes and strains, and about units that seem inconsistent."""
        slopes = self.problem.slopes(max((contact.max_pressure for contact in done), default=0.0))
        strain = self.problem.strain(max((contact.approach for contact in done), default=0.0))
        for warning in [*self.problem.unit_warnings(control, max(values)), slopes, strain]:
            if warning is not None:
                warned(warning)

    def solve(self, control: str, value: float, start: Any, progress: Progress) -> Contact:
        """Solves the contact under one load, from a state or from the start set by the options."""
        state, record, failure, raised = self.problem.solve(control, value, start, self.threads, progress.tick)
        parts = (self.surface, self.body, self.law)
        settings = self.settings._replace(load=(control, value))
        contact = Contact(of_load(record), parts, dict(state.fields), settings, state)
        if isinstance(raised, KeyboardInterrupt):
            raise Interrupted(f"interrupted after {contact['iterations']} iterations", contact) from raised
        if raised is not None:
            raise raised
        if failure is not None:
            raise NotConverged(failure[1], contact)
        progress.piece()
        return contact


def texts(value: Any) -> bool:
    """Returns True if any argument has a unit."""
    if isinstance(value, str):
        return True
    return is_sequence(value) and any(texts(entry) for entry in value)


def _control(loads: dict[str, Any]) -> tuple[str, Any]:
    """Returns the name and value of the load. Refuses more than one."""
    found = [(name, value) for name, value in loads.items() if value is not None]
    if len(found) != 1:
        names = ", ".join(name for name, _ in found) or "none"
        raise InputError(f"the load is given by {names}; it must be given by one of pressure, p_star, force, approach")
    return found[0]


@overload
def contact(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Optional[Quantity] = None,
    p_star: Optional[float] = None,
    force: Optional[Quantity] = None,
    approach: Optional[Quantity] = None,
    **options: Unpack[ContactOptions],
) -> Contact: ...
@overload
def contact(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Optional[Sequence[Quantity] | npt.NDArray[np.float64]] = None,
    p_star: Optional[Sequence[float] | npt.NDArray[np.float64]] = None,
    force: Optional[Sequence[Quantity] | npt.NDArray[np.float64]] = None,
    approach: Optional[Sequence[Quantity] | npt.NDArray[np.float64]] = None,
    **options: Unpack[ContactOptions],
) -> Contacts: ...
@taking(ContactOptions)
def contact(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    **options: Any,
) -> Any:
    """Presses a rigid surface against an elastic body. Returns the contact under one load, or several contacts.

    Args:
        surface: a Surface, an array [nx, ny] or [n] (cell length 1), or a SurfaceTopography object.
        body: the elastic body.
        pressure: mean pressure over the whole surface, stress (with free boundaries, force divided by area), or a
            string with a unit, such as "1MPa", if the surface has one; or
        p_star: mean pressure divided by E* and by the rms gradient; or
        force: force on the whole surface, stress * length^2, or a string with a unit, such as "5N"; not for a profile;
            or
        approach: rigid approach beyond first touch, length, or a string with a unit. A sequence of loads returns
            `Contacts`, as `contacts` does, each started from the last.
        boundary: boundary condition at the edges of the surface: "periodic" (default), or "free" for a patch on an
            unbounded half-space, slab or stack of layers. Its rms gradient is computed from differences, and the
            approach is relative to points far away.
        law: law of adhesion or cohesion across the gap (`gfmd.law`); a hard wall by default.
        hardness: largest pressure of a hard wall, stress, a number or an array of the shape of the heights. Where it is
            reached, the surfaces are pressed into each other.
        components: displacement components to solve for: "normal" (default: u_z), "all" (u_z, and u_x and u_y due to
            the pressure; a dynamic solver moves all three against a periodic hard wall), or "held" (u_z, with u_x and
            u_y held at zero).
        finite_slope: do not assume small slopes: points of the body meet the height at their displaced position, and
            pressures act along the surface normal (a hard wall with periodic boundaries, one body, no hardness).
        lower_surface: heights [nx, ny] of a second rigid surface below a slab, in place of its base, peaks towards the
            slab: a Surface with the points, cell and unit of the upper one, or an array. It may be flat.
        coarse: also solve a law with a process zone narrower than a tenth of a grid step, where single points jump.
        range_continuation: start from the states for 8, 4 and 2 times the range of the law at the same work, in turn.
            Their iterations are not counted.
        grid_error: how to estimate the discretisation error: "estimate" (default, from the solution itself), "refine"
            (from a second solution with twice as many points along each side, at five times the cost), or "none".
        accuracy: target relative discretisation error (95 %) of every number, such as 0.01 or "1%". The surface is
            refined until all numbers meet it; the contact is computed on the refined surface.
        solver: solution method, a name in docs/solvers.md; "auto" by default.
        tolerance: largest allowed residual, 1e-15 to 0.1; 1e-8 by default.
        max_iterations: largest number of iterations; 100000 by default.
        threads: number of threads; all cores by default. Results do not depend on it.
        start: contact of the same surface to start from, such as one at a smaller load, interrupted, or from a file.
        base_displacement: displacement of a bonded or sliding base, length: an array [nx, ny] of u_z, or [nx, ny, 3];
            for a profile n values, or [n, 2].
        base_traction: traction on the lower face of a plate (base="free"), stress, of mean zero, in the same form.
        dt, damping: time step and damping of the damped dynamics, as in `punch`.
        stiffness_tolerance: largest relative error of the stiffness of a hard wall, 5e-6 by default.
        stress_unit: unit of stresses given without one; Pa by default if a stress has a unit.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged: the tolerance was not reached, or the surfaces part; `.state` is the contact so far. If `accuracy`
            needs a grid larger than the memory, `.state` is the contact on the last grid that fitted.
        Interrupted: Ctrl-C; `.state` as above.

    Example:
        >>> c = gfmd.contact(gfmd.self_affine(n=64), gfmd.Body(young=70e9, poisson=0.33), p_star=0.05)
        >>> round(c.area_fraction, 3), c.pressure.shape
        (0.128, (64, 64))
        >>> scan = gfmd.self_affine(n=64, size="50 um", unit="um")
        >>> loads = gfmd.contact(scan, gfmd.Body(young="70 GPa"), pressure=["7 MPa", "0.1 GPa"])
        >>> [round(c.p_star, 4) for c in loads]
        [0.001, 0.0143]
    """
    control, given = _control({"pressure": pressure, "p_star": p_star, "force": force, "approach": approach})
    loads = quantities(control, given)
    if is_sequence(given):
        given = {control: loads}
        return contacts(surface, body, **given, **options)
    accuracy = options.pop("accuracy", None)
    if accuracy is not None:
        return _accurate(accuracy, (surface, body), (control, loads), options)[0]
    setup = _Setup(surface, body, loads=_of_stress(control, loads), **options)
    [value] = setup.values(control, loads)
    with Progress("contact") as progress:
        done = setup.solve(control, value, setup.start, progress)
    setup.tell([done], control, [value])
    return done


def _of_stress(control: str, loads: list[Quantity]) -> list[Quantity]:
    """Returns the loads whose unit contains a stress."""
    return [load for load in loads if isinstance(load, str) and "stress" in LOADS[control]]


def _accurate(
    accuracy: Any, pair: tuple[Any, Any], loads: tuple[str, list[Quantity]], options: dict[str, Any]
) -> list[Contact]:
    """Solves the contacts on a grid on which all numbers meet `accuracy`."""
    (control, values), (surface, body) = loads, (as_surface(pair[0]), pair[1])
    given: dict[str, Any] = {control: values, **options}
    if options.get("start") is not None or options.get("grid_error") not in (None, "estimate"):
        raise InputError(
            "accuracy is given with start or grid_error; the grid of a start, and its error, are what they are"
        )
    asked = accuracy if isinstance(accuracy, str) else repr(number("accuracy", accuracy))
    _Setup(surface, body, loads=_of_stress(control, values), **options).problem.check_accuracy(asked, control)
    done = list(contacts(surface, body, **given))
    while (times := max(found._state.times(asked) for found in done)) > 1:
        try:
            surface = surface.finer(times)
            done = list(contacts(surface, body, **given))
        except InputError as error:
            state = done[0] if len(done) == 1 else Contacts(done)
            raise NotConverged(
                f"accuracy is {accuracy}; it needs {times} times as many points along each side: {error}", state
            ) from error
    return done


@taking(ContactOptions)
def contacts(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    **options: Unpack[ContactOptions],
) -> Contacts:
    """Solves contacts under several loads in turn, each started from the last.

    Args:
        surface, body: as in `contact`.
        pressure, p_star, force, approach: loads by one of the four, a sequence (stress, 1, stress * length^2, length).
        options: further arguments of `contact`; `start` and `range_continuation` apply to the first load.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Contacts so far; the last contact in it has not converged.

    Example:
        >>> cs = gfmd.contacts(gfmd.self_affine(n=64), gfmd.Body(), p_star=[0.01, 0.05, 0.2])
        >>> [c.converged for c in cs], cs.kappa.shape
        ([True, True, True], (3,))
    """
    further: dict[str, Any] = dict(options)
    control, given = _control({"pressure": pressure, "p_star": p_star, "force": force, "approach": approach})
    loads = quantities(control, given)
    accuracy = further.pop("accuracy", None)
    if accuracy is not None:
        return Contacts(_accurate(accuracy, (surface, body), (control, loads), further))
    setup = _Setup(surface, body, loads=_of_stress(control, loads), **further)
    values = setup.values(control, loads)
    done: list[Contact] = []
    state = setup.start
    with Progress("contacts", len(values)) as progress:
        for index, value in enumerate(values):
            try:
                done.append(setup.solve(control, value, state, progress))
            except (NotConverged, Interrupted) as error:
                kept = [*done, error.state] if error.state is not None else done
                raise type(error)(f"load {index}: {error}", Contacts(kept)) from error
            except KeyboardInterrupt as error:  # between two solves
                raise Interrupted(f"load {index}: interrupted", Contacts(done)) from error
            state = done[-1]._state
    setup.tell(done, control, values)
    return Contacts(done)
