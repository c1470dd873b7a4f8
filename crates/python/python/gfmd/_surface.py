"""Rough surfaces: generated, from arrays, or from files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _check, _gfmd, _show
from ._check import Array, frozen, in_units, integer, number, numbers, optional, quantities, quantity, word
from ._columns import SurfaceNumbers
from ._hints import attribute, hinted
from ._errors import Error, InputError
from ._measured import Measured
from ._record import Record, by_name, parsed, without_null
from ._units import Units

Size = Union[float, str, tuple[Union[float, str], Union[float, str]], None]

# Continuation of a surface beyond its edges; None to follow `is_periodic`.
Boundary = Optional[Literal["periodic", "free"]]

# Points excluded from a fit: a mask [x, y], or a region as text.
Exclude = Union[npt.NDArray[np.bool_], str, None]


class Statistics(Measured, SurfaceNumbers):
    """Statistics of a surface. Lengths are in the unit of the heights; an undefined number is NaN.

    ISO 25178 height parameters (Sa, Sp, Sv, Ssk, Sku, Sdr) are relative to the mean height, without filter; Sq is
    `rms_height`, Sz is `peak_to_valley`. Gradients, curvatures and moments come from the spectrum; names ending in
    `_inside` come from differences, excluding the periodic seam.

    Attributes:
        n, size: points and lengths along x and y.
        undefined: reasons why numbers are NaN, by name; present only if there are any.

    Example:
        >>> round(s.statistics().nayak, 1)
        6.4
    """

    n: list[int]
    size: list[float]
    undefined: dict[str, str]
    _main = (
        "n",
        "size",
        "rms_height",
        "rms_gradient",
        "rms_curvature",
        "peak_to_valley",
        "nayak",
        "hurst",
        "longest_wavelength",
        "shortest_wavelength",
        "ssk",
        "sku",
        "seam",
    )


class _Origin(NamedTuple):
    """Origin of heights: description, file metadata, and True if the heights are known to repeat."""

    description: str
    file: dict[str, Any]
    periodic: bool = False

    def after(self, step: str) -> _Origin:
        return self._replace(description=f"{self.description}, {step}")


class Surface:
    """Heights of a rigid surface in a periodic cell. It is immutable: methods return new surfaces.

    The heights are [x, y], with the peaks towards the body: the highest point touches first. A 1-D array is a profile
    (plane strain), kept as [n, 1].

    Args:
        heights: array of shape [nx, ny] or [n] of finite numbers (any real type, order or layout; it is copied once),
            a DataArray of xarray with the dimensions x and y, whose coordinates give the size, or a SurfaceTopography
            object, with its size and unit.
        size: cell size, L or (Lx, Ly), in the unit of the heights; 1 by default. L alone is the length along x, with
            equal spacing along y.
        unit: unit of heights and lengths, such as "um"; `to_unit` converts. With a unit, stresses and lengths may be
            strings with units.
        fill: how to fill undefined points (NaN or masked): "harmonic" (Laplace's equation between the defined points)
            or "nearest"; None refuses them.

    Raises:
        InputError: an invalid shape or type, undefined or infinite points, a size that is not positive.

    Example:
        >>> gfmd.Surface([[0, 1], [1, 0]], size="100 um", unit="m")
        Surface of 2 x 2 points on 100 x 100 µm (array)
        >>> gfmd.contact(gfmd.Surface(np.cos(np.arange(64) * np.pi / 32)), gfmd.Body(), p_star=0.1).gap.shape
        (64, 1)
        >>> gfmd.Surface([[0, 1], [np.nan, 0]], fill="nearest").undefined
        1
    """

    __slots__ = ("__weakref__", "_heights", "_origin", "_size", "_statistics", "_unit")
    _heights: Array
    _size: tuple[float, float]
    _unit: Optional[str]
    _origin: _Origin
    _statistics: Optional[Statistics]

    @hinted
    def __init__(
        self, heights: npt.ArrayLike | Any, size: Size = None, *, unit: Optional[str] = None, fill: Optional[str] = None
    ) -> None:
        description, periodic = "array", False
        if callable(getattr(heights, "heights", None)) and hasattr(heights, "physical_sizes"):
            description, periodic = "SurfaceTopography", getattr(heights, "is_periodic", False) is True
            heights, lengths, found = _taken_over(heights)
            size = lengths if size is None else size
            unit = found if unit is None else unit
        elif hasattr(heights, "dims") and hasattr(heights, "coords"):
            heights, lengths, found = _labelled(heights)
            size = lengths if size is None else size
            unit = found if unit is None else unit
        copy, undefined = _check.heights(heights)
        unit = None if unit is None else _gfmd.canonical(word("unit", unit))
        cell = _check.size(size, (int(copy.shape[0]), int(copy.shape[1])), unit)
        copy = _check.whole("heights", copy, undefined, cell, fill)
        origin = _Origin(_filled(description, undefined, fill), {"undefined": undefined}, periodic)
        self._set(copy, cell, unit, origin)

    def _set(self, heights: Array, size: tuple[float, float], unit: Optional[str], origin: _Origin) -> None:
        for name, value in (
            ("heights", frozen(heights)),
            ("size", size),
            ("unit", unit),
            ("origin", origin),
            ("statistics", None),
        ):
            object.__setattr__(self, "_" + name, value)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            hint = "" if name.startswith("_") else attribute(name, dir(type(self)))
            raise AttributeError(f"Surface has no {name}{hint}")

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a Surface cannot be changed; its methods return new ones")

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Surface) or (self._size, self._unit) != (other._size, other._unit):
            return False
        return np.array_equal(self._heights, other._heights)

    def __hash__(self) -> int:
        # A few heights distinguish most surfaces of one size; collisions are compared point by point.
        some = self._heights.ravel()[:: max(1, self._heights.size // 7)]
        return hash((self.n, self._size, self._unit, *some.tolist()))

    def __reduce__(self) -> tuple[Any, ...]:
        return _surface, (self._heights, self._size, self._unit, self._origin)

    @property
    def heights(self) -> Array:
        """Heights [x, y], length, read-only; a profile is [n, 1]."""
        return self._heights

    @property
    def n(self) -> tuple[int, int]:
        """Numbers of points along x and y."""
        return int(self._heights.shape[0]), int(self._heights.shape[1])

    @property
    def size(self) -> tuple[float, float]:
        """Cell lengths along x and y, n times the spacing, in the unit of the heights.

        The second length is meaningless for a profile.
        """
        return self._size

    @property
    def unit(self) -> Optional[str]:
        """Unit of heights and lengths, if known."""
        return self._unit

    @property
    def is_periodic(self) -> bool:
        """True if the heights are periodic by their origin (a spectrum, a mirror, a periodic Topography)."""
        return self._origin.periodic

    @property
    def description(self) -> str:
        """Description of the origin and preparation of the heights."""
        return self._origin.description

    @property
    def undefined(self) -> int:
        """Number of points without a height, before any were filled."""
        return int(self._origin.file.get("undefined", 0))

    @property
    def format(self) -> Optional[str]:
        """The name of the format of the file; None if the heights do not come from a file."""
        return self._origin.file.get("format")

    @property
    def channel(self) -> Optional[str]:
        """Name of the height channel in the file; None if it has no name."""
        return self._origin.file.get("channel")

    @property
    def channels(self) -> list[str]:
        """Names of all height maps in the file, for `gfmd.read(name, channel)`; numbers for unnamed maps."""
        return list(self._origin.file.get("channels", []))

    @property
    def details(self) -> dict[str, str]:
        """Metadata in the file about instrument and measurement, by name."""
        return dict(self._origin.file.get("details", {}))

    @property
    def rms_gradient(self) -> float:
        """Rms of the full gradient, from the spectrum; without unit."""
        return float(self.statistics().rms_gradient)

    @property
    def rms_height(self) -> float:
        """Rms height about the mean, length."""
        return float(self.statistics().rms_height)

    def statistics(
        self,
        *,
        fit_range: Optional[tuple[float, float]] = None,
        features: bool = False,
        wolf: float = 0.05,
        motif_edges: Literal["all", "leave-out", "periodic", None] = None,
        boundary: Boundary = None,
    ) -> Statistics:
        """Returns the statistics: moments, Hurst exponent, cut-offs, ISO 25178 and ISO 21920 parameters.

        ISO 21920 parameters need a profile after an L filter, whose index is the section length.

        Args:
            fit_range: (longest, shortest) wavelength of the Hurst exponent fit; half of the cell to 4 grid spacings by
                default.
            features: True adds correlation lengths, direction, hills and dales: `sal` to `mean_dale_area`, as in
                `gfmd surface --statistics`.
            wolf: pruning threshold: height of a hill above its saddle, or depth of a dale, divided by the height range;
                lower ones join their neighbour.
            motif_edges: treatment of hills and dales at the edge: "all" count, "leave-out", or "periodic" (continue at
                the opposite edge); by default "periodic" if the boundary is, else "leave-out".
            boundary: "periodic" or "free", for correlation lengths and motifs; by default according to `is_periodic`.

        Raises:
            InputError: a range with too few waves, a fraction outside 0 to 1, an unknown name.

        Example:
            >>> round(gfmd.self_affine(n=64, rms_gradient=0.3).statistics().rms_gradient, 12)
            0.3
            >>> found = s.statistics(features=True)
            >>> found.hills > 1, found.s10z > found.sk
            (True, True)
        """
        usual = fit_range is None and not features
        if usual and self._statistics is not None:
            return self._statistics
        given = None if fit_range is None else numbers("fit_range", fit_range)
        if given is not None and len(given) != 2:
            raise InputError(f"fit_range is {fit_range!r}; it must be (longest, shortest)")
        if motif_edges not in (None, "all", "leave-out", "periodic"):
            raise InputError(f"motif_edges is {_check.shown(motif_edges)}; it must be 'all', 'leave-out' or 'periodic'")
        detail = None
        if features:
            detail = ("periodic" if self._repeats(boundary) else "free", number("wolf", wolf), motif_edges)
        values = parsed(_gfmd.statistics(self._heights, self._size, given, self._section(), detail))
        for name in ("source", "unit", "asked", "out"):
            del values[name]
        reasons = {"undefined": by_name(values.pop("undefined"))} if "undefined" in values else {}
        found = Statistics({**without_null(values), **reasons}, (self._unit, None))
        if usual:
            object.__setattr__(self, "_statistics", found)
        return found

    def _section(self) -> Optional[float]:
        """Returns the section length of a profile, the index of its last L filter."""
        of_filters = [step["l"] for step in self.preparation if step["step"] == "filter" and "l" in step]
        return float(of_filters[-1]) if of_filters else None

    def to_unit(self, unit: str) -> Surface:
        """Converts heights and lengths to another unit.

        Args:
            unit: unit of length, such as "um", "nm", "m".

        Raises:
            InputError: an unknown unit, a surface without a unit.

        Example:
            >>> gfmd.Surface([[0, 1], [1, 0]], size=(3, 3), unit="um").to_unit("nm")
            Surface of 2 x 2 points on 3 x 3 µm (array, in nm)
        """
        if self._unit is None:
            raise InputError("unit: the surface has none; Surface(..., unit=) and gfmd.read(..., unit=) give it one")
        heights, size, name = _gfmd.converted(self._heights, self._size, self._unit, word("unit", unit))
        return _surface(heights, size, name, self._origin.after(f"in {name}"))

    def psd(self, *, window: Literal["none", "hann"] = "none") -> Record:
        """Returns the radially averaged power spectral density of the heights, as in `gfmd surface --out FILE.h5`.

        Args:
            window: "hann" tapers the heights of a surface that is not periodic.

        Returns:
            A `Record` of the arrays `wavenumber` (rad/length, the mean of a ring) and `density` (length^4, or length^3
            for a profile). The integral of `density` over all wave vectors is the mean square height. SurfaceTopography
            has (2 pi)^2 times this density, 2 pi times for a profile.

        Raises:
            InputError: an unknown window.

        Example:
            >>> s.psd().density.shape == s.psd().wavenumber.shape
            True
        """
        if window not in ("none", "hann"):
            raise InputError(f"window is {_check.shown(window)}; it must be 'none' or 'hann'")
        wavenumber, density = _gfmd.psd(self._heights, self._size, window)
        return Record({"wavenumber": frozen(np.array(wavenumber)), "density": frozen(np.array(density))})

    def autocorrelation(self, *, boundary: Boundary = None) -> Record:
        """Returns the autocorrelation of the heights, as in `gfmd surface --statistics`.

        Args:
            boundary: "periodic" averages over all points, "free" over pairs of points inside; by default according to
                `is_periodic`.

        Returns:
            A `Record` of `radial` (mean over rings), `x` and, except for a profile, `y`, each with the arrays
            `distance` (length, up to half of the cell), `difference` (half the mean square height difference, length²,
            which SurfaceTopography calls the autocorrelation) and `autocorrelation` (1 minus the difference
            divided by the mean square height, f_ACF of ISO 25178 for periodic heights); `sal` (length) and `str`, Sal
            and Str of ISO 25178, NaN if undefined; `map`, the autocorrelation [x, y] at distances up to half of the
            cell in both directions, with distance zero in the middle.

        Raises:
            InputError: an unknown boundary.

        Example:
            >>> a = s.autocorrelation()
            >>> float(a.radial.autocorrelation[0]), a.map.shape, a.sal < 0.5
            (1.0, (65, 65), True)
        """
        found, differences = self._texture("autocorrelation", boundary)
        square = float(np.var(self._heights))
        assert differences is not None
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(square > 0.0, 1.0 - differences / square, np.nan)
        return Record({**found, "map": frozen(np.ascontiguousarray(relative))})

    def distributions(self, *, boundary: Boundary = None) -> Record:
        """Returns the distributions of height, slope and curvature, as in `gfmd surface --statistics`.

        Args:
            boundary: "periodic" includes differences across the edges of the cell, "free" only differences inside; by
                default according to `is_periodic`.

        Returns:
            A `Record` of `height` (above the mean, length), `slope_x`, `slope_y` (forward differences) and `curvature`
            (central second differences, averaged over x and y, 1/length), excluding quantities with a single value.
            Each has the arrays `value` (centres of 100 bins, at most 6 standard deviations from the mean), `density`
            (over all values) and `gaussian` (with the same mean and deviation), and the numbers `mean`, `deviation`,
            `outside` (share of values beyond the bins).

        Raises:
            InputError: an unknown boundary.

        Example:
            >>> d = s.distributions().height
            >>> round(float(np.sum(d.density) * (d.value[1] - d.value[0])) + d.outside, 12)
            1.0
        """
        return Record(self._texture("distributions", boundary)[0])

    def scale_dependence(self, *, boundary: Boundary = None) -> Record:
        """Returns rms slope and curvature against measurement distance, as in `gfmd surface --statistics`.

        Args:
            boundary: "periodic" includes differences across the edges of the cell, "free" only differences inside; by
                default according to `is_periodic`.

        Returns:
            A `Record` of `slope_x`, `slope_y`, `curvature_x`, `curvature_y`, each with the arrays `distance` (length
            between the outer points of the difference, as in `scale_dependent_statistical_property` of
            SurfaceTopography; whole grid steps up to half of the side) and `slope`, or `curvature` (1/length).

        Raises:
            InputError: an unknown boundary.

        Example:
            >>> found = s.scale_dependence()
            >>> bool(found.slope_x.slope[0] > found.slope_x.slope[-1])
            True
        """
        return Record(self._texture("scale_dependence", boundary)[0])

    def bearing_curve(self) -> Record:
        """Returns the Abbott-Firestone bearing curve and its parameters, as in `gfmd surface --statistics`.

        Returns:
            A `Record` of the arrays `ratio` (material ratio, the share of points at or above a height) and `height`
            (above the mean, length), and the numbers `sk`, `spk`, `svk` (length), `smr1`, `smr2`, Sk to Smr2 of ISO
            25178; NaN for a flat surface.

        Example:
            >>> b = s.bearing_curve()
            >>> bool(b.height[0] == s.heights.max() - s.heights.mean()), 0 < b.smr1 < b.smr2 < 1
            (True, True)
        """
        return Record(self._texture("bearing_curve", None)[0])

    def report(self, path: Union[str, "os.PathLike[str]"], *, boundary: Boundary = None) -> None:
        """Writes the HTML page of `gfmd surface --report`, with all numbers and figures of the surface.

        Args:
            path: name of the page.
            boundary: "periodic" or "free", as in `autocorrelation`.

        Raises:
            InputError: a page that cannot be written, an unknown boundary.

        Example:
            >>> s.report("surface.html")
        """
        words = (self._unit, self.description)
        way = "periodic" if self._repeats(boundary) else "free"
        _gfmd.surface_report(self._heights, self._size, words, way, _check.path("path", path))

    def _keeps(self, name: str, path: str) -> None:
        """Refuses to overwrite the source file of the heights."""
        source = self._origin.file.get("path")
        if source is not None and os.path.exists(path) and os.path.exists(source) and os.path.samefile(path, source):
            raise InputError(f"{name} is {_check.shown(path)}; it must be another file than the input of the surface")

    def _repeats(self, boundary: Boundary) -> bool:
        if boundary not in (None, "periodic", "free"):
            raise InputError(f"boundary is {_check.shown(boundary)}; it must be 'periodic' or 'free'")
        return self.is_periodic if boundary is None else boundary == "periodic"

    def _texture(self, part: str, boundary: Boundary) -> tuple[dict[str, Any], Optional[Array]]:
        """Computes a named function of the heights, with arrays and NaN in place of lists and null."""
        text, field = _gfmd.texture(self._heights, self._size, part, self._repeats(boundary))

        def reported(value: Any) -> Any:
            if isinstance(value, dict):
                return Record({name: reported(entry) for name, entry in value.items()})
            if isinstance(value, list):
                return frozen(np.array(value, dtype=np.float64))
            return np.nan if value is None else value

        return {name: reported(value) for name, value in parsed(text)[part].items()}, field

    def detrend(self, trend: str = "plane", *, exclude: Exclude = None) -> Surface:
        """Subtracts a trend. Undefined points are excluded from the fit and stay undefined.

        Args:
            trend: "mean", "plane" (least squares), "slope" (the mean slope, so that opposite edges match on average),
                "quadratic", "cubic" or "polynomial:D" (least squares, degree D in x and y together, up to 8).
            exclude: points excluded from the fit: a mask [x, y], or "X0:X1,Y0:Y1" in lengths from the corner.

        Raises:
            InputError: an unknown name; points that do not determine the trend.

        Example:
            >>> tilted = gfmd.Surface(s.heights + 0.1 * np.arange(64)[:, np.newaxis])
            >>> tilted.detrend("plane").rms_height < tilted.rms_height
            True
        """
        known = word("trend", trend) in ("mean", "plane", "slope", "quadratic")
        if trend == "mean" or (known and exclude is None and self.is_complete):
            heights = _gfmd.detrend(self._heights, trend)
            return _surface(heights, self._size, self._unit, self._origin.after(f"{trend} removed"))
        return self._step("detrend", trend, exclude=exclude)

    @property
    def is_complete(self) -> bool:
        """True if every point has a height, as a contact needs; a flag without unit."""
        return not np.isnan(self._heights).any()

    def _step(self, option: str, text: str, *, exclude: Exclude = None, repeats: bool = True) -> Surface:
        """Applies one preparation step; `repeats` is False if a periodic surface no longer repeats."""
        excluded = None if exclude is None else self._mask("exclude", exclude)
        given = (self._unit, option, text, self.is_periodic)
        heights, size, words, record = _gfmd.prepared(self._heights, self._size, given, excluded)
        file = {**self._origin.file}
        file["preparation"] = [*file.get("preparation", []), *parsed(record)["preparation"]]
        holes = int(np.isnan(heights).sum())
        file["undefined"] = max(holes, int(file.get("undefined", 0)))
        origin = _Origin(f"{self._origin.description}, {words}", file, self.is_periodic and repeats)
        return _surface(heights, size, self._unit, origin)

    def _mask(self, name: str, value: Any) -> npt.NDArray[np.bool_]:
        if isinstance(value, str):
            held = _gfmd.prepared(self._heights, self._size, (self._unit, "invalid", word(name, value), False))[0]
            return np.isnan(held) & ~np.isnan(self._heights)
        mask = np.asarray(value)
        if mask.dtype.kind != "b" or mask.shape not in (self._heights.shape, self._heights[:, 0].shape):
            raise InputError(
                f"{name} is an array of {mask.dtype} with shape {mask.shape}; it must be a mask of bool with shape"
                f" {self._heights.shape}"
            )
        return np.ascontiguousarray(mask.reshape(self._heights.shape))

    @property
    def preparation(self) -> list[dict[str, Any]]:
        """Preparation steps in order, each with its numbers and the rms gradient before and after.

        Lengths are in the unit of the heights; gradients have no unit.

        Example:
            >>> [step["step"] for step in s.despike().filter(s=4 / 64).preparation]
            ['despike', 'filter']
        """
        return [dict(step) for step in self._origin.file.get("preparation", [])]

    def crop(
        self,
        x: tuple[Union[float, str, None], Union[float, str, None]] = (None, None),
        y: tuple[Union[float, str, None], Union[float, str, None]] = (None, None),
    ) -> Surface:
        """Crops the surface to a box.

        Args:
            x, y: start and end along each axis, lengths from the corner; points with start <= position < end stay.
                None is an end of the surface.

        Raises:
            InputError: a range outside the surface, empty or reversed; fewer than 2 points along a side.

        Example:
            >>> s.crop(x=(0, 0.5)).n
            (32, 64)
        """
        ends = [["" if end is None else str(end) for end in pair] for pair in (x, y)]
        return self._step("crop", ",".join(":".join(pair) for pair in ends), repeats=False)

    def mask(self, points: Any) -> Surface:
        """Marks points as undefined; fill them or crop them away before a contact.

        Args:
            points: a mask [x, y], "X0:X1,Y0:Y1" in lengths from the corner, "below:Z" or "above:Z".

        Raises:
            InputError: a mask of another shape or type; no point, or all of them.

        Example:
            >>> s.mask(s.heights > 0.9 * s.heights.max()).fill("harmonic").is_complete
            True
        """
        if isinstance(points, str):
            return self._step("invalid", word("points", points))
        masked = self._mask("points", points)
        heights = np.where(masked, np.nan, self._heights)
        if np.isnan(heights).all():
            raise InputError("points is every point; some must stay")
        file = {**self._origin.file}
        step = {"step": "invalid", "points": int(masked.sum()), "regions": ["array"]}
        file["preparation"] = [*file.get("preparation", []), step]
        file["undefined"] = max(int(np.isnan(heights).sum()), int(file.get("undefined", 0)))
        origin = _Origin(f"{self._origin.description}, {int(masked.sum())} points masked", file, self.is_periodic)
        return _surface(heights, self._size, self._unit, origin)

    def fill(self, how: Literal["harmonic", "nearest"] = "harmonic") -> Surface:
        """Fills the undefined points.

        Args:
            how: how to fill them, "harmonic" (Laplace's equation between the defined points) or "nearest".

        Raises:
            InputError: an unknown name; no defined point.

        Example:
            >>> s.mask("0:0.1,0:0.1").fill("nearest").is_complete
            True
        """
        count = int(np.isnan(self._heights).sum())
        heights = _check.whole("heights", self._heights, count, self._size, how)
        file = {**self._origin.file, "undefined": max(count, self.undefined)}
        if count:
            step = {"step": "fill", "how": how, "undefined_before": count, "undefined_after": 0}
            file["preparation"] = [*file.get("preparation", []), step]
        origin = _Origin(_filled(self._origin.description, count, how), file, self.is_periodic)
        return _surface(heights, self._size, self._unit, origin)

    def despike(self, threshold: float = 5.0, *, window: int = 5) -> Surface:
        """Marks spikes as undefined: points far from the median of their surroundings.

        Args:
            threshold: least distance of a spike from the local median, in robust standard deviations.
            window: points along each side of the median window, odd.

        Raises:
            InputError: numbers out of range; spikes at more than a tenth of the points.

        Example:
            >>> s.despike().undefined
            0
        """
        return self._step("despike", f"{number('threshold', threshold)!r},{integer('window', window)}")

    def descar(self, high: float = 0.666, low: float = 0.25, *, length: int = 16, width: int = 4) -> Surface:
        """Marks scars, line defects along x, as undefined.

        Args:
            high, low: least distance of a scar from adjacent rows, somewhere and everywhere, in rms row differences.
            length: smallest number of points along x.
            width: largest number of rows.

        Raises:
            InputError: numbers out of range; a profile.

        Example:
            >>> s.descar().n
            (64, 64)
        """
        numbers = f"{number('high', high)!r},{number('low', low)!r}"
        return self._step("descar", f"{numbers},{integer('length', length)},{integer('width', width)}")

    def level(
        self, lines: Literal["rows", "columns"] = "rows", how: str = "median", *, exclude: Exclude = None
    ) -> Surface:
        """Levels the rows (lines along x) or columns.

        Args:
            lines: "rows" or "columns".
            how: "mean", "median", "difference" (median difference of neighbours) or "polynomial:D" (degree D per line).
            exclude: points excluded from the fits, as in `detrend`.

        Raises:
            InputError: an unknown name; a profile.

        Example:
            >>> s.level("rows", "mean").rms_height < s.rms_height
            True
        """
        kept = how in ("mean", "median")
        return self._step("level", f"{word('lines', lines)}:{word('how', how)}", exclude=exclude, repeats=kept)

    def filter(
        self,
        s: Union[float, str, None] = None,
        l: Union[float, str, None] = None,  # noqa: E741
        *,
        kind: Literal["gaussian", "robust", "spline"] = "gaussian",
        edges: Optional[Literal["periodic", "reflect", "regression"]] = None,
        degree: Optional[int] = None,
    ) -> Surface:
        """Applies an S filter, an L filter, or both, with these nesting indices.

        A wave as long as the index keeps half its amplitude. The S filter removes shorter waves and so lowers the
        gradient: p* at the same pressure rises. The L filter removes longer ones.

        Args:
            s, l: nesting indices, lengths.
            kind: "gaussian" (ISO 16610-21, -61), "robust" (-31, -71) or "spline" (-22, profiles).
            edges: "periodic" (default if the surface repeats), "reflect", or "regression".
            degree: regression degree, 0 to 2; 1 by default, 2 if robust.

        Raises:
            InputError: an index below two spacings or above the side; undefined points without regression.

        Example:
            >>> smooth = s.filter(s=8 / 64)
            >>> smooth.rms_gradient < s.rms_gradient
            True
        """
        parts = [f"{name}:{index}" for name, index in (("s", s), ("l", l)) if index is not None]
        parts.append(f"kind={word('kind', kind)}")
        parts += [] if edges is None else [f"edges={word('edges', edges)}"]
        parts += [] if degree is None else [f"degree={integer('degree', degree)}"]
        return self._step("filter", ",".join(parts))

    def resample(
        self, n: Union[int, tuple[int, int], None] = None, *, spacing: Union[float, str, None] = None
    ) -> Surface:
        """Resamples to a coarser grid, after an S filter of four new spacings.

        Args:
            n: points along x, or along x and y.
            spacing: grid spacing, length, in place of `n`.

        Raises:
            InputError: more points than before; neither or both arguments.

        Example:
            >>> s.resample(32).n
            (32, 32)
        """
        if (n is None) == (spacing is None):
            raise InputError("n and spacing: one of them must be given")
        if spacing is not None:
            return self._step("resample_spacing", str(spacing), repeats=False)
        counts = [n] if isinstance(n, (int, np.integer)) else list(n)  # type: ignore[arg-type]
        return self._step("resample", ",".join(str(integer("n", count, 1)) for count in counts), repeats=False)

    def periodise(self, way: str = "mirror") -> Surface:
        """Makes one period of a surface that is not periodic.

        Args:
            way: "mirror" joins mirror images (four times the points, twice for a profile); "as-is" changes nothing.

        Raises:
            InputError: an unknown name.

        Example:
            >>> s.periodise().n
            (128, 128)
        """
        heights, size = _gfmd.periodise(self._heights, self._size, word("way", way))
        return _surface(
            heights, size, self._unit, self._origin.after(way)._replace(periodic=way == "mirror" or self.is_periodic)
        )

    def finer(self, times: int = 2) -> Surface:
        """Refines the grid of the same cell by Fourier interpolation.

        Args:
            times: refinement factor per side, 1 to 64.

        Raises:
            InputError: a number out of range; more points than fit in memory.

        Example:
            >>> f = s.finer(2)
            >>> f.n, f.size == s.size, np.allclose(f.heights[::2, ::2], s.heights)
            ((128, 128), True, True)
        """
        heights = _gfmd.finer(self._heights, self._size, integer("times", times, 1, 64))
        return _surface(
            heights, self._size, self._unit, self._origin.after(f"{times} times as many points along each side")
        )

    def flip(self) -> Surface:
        """Inverts the heights: valleys become peaks. For scans whose peaks point away from the body.

        Example:
            >>> np.array_equal(s.flip().heights, -s.heights)
            True
        """
        return _surface(-self._heights, self._size, self._unit, self._origin.after("turned over"))

    def against(
        self,
        other: Surface | npt.ArrayLike | Any,
        *,
        shift: Union[float, tuple[float, float]] = 0.0,
        boundary: str = "periodic",
    ) -> Surface:
        """Returns the composite of two facing rough surfaces: its contact with a smooth body has their gaps.

        Both heights are given at the same positions in one plane, each with its peaks towards the other surface.
        Turning a sample over mirrors a scan taken from above: `heights[::-1]`.

        Args:
            other: second surface, with the same points and size; an array takes the size of this surface.
            shift: displacement of the second surface, X or (X, Y), length. Fractions of a grid step use Fourier
                interpolation.
            boundary: "periodic", or "free" for surfaces that do not repeat: the shift is a multiple of the grid step,
                and only the overlap is kept.

        Raises:
            InputError: a different number of points, size or unit; a shift that the boundary does not allow.

        Example:
            >>> other = gfmd.self_affine(n=64, seed=2)
            >>> pairs = [s.against(other, shift=(x, 0)) for x in (0.0, 0.25, 0.5)]
            >>> [gfmd.contact(pair, gfmd.Body(), p_star=0.05).converged for pair in pairs]
            [True, True, True]
        """
        second = other if isinstance(other, Surface) else Surface(other, self._size)
        for name, found, allowed in (("n", second.n, self.n), ("size", second.size, self._size)):
            if not np.allclose(
                found[: 1 if self.n[1] == 1 else 2], allowed[: 1 if self.n[1] == 1 else 2], rtol=1e-6, atol=0
            ):
                raise InputError(f"{name} of the second surface is {found}; it must be {allowed}")
        if second.unit and self._unit and second.unit != self._unit:
            raise InputError(f"unit of the second surface is {second.unit!r}; it must be {self._unit!r}")
        moved = numbers("shift", shift)
        if len(moved) > 2:
            raise InputError(f"shift is {shift!r}; it must be X or (X, Y)")
        by = (moved[0], moved[1] if len(moved) == 2 else 0.0)
        heights, size = _gfmd.composite(self._heights, second.heights, self._size, by, word("boundary", boundary))
        periodic = boundary == "periodic" and self.is_periodic and second.is_periodic
        origin = self._origin.after(f"against {second.description} moved by {by}")._replace(periodic=periodic)
        return _surface(heights, size, self._unit or second.unit, origin)

    def plot(self, ax: Any = None) -> Any:
        """Draws a map of the heights, or the profile, with matplotlib. Returns the axes.

        Args:
            ax: axes to draw into; new ones by default.

        Raises:
            Error: matplotlib is not installed.

        Example:
            >>> ax = s.plot()
        """
        return _show.field(self._heights, self, "height", ax)

    @property
    def units(self) -> Units:
        """Length unit, None if unknown, and stress unit, which a surface does not have."""
        return self._unit, None

    def to_dataframe(self) -> Any:
        """Returns the `statistics` as a pandas.DataFrame with one row; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> gfmd.self_affine(n=64).to_dataframe().rms_gradient.shape  # doctest: +SKIP
            (1,)
        """
        return self.statistics().to_dataframe()

    def to_xarray(self) -> Any:
        """Returns the heights [y, x] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> gfmd.self_affine(n=64).to_xarray().height.dims
            ('y', 'x')
        """
        height = (("y", "x"), self._heights.T, {"long_name": "height", **({"units": self._unit} if self._unit else {})})
        return _show.needed("xarray", "to_xarray").Dataset({"height": height}, _show.coordinates(self))

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Refused: a surface has a file with its contacts alone.

        Args:
            path: file name.

        Raises:
            Error: always.

        Example:
            >>> np.save("heights.npy", gfmd.self_affine(n=64).heights)  # keeps the heights
        """
        raise Error("Surface has no file; save a contact with it, pickle it, or numpy.save(path, s.heights)")

    def to_pyvista(self) -> Any:
        """Returns a pyvista.ImageData with the heights [x, y] as point data; `.warp_by_scalar()` makes a relief.

        Raises:
            Error: pyvista is not installed.

        Example:
            >>> s.to_pyvista().dimensions  # doctest: +SKIP
            (64, 64, 1)
        """
        return _show.grid(self, {"height": self._heights})

    def __repr__(self) -> str:
        nx, ny = self.n
        factor, unit = _gfmd.readable("length", max(self._size[: 1 if ny == 1 else 2]), self._unit) or (
            1.0,
            self._unit or "length units",
        )
        lx, ly = (f"{float(f'{length * factor:.6g}'):g}" for length in self._size)
        points, cell = (f"{nx} points", lx) if ny == 1 else (f"{nx} x {ny} points", f"{lx} x {ly}")
        holes = int(np.isnan(self._heights).sum())
        some = f", {holes} undefined" if holes else ""
        return f"Surface of {points}{some} on {cell} {unit} ({self.description})"

    def _repr_html_(self) -> str:
        return _show.map_html(self._heights, repr(self))


def _surface(heights: Array, size: tuple[float, float], unit: Optional[str], origin: _Origin | str) -> Surface:
    made = object.__new__(Surface)
    made._set(
        heights, (float(size[0]), float(size[1])), unit, _Origin(origin, {}) if isinstance(origin, str) else origin
    )
    return made


def _filled(description: str, undefined: int, fill: Optional[str]) -> str:
    return f"{description}, {undefined} points filled ({fill})" if undefined else description


def _taken_over(topography: Any) -> tuple[Any, Size, Optional[str]]:
    """Returns heights, size and unit of a SurfaceTopography object."""
    for name, wanted in (("is_uniform", True), ("is_domain_decomposed", False)):
        if getattr(topography, name, wanted) is not wanted:
            words = "not at equal distances" if wanted else "spread over several processes"
            raise InputError(
                f"heights is a {type(topography).__name__} whose points are {words}; they must be a whole regular grid"
            )
    lengths = topography.physical_sizes
    size = None if lengths is None else tuple(float(length) for length in lengths)
    return topography.heights(), size, getattr(topography, "unit", None)  # type: ignore[return-value]


def _labelled(heights: Any) -> tuple[Any, Size, Optional[str]]:
    """Returns heights [x, y], size and unit of a DataArray of xarray with the dimensions x and y, in any order."""
    dims = tuple(heights.dims)
    if sorted(map(str, dims)) not in (["x"], ["x", "y"]):
        raise InputError(
            f"heights has the dimensions {_check.shown(dims)}; they must be x and y (.values is an array alone)"
        )
    ordered = [dim for dim in ("x", "y") if dim in dims]
    unit, lengths = heights.attrs.get("units"), []
    for dim in ordered:
        if dim not in heights.coords:
            continue
        places = heights.coords[dim]
        steps = np.diff(_check.array(dim, places.values))
        step = float(np.mean(steps)) if len(steps) else 0.0
        if not (step > 0 and np.allclose(steps, step, rtol=1e-6, atol=0.0)):
            raise InputError(f"the coordinates {dim} of heights are uneven or fall; they must rise by equal steps")
        if places.attrs.get("units", unit) != unit:
            raise InputError(
                f"heights has the unit {unit}, and its coordinates {dim} {places.attrs['units']}; they must have one"
            )
        lengths.append(step * (len(steps) + 1))
    size = None if len(lengths) < len(ordered) else tuple(lengths) if len(lengths) == 2 else lengths[0]
    return heights.transpose(*ordered).values, size, unit  # type: ignore[return-value]


def as_surface(value: Any) -> Surface:
    return value if isinstance(value, Surface) else Surface(value)


def as_lower(value: Any, surface: Surface) -> Optional[Surface]:
    """Checks the surface below the slab, on the points of the upper one. An array takes the upper cell."""
    if value is None:
        return None
    lower = (
        value if isinstance(value, Surface) or hasattr(value, "physical_sizes") else Surface(value, size=surface.size)
    )
    lower = as_surface(lower)
    for name, found, wanted in (
        ("n", lower.n, surface.n),
        ("size", lower.size, surface.size),
        ("unit", lower.unit, surface.unit),
    ):
        if found != wanted and not (name == "unit" and None in (found, wanted)):
            raise InputError(f"{name} of lower_surface is {found}; it must be {wanted}, as for the upper surface")
    return lower


def as_hardness(value: Any, surface: Surface) -> Union[float, str, Array, None]:
    """Checks a hardness, a number or an array [x, y]."""
    if value is None or np.ndim(value) == 0:
        return None if value is None else quantity("hardness", value)
    field = _check.array("hardness", value)
    if field.ndim == 1 and surface.n[1] == 1:
        field = field[:, np.newaxis]
    if field.shape != surface.n:
        raise InputError(
            f"hardness has the shape {field.shape}; it must be a number or have the shape {surface.n} of the heights"
        )
    return frozen(np.ascontiguousarray(field))


@hinted
def self_affine(
    n: Union[int, tuple[int, int], None] = None,
    hurst: Optional[float] = None,
    *,
    shape: Optional[str] = None,
    rms_gradient: Optional[float] = None,
    rms_height: Optional[_check.Quantity] = None,
    seed: int = 1,
    size: Size = None,
    unit: Optional[str] = None,
    eps_t_inv: Optional[float] = None,
    eps_f_inv: Optional[float] = None,
    eps_c_inv: Optional[float] = None,
    dim: int = 3,
    method: str = "psd",
    roll_off: Optional[_check.Quantity] = None,
    roll_off_shape: str = "plateau",
    amplitudes: str = "gaussian",
    aspect: Optional[float] = None,
    lay: Optional[float] = None,
    marginal: Union[str, npt.ArrayLike, None] = None,
) -> Surface:
    """Generates a periodic self-affine surface from its spectrum and a seed, as `gfmd surface` does.

    Args:
        n: number of points along a side, or (nx, ny); 256 by default, or set by `eps_c_inv`.
        hurst: Hurst exponent, 0 to 1; 0.8 by default.
        shape: shape below the roughness, "KIND:KEY=VALUE,..." as in `gfmd surface --shape`, such as "sphere:R=2";
            smooth unless `hurst`, `rms_gradient` or `rms_height` is given. `gfmd.sphere` and its siblings make it.
        rms_gradient: rms of the full gradient, 0.1 by default; or
        rms_height: rms height, length.
        seed: random seed, below 2**63; the surface does not depend on the grid.
        size: cell size, L or (Lx, Ly); 1 by default.
        unit: unit of heights and lengths, such as "um"; lengths may then be strings with a unit. By default the unit of
            the size, if any.
        eps_t_inv: cell length divided by longest wavelength, at least 1; 2 by default.
        eps_f_inv: longest divided by shortest wavelength; by default 4 points per shortest wavelength.
        eps_c_inv: points per shortest wavelength, at least 2, in place of `n`.
        dim: 3 for a surface, 2 for a profile.
        method: "psd", or "sra" or "rmd" (subdivision, not periodic).
        roll_off: roll-off wavelength, length; at longer wavelengths the spectrum is flat.
        roll_off_shape: transition to the flat spectrum, "plateau" or "smooth".
        amplitudes: "gaussian", or "fixed" (random phases only).
        aspect: correlation length along the lay divided by the correlation length across it, at least 1.
        lay: direction of the lay from the x axis, degrees; 0 by default.
        marginal: height distribution, "lognormal:SIGMA" or "weibull:SHAPE", mirrored by a negative number; or an array
            of rows (height, fraction of the surface below it). Mean and width do not matter; the spectrum is kept.
            Normal by default.

    Raises:
        InputError: a value out of range, incompatible values.

    Example:
        >>> s = gfmd.self_affine(n=64, hurst=0.8, rms_gradient=0.1, seed=1)
        >>> s.heights.shape, round(s.rms_gradient, 12)
        ((64, 64), 0.1)
    """
    if rms_gradient is not None and rms_height is not None:
        raise InputError("rms_gradient and rms_height are both given; give one of the two")
    if n is None:
        points = []
    elif isinstance(n, (tuple, list)):
        points = [integer("n", value, 0, 2**62) for value in n]
    else:
        points = [integer("n", n, 0, 2**62)]
    unit = _unit_of(size) if unit is None else word("unit", unit)
    heights, lengths, description, periodic = _gfmd.self_affine(
        n=points,
        size=(
            [] if size is None else [in_units("size", length, None, unit, None) for length in quantities("size", size)]
        ),
        shape=None if shape is None else word("shape", shape),
        unit=unit,
        hurst=optional("hurst", hurst),
        eps_t_inv=optional("eps_t_inv", eps_t_inv),
        eps_f_inv=optional("eps_f_inv", eps_f_inv),
        eps_c_inv=optional("eps_c_inv", eps_c_inv),
        rms_gradient=optional("rms_gradient", rms_gradient),
        rms_height=None if rms_height is None else in_units("rms_height", rms_height, None, unit, None),
        seed=integer("seed", seed, 0, 2**63 - 1),
        dim=integer("dim", dim, 2, 3),
        method=word("method", method),
        roll_off=None if roll_off is None else in_units("roll_off", roll_off, None, unit, None),
        roll_off_shape=word("roll_off_shape", roll_off_shape),
        amplitudes=word("amplitudes", amplitudes),
        aspect=None if aspect is None else number("aspect", aspect),
        lay=None if lay is None else number("lay", lay),
        marginal=None if marginal is None else _marginal(marginal),
    )
    origin = _Origin(description, {}, periodic)
    return _surface(heights, lengths, None if unit is None else _gfmd.canonical(unit), origin)


def _marginal(marginal: Any) -> str:
    """Returns the text of a height distribution."""
    if isinstance(marginal, str):
        return marginal
    rows = np.asarray(marginal, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 2:
        raise InputError(
            f"marginal has the shape {rows.shape}; it must be a text or rows (height, fraction of the surface below it)"
        )
    return ",".join(f"{height!r}:{probability!r}" for height, probability in rows.tolist())


@hinted
def profile(
    x: npt.ArrayLike, heights: npt.ArrayLike, n: Optional[int] = None, *, unit: Optional[str] = None
) -> Surface:
    """Makes a profile from unevenly spaced heights, with straight lines between them.

    Args:
        x: positions, length, distinct and in any order.
        heights: height at each position, length.
        n: number of evenly spaced points from the first to the last position; by default their spacing is the largest
            in `x`.
        unit: unit of heights and positions, such as "um".

    Raises:
        InputError: equal positions, fewer than two, a gap larger than ten median spacings.

    Example:
        >>> gfmd.profile([0.0, 1.0, 1.5, 3.0], [0.0, 1.0, 0.5, 0.0], n=4, unit="um")
        Surface of 4 points on 4 µm (profile of 4 uneven points)
    """
    made, spacing = _gfmd.even(numbers("x", x), numbers("heights", heights), None if n is None else integer("n", n, 2))
    known = None if unit is None else _gfmd.canonical(word("unit", unit))
    origin = _Origin(f"profile of {len(np.asarray(x))} uneven points", {})
    return _surface(made, (len(made) * spacing, 1.0), known, origin)


def _unit_of(size: Any) -> Optional[str]:
    """Returns the unit in a size given as text; None for numbers."""
    lengths = [size] if isinstance(size, str) else size if isinstance(size, (list, tuple)) else []
    units = (length.lstrip("+-.0123456789eE ").strip() for length in lengths if isinstance(length, str))
    return next((unit for unit in units if unit), None)


@hinted
def read(
    name: Union[str, "os.PathLike[str]"],
    channel: Union[str, int, None] = None,
    *,
    image_heights: bool = False,
    fill: Optional[str] = None,
    size: Size = None,
    unit: Optional[str] = None,
) -> Surface:
    """Reads a surface from a file, in any format of `gfmd surface --surface`, detected from the contents.

    Args:
        name: file from an instrument or program (docs/formats.md), or "FILE.h5:/dataset".
        channel: name or number, from 0, of the height map in the file; by default the default of the file.
        image_heights: True to read the grey values of an 8-bit image as heights; otherwise such images are refused,
            since most are pictures.
        fill: how to fill undefined points, "harmonic" or "nearest", as in `Surface`; None leaves them undefined (NaN),
            to be cropped or filled before a contact.
        size: cell size; by default as in the file, or 1.
        unit: unit of heights and lengths; a file in another unit is converted. By default the unit of the file.

    Raises:
        InputError: a file that cannot be read, a missing channel.

    Example:
        >>> np.savetxt("scan.txt", [[0.0, 1.0, 0.5], [0.5, 0.0, 1.0]])
        >>> gfmd.read("scan.txt", size=(3e-6, 2e-6), unit="m")
        Surface of 3 x 2 points on 3 x 2 µm (scan.txt)
    """
    path, (heights, lengths, known, description, file) = _map(name, channel, image_heights)
    said = {**parsed(file), "path": os.path.abspath(path if os.path.exists(path) else path.rpartition(":")[0])}
    wanted = None if unit is None else _gfmd.canonical(word("unit", unit))
    if wanted is not None and known is not None:
        heights, moved, known = _gfmd.converted(heights, lengths or (1.0, 1.0), known, wanted)
        lengths = None if lengths is None else moved
    known = known if wanted is None or known is not None else wanted
    cell = _check.size(lengths if size is None else size, (int(heights.shape[0]), int(heights.shape[1])), known)
    if fill is None:
        return _surface(heights, cell, known, _Origin(description, said))
    heights = _check.whole(path, heights, said["undefined"], cell, fill)
    origin = _Origin(_filled(description, said["undefined"], fill), said)
    return _surface(heights, cell, known, origin)


def read_heights(
    name: Union[str, "os.PathLike[str]"], channel: Union[str, int, None] = None, *, image_heights: bool = False
) -> tuple[Array, Optional[tuple[float, float]], Optional[str]]:
    """Reads the heights of a file unchanged, with NaN at undefined points, such as to cut out a part.

    Args:
        name, channel, image_heights: as in `read`.

    Returns:
        Heights [x, y], lengths of the whole map (n times the spacing), and their unit; lengths and unit are None if not
        in the file.

    Raises:
        InputError: a file that cannot be read, a missing channel.

    Example:
        >>> np.savetxt("scan.txt", [[0.0, 1.0, np.nan], [0.5, 0.0, 1.0]])
        >>> heights, size, unit = gfmd.read_heights("scan.txt")
        >>> gfmd.Surface(heights[:2], size=(2e-6, 2e-6), unit="m")
        Surface of 2 x 2 points on 2 x 2 µm (array)
    """
    _, (heights, lengths, known, _, _) = _map(name, channel, image_heights)
    return heights, None if lengths is None else tuple(lengths), known


def _map(name: Any, channel: Any, image_heights: bool) -> tuple[str, Any]:
    """Returns the checked names of a file and of a height map in it."""
    path = _check.path("name", name)
    asked = None if channel is None else channel if isinstance(channel, str) else str(integer("channel", channel))
    return path, _gfmd.read(path, None if asked is None else word("channel", asked), bool(image_heights))
