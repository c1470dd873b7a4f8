"""Rough surfaces: generated, given as arrays, read from files."""

from __future__ import annotations

import os
from typing import Any, Optional, Union

import numpy.typing as npt

from . import _check, _gfmd
from ._check import Array, frozen, integer, number, numbers, optional, word
from ._errors import InputError
from ._record import Record, parsed, without_null

Size = Union[float, tuple[float, float], None]


class Statistics(Record):
    """The numbers of a surface by the names of `gfmd surface --json`; lengths in the unit of the heights."""


class Surface:
    """Heights of the rigid surface in a periodic cell. A surface does not change: methods return new ones.

    The heights are [x, y], with the peaks towards the body: the highest point touches first. A 1-D array is a profile
    (plane strain), kept as [n, 1].

    Args:
        heights: array of shape [nx, ny] or [n] of finite numbers (any real type, order or layout; it is copied once), or a
            SurfaceTopography object, whose size and unit are taken over.
        size: lengths of the cell, L or (Lx, Ly), in the unit of the heights; 1 by default. One length is that along x, and
            the points are as far apart along y.
        unit: the unit of heights and lengths, such as "m"; only told, never converted.

    Raises:
        InputError: another shape or type, NaN, masked points, a size that is not positive.

    Example:
        >>> gfmd.Surface([[0, 1], [1, 0]], size=(1e-4, 1e-4), unit="m")
    """

    __slots__ = ("_description", "_heights", "_statistics", "_size", "_unit")
    _heights: Array
    _size: tuple[float, float]
    _unit: Optional[str]
    _description: str
    _statistics: Optional[Statistics]

    def __init__(self, heights: npt.ArrayLike | Any, size: Size = None, *, unit: Optional[str] = None) -> None:
        description = "array"
        if callable(getattr(heights, "heights", None)) and hasattr(heights, "physical_sizes"):
            topography: Any = heights
            lengths, points = topography.physical_sizes, topography.nb_grid_pts
            heights = topography.heights()
            if size is None and lengths is not None and len(lengths) == len(points):
                size = tuple(float(length) for length in lengths) if len(lengths) > 1 else float(lengths[0])  # type: ignore[assignment]
            unit = getattr(topography, "unit", None) if unit is None else unit
            description = "SurfaceTopography"
        copy = _check.heights(heights)
        shape = (int(copy.shape[0]), int(copy.shape[1]))
        self._set(copy, _check.size(size, shape), None if unit is None else word("unit", unit), description)

    def _set(self, heights: Array, size: tuple[float, float], unit: Optional[str], description: str) -> None:
        for name, value in (("heights", frozen(heights)), ("size", size), ("unit", unit), ("description", description), ("statistics", None)):
            object.__setattr__(self, "_" + name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a Surface cannot be changed; its methods return new ones")

    def __reduce__(self) -> tuple[Any, ...]:
        return _surface, (self._heights, self._size, self._unit, self._description)

    @property
    def heights(self) -> Array:
        """Heights [x, y], read-only; a profile is [n, 1]."""
        return self._heights

    @property
    def n(self) -> tuple[int, int]:
        """Numbers of points along x and y."""
        return int(self._heights.shape[0]), int(self._heights.shape[1])

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the cell along x and y, n times the spacing. The second of a profile means nothing."""
        return self._size

    @property
    def unit(self) -> Optional[str]:
        """The unit of heights and lengths, if it is known."""
        return self._unit

    @property
    def description(self) -> str:
        """The origin of the heights, and how they were prepared."""
        return self._description

    @property
    def rms_gradient(self) -> float:
        """Root mean square of the full gradient, from the spectrum."""
        return float(self.statistics().rms_gradient)

    @property
    def rms_height(self) -> float:
        """Root mean square of the heights about their mean."""
        return float(self.statistics().rms_height)

    def statistics(self, *, fit_range: Optional[tuple[float, float]] = None) -> Statistics:
        """The numbers of the surface: rms height, gradient and curvature, Nayak's parameter, Hurst exponent, cut-offs.

        Args:
            fit_range: (longest, shortest) wavelength of the fit of the Hurst exponent; from half of the cell to 4 spacings
                by default.

        Raises:
            InputError: a range without enough waves.

        Example:
            >>> gfmd.self_affine(n=64, rms_gradient=0.3).statistics().rms_gradient
            0.3
        """
        if fit_range is None and self._statistics is not None:
            return self._statistics
        given = None if fit_range is None else numbers("fit_range", fit_range)
        if given is not None and len(given) != 2:
            raise InputError(f"fit_range is {fit_range!r}; it must be (longest, shortest)")
        values = parsed(_gfmd.statistics(self._heights, self._size, given))
        for name in ("source", "unit", "asked", "out"):
            del values[name]
        found = Statistics(without_null(values))
        if fit_range is None:
            object.__setattr__(self, "_statistics", found)
        return found

    def detrend(self, trend: str = "plane") -> Surface:
        """A surface without its trend.

        Args:
            trend: "mean", "plane" (least squares), "slope" (the mean slope, which joins opposite edges on average) or
                "quadratic" (least squares).

        Raises:
            InputError: another name; fewer points than the trend has numbers.

        Example:
            >>> flat = gfmd.read("scan.txt").detrend("plane")
        """
        heights = _gfmd.detrend(self._heights, word("trend", trend))
        return _surface(heights, self._size, self._unit, f"{self._description}, {trend} removed")

    def periodise(self, way: str = "mirror") -> Surface:
        """One period of a surface that is not periodic: "mirror" joins mirror images (four times the points), "as-is" nothing.

        Raises:
            InputError: another name.

        Example:
            >>> cell = gfmd.read("scan.txt").detrend("plane").periodise()
        """
        heights, size = _gfmd.periodise(self._heights, self._size, word("way", way))
        return _surface(heights, size, self._unit, f"{self._description}, {way}")

    def flip(self) -> Surface:
        """A surface turned over: valleys become peaks. For scans whose peaks point away from the body.

        Example:
            >>> turned = surface.flip()
        """
        return _surface(-self._heights, self._size, self._unit, f"{self._description}, turned over")

    def plot(self, ax: Any = None) -> Any:
        """A map of the heights, or the profile, with matplotlib. Returns the axes.

        Args:
            ax: the axes to draw into; new ones by default.

        Example:
            >>> gfmd.self_affine(n=64).plot()
        """
        from . import _show

        return _show.field(self._heights, self, "height", ax)

    def __repr__(self) -> str:
        nx, ny = self.n
        points, cell = (f"{nx} points", f"{self._size[0]:g}") if ny == 1 else (f"{nx} x {ny} points", f"{self._size[0]:g} x {self._size[1]:g}")
        return f"Surface of {points} on {cell} {self._unit or 'length units'} ({self._description})"

    def _repr_html_(self) -> str:
        from . import _show

        return _show.map_html(self._heights, repr(self))


def _surface(heights: Array, size: tuple[float, float], unit: Optional[str], description: str) -> Surface:
    made = object.__new__(Surface)
    made._set(heights, (float(size[0]), float(size[1])), unit, description)
    return made


def as_surface(value: Any) -> Surface:
    return value if isinstance(value, Surface) else Surface(value)


def self_affine(
    n: Union[int, tuple[int, int], None] = None,
    hurst: float = 0.8,
    *,
    rms_gradient: Optional[float] = None,
    rms_height: Optional[float] = None,
    seed: int = 1,
    size: Size = None,
    unit: Optional[str] = None,
    eps_t_inv: Optional[float] = None,
    eps_f_inv: Optional[float] = None,
    eps_c_inv: Optional[float] = None,
    dim: int = 3,
    method: str = "psd",
    roll_off: Optional[float] = None,
    roll_off_shape: str = "plateau",
    amplitudes: str = "gaussian",
) -> Surface:
    """A periodic self-affine surface from its spectrum and a seed; the surface of `gfmd surface` with the same numbers.

    Args:
        n: points along a side, or (nx, ny); 256 by default, or as `eps_c_inv` says.
        hurst: Hurst exponent, 0 to 1.
        rms_gradient: root mean square of the full gradient, 0.1 by default; or `rms_height`, length.
        seed: name of the realisation: one seed gives one surface on any grid.
        size: lengths of the cell, L or (Lx, Ly); 1 by default.
        eps_t_inv: cell over longest wavelength, at least 1; 2 by default.
        eps_f_inv: longest over shortest wavelength; by default 4 points are left for the shortest.
        eps_c_inv: points per shortest wavelength, at least 2, in place of `n`.
        dim: 3 for a surface, 2 for a profile.
        method: "psd", or "sra", "rmd" (subdivision, not periodic).
        roll_off: wavelength beyond which the spectrum is flat, length; its `roll_off_shape` is "plateau" or "smooth".
        amplitudes: "gaussian", or "fixed" (random phases only).

    Raises:
        InputError: a value out of its range, values that do not go together.

    Example:
        >>> gfmd.self_affine(n=256, hurst=0.8, rms_gradient=0.1, seed=1)
    """
    if rms_gradient is not None and rms_height is not None:
        raise InputError("rms_gradient and rms_height are both given; give one of the two")
    if n is None:
        points = []
    elif isinstance(n, (tuple, list)):
        points = [integer("n", value, 0, 2**62) for value in n]
    else:
        points = [integer("n", n, 0, 2**62)]
    heights, lengths, description = _gfmd.self_affine(
        n=points,
        length=[] if size is None else numbers("size", size),
        hurst=number("hurst", hurst),
        eps_t_inv=optional("eps_t_inv", eps_t_inv),
        eps_f_inv=optional("eps_f_inv", eps_f_inv),
        eps_c_inv=optional("eps_c_inv", eps_c_inv),
        rms_gradient=0.1 if rms_gradient is None else number("rms_gradient", rms_gradient),
        rms_height=optional("rms_height", rms_height),
        seed=integer("seed", seed, 0, 2**64 - 1),
        dim=integer("dim", dim, 2, 3),
        method=word("method", method),
        roll_off=optional("roll_off", roll_off),
        roll_off_shape=word("roll_off_shape", roll_off_shape),
        amplitudes=word("amplitudes", amplitudes),
    )
    return _surface(heights, lengths, None if unit is None else word("unit", unit), description)


def read(name: Union[str, "os.PathLike[str]"], *, size: Size = None, unit: Optional[str] = None) -> Surface:
    """A surface from a file: every format that `gfmd surface --surface` reads.

    Args:
        name: a .npy file, "FILE.h5:/dataset", or a text matrix with or without an instrument's header.
        size: lengths of the cell; those of the file by default, or 1.
        unit: unit of heights and lengths; that of the file by default.

    Raises:
        InputError: a file that cannot be read or has points without a height.

    Example:
        >>> scan = gfmd.read("scan.txt").detrend("plane")
    """
    try:
        path = word("name", os.fspath(name))
    except TypeError as error:
        raise InputError(f"name is {name!r}; it must be the path of a file") from error
    heights, lengths, told, description = _gfmd.read(path)
    given = lengths if size is None else size
    shape = (int(heights.shape[0]), int(heights.shape[1]))
    return _surface(heights, _check.size(given, shape), told if unit is None else word("unit", unit), description)
