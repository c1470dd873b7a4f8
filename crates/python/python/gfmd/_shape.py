"""Surfaces of closed-form shapes: spheres, cones, punches, waves, smooth or rough."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Optional, TypedDict, Union

import numpy.typing as npt

from ._check import Quantity, number, quantities, quantity, word
from ._errors import InputError
from ._surface import Size, Surface, self_affine

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ShapeOptions(TypedDict, total=False):
    """Arguments of `self_affine` beside the shape: grid, cell, and roughness."""

    n: Union[int, tuple[int, int], None]
    size: Size
    unit: Optional[str]
    dim: int
    hurst: Optional[float]
    rms_gradient: Optional[float]
    rms_height: Optional[Quantity]
    seed: int
    eps_t_inv: Optional[float]
    eps_f_inv: Optional[float]
    eps_c_inv: Optional[float]
    method: str
    roll_off: Optional[Quantity]
    roll_off_shape: str
    amplitudes: str
    aspect: Optional[float]
    lay: Optional[float]
    marginal: Union[str, npt.ArrayLike, None]


def _made(kind: str, options: ShapeOptions, **values: Union[Quantity, None]) -> Surface:
    """Returns the surface of a shape, omitting values that are None."""
    entries = ",".join(f"{key}={value}" for key, value in values.items() if value is not None)
    if "shape" in dict(options):
        raise TypeError(f"{kind.replace('-', '_')} has no argument 'shape'; it is the shape itself")
    return self_affine(shape=f"{kind}:{entries}", **options)


def _length(name: str, value: Optional[Quantity]) -> Optional[Quantity]:
    return None if value is None else quantity(name, value, "length")


def sphere(radius: Quantity, **options: Unpack[ShapeOptions]) -> Surface:
    """Makes a sphere, as `gfmd surface --shape sphere:R=` does.

    Its top is in the middle of the cell, at height 0: a grid point if the numbers of points are even. Beyond the
    equator the surface is flat, one radius below the top. Shapes are usually pressed with `boundary="free"`; periodic
    boundaries give an array of shapes.

    Args:
        radius: radius, length.
        options: `n`, `size`, `unit`, and arguments of `self_affine`; with `hurst`, `rms_gradient` or `rms_height` the
            sphere is rough.

    Raises:
        InputError: a radius that is not positive or smaller than the grid spacing; the errors of `self_affine`.

    Example:
        >>> ball = gfmd.sphere("10 mm", size="0.4 mm", n=32)
        >>> c = gfmd.contact(ball, gfmd.Body(young="70 GPa", poisson=0.3), force="1 N", boundary="free")
        >>> hertz = (0.75 * 1.0 * 10e-3 / (70e9 / 0.91)) ** (1 / 3)
        >>> bool(abs(np.sqrt(c.area_fraction * 0.4**2 / np.pi) * 1e-3 / hertz - 1) < 0.05)
        True
    """
    return _made("sphere", options, R=_length("radius", radius))


def paraboloid(radius: Union[Quantity, tuple[Quantity, Quantity]], **options: Unpack[ShapeOptions]) -> Surface:
    """Makes a paraboloid, the shape in Hertz's theory, as `gfmd surface --shape paraboloid:R=` does.

    The heights are -x²/(2 Rx) - y²/(2 Ry) from the middle of the cell. A profile (`dim=2`) is a parabola.

    Args:
        radius: radius of curvature at the top, or the radii in the planes of x and y, length.
        options: as in `sphere`.

    Raises:
        InputError: a radius that is not positive; the errors of `self_affine`.

    Example:
        >>> float(gfmd.paraboloid(2.0, n=4).heights.min())
        -0.125
    """
    radii = quantities("radius", radius, "length")
    if len(radii) > 2:
        raise InputError(f"radius is {radius!r}; it must be one radius or two")
    if len(radii) == 2:
        return _made("paraboloid", options, Rx=radii[0], Ry=radii[1])
    return _made("paraboloid", options, R=radii[0])


def ellipsoid(semi_axes: tuple[Quantity, Quantity, Quantity], **options: Unpack[ShapeOptions]) -> Surface:
    """Makes an ellipsoid, as `gfmd surface --shape ellipsoid:a=,b=,c=` does.

    Beyond the equator the surface is flat, at the height of the equator.

    Args:
        semi_axes: semi-axes along x, y and z, length. The radii of curvature at the top are a²/c and b²/c.
        options: as in `sphere`.

    Raises:
        InputError: semi-axes that are not positive; the errors of `self_affine`.

    Example:
        >>> gfmd.ellipsoid((2.0, 1.0, 1.0), n=8).n
        (8, 8)
    """
    axes = quantities("semi_axes", semi_axes, "length")
    if len(axes) != 3:
        raise InputError(f"semi_axes is {semi_axes!r}; it must be the semi-axes along x, y and z")
    return _made("ellipsoid", options, a=axes[0], b=axes[1], c=axes[2])


def cylinder(radius: Quantity, *, axis: Literal["x", "y"] = "y", **options: Unpack[ShapeOptions]) -> Surface:
    """Makes a cylinder lying on its side, as `gfmd surface --shape cylinder:R=` does.

    Args:
        radius: radius, length.
        axis: axis direction, "x" or "y"; "y" for a profile (`dim=2`).
        options: as in `sphere`.

    Raises:
        InputError: a radius that is not positive or smaller than the grid spacing; the errors of `self_affine`.

    Example:
        >>> gfmd.cylinder(5.0, dim=2, n=64)
        Surface of 64 points on 1 length units (smooth profile, cylinder:R=5.0,axis=y)
    """
    return _made("cylinder", options, R=_length("radius", radius), axis=word("axis", axis))


def cone(slope: float, **options: Unpack[ShapeOptions]) -> Surface:
    """Makes a cone, as `gfmd surface --shape cone:slope=` does.

    Args:
        slope: tangent of the angle between its face and the surface of the body, dimensionless.
        options: as in `sphere`.

    Raises:
        InputError: a slope that is not positive; the errors of `self_affine`.

    Example:
        >>> float(gfmd.cone(0.1, n=4).heights[0, 2])
        -0.05
    """
    return _made("cone", options, slope=number("slope", slope))


def wedge(slope: float, *, axis: Literal["x", "y"] = "y", **options: Unpack[ShapeOptions]) -> Surface:
    """Makes a wedge, as `gfmd surface --shape wedge:slope=` does.

    Args:
        slope: tangent of the angle between its faces and the surface of the body, dimensionless.
        axis: edge direction, "x" or "y"; "y" for a profile (`dim=2`).
        options: as in `sphere`.

    Raises:
        InputError: a slope that is not positive; the errors of `self_affine`.

    Example:
        >>> float(gfmd.wedge(0.1, n=4).heights[0, 0])
        -0.05
    """
    return _made("wedge", options, slope=number("slope", slope), axis=word("axis", axis))


def flat_punch(
    radius: Quantity, edge: Quantity = 0.0, *, depth: Optional[Quantity] = None, **options: Unpack[ShapeOptions]
) -> Surface:
    """Makes a flat round punch with a rounded edge, as `gfmd surface --shape flat-punch:a=,R=` does.

    The flat face is at height 0, surrounded by an edge, a quarter of a circle, and a floor. A profile (`dim=2`) is a
    strip. `punch` solves the ideal punch, also bonded.

    Args:
        radius: radius of the flat face, half of its width in a profile, length.
        edge: edge radius, length; 0 for a sharp edge, which needs a depth.
        depth: depth of the floor below the face, length; by default, and at least, the edge radius.
        options: as in `sphere`.

    Raises:
        InputError: a radius that is not positive or smaller than the grid spacing, a floor above the edge; the errors
            of `self_affine`.

    Example:
        >>> face = gfmd.flat_punch(0.25, depth=0.1, n=8).heights == 0
        >>> int(face.sum())
        13
    """
    return _made(
        "flat-punch", options, a=_length("radius", radius), R=_length("edge", edge), depth=_length("depth", depth)
    )


def wave(
    amplitude: Quantity,
    wavelength: Union[Quantity, tuple[Quantity, Quantity], None] = None,
    **options: Unpack[ShapeOptions],
) -> Surface:
    """Makes a wave, as `gfmd surface --shape wave:A=` does.

    Along x it is A cos(2π x/λ), with two wavelengths A cos(2π x/λx) cos(2π y/λy), from the middle of the cell.

    Args:
        amplitude: half the height from valley to peak, length.
        wavelength: wavelength along x, or along x and y, length; a whole number must fit into the cell. By default one
            wave along x.
        options: as in `sphere`.

    Raises:
        InputError: an amplitude that is not positive, a wavelength that does not fit into the cell; the errors of
            `self_affine`.

    Example:
        >>> s = gfmd.wave(0.01, (0.5, 0.5), n=32)
        >>> s.is_periodic, round(s.rms_height, 12)
        (True, 0.005)
    """
    given = [] if wavelength is None else quantities("wavelength", wavelength, "length")
    if len(given) > 2:
        raise InputError(f"wavelength is {wavelength!r}; it must be one wavelength or two")
    along_x, along_y = [*given, None, None][:2]
    return _made("wave", options, A=_length("amplitude", amplitude), Lx=along_x, Ly=along_y)
