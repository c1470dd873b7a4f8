"""Elastic bodies, and laws of what acts across the gap."""

from __future__ import annotations

import math
from typing import Any, Optional

from . import _gfmd
from ._check import number, optional, word
from ._errors import InputError
from ._record import Record


class Body(Record):
    """An elastic body: a half-space, or a slab bonded to a rigid base.

    Args:
        young: Young's modulus E, stress; 1 by default.
        poisson: Poisson's ratio, above -1 and up to 0.5; 0 by default.
        e_star: contact modulus E* = E/(1 - poisson²), stress, in place of `young`.
        height: height of the slab, length; None or infinity for a half-space.
        base: what a slab stands on: "bonded".

    Raises:
        InputError: a value out of its range.

    Example:
        >>> gfmd.Body(young=70e9, poisson=0.33).e_star
        78554595444.84906
    """

    def __init__(
        self,
        young: Optional[float] = None,
        poisson: float = 0.0,
        *,
        e_star: Optional[float] = None,
        height: Optional[float] = None,
        base: str = "bonded",
    ) -> None:
        if young is not None and e_star is not None:
            raise InputError("young and e_star are both given; give one of the two")
        if word("base", base) != "bonded":
            raise InputError(f"base is {base!r}; it must be 'bonded'")
        nu = number("poisson", poisson)
        if not -1.0 < nu <= 0.5:
            raise InputError(f"poisson is {nu}; it must be above -1 and at most 0.5")
        modulus, contact = optional("young", young), optional("e_star", e_star)
        for name, value in (("young", modulus), ("e_star", contact)):
            if value is not None and not 0.0 < value < math.inf:
                raise InputError(f"{name} is {value}; it must be positive and finite")
        thickness = optional("height", height)
        if thickness is not None and not thickness > 0.0:
            raise InputError(f"height is {thickness}; it must be positive, or None for a half-space")
        thickness = None if thickness == math.inf else thickness
        if contact is None:
            modulus = 1.0 if modulus is None else modulus
            contact_modulus = modulus / ((1.0 - nu) * (1.0 + nu))
        else:
            contact_modulus = contact
        super().__init__({
            "young": contact_modulus * (1.0 - nu * nu) if modulus is None else modulus,
            "poisson": nu,
            "e_star": contact_modulus,
            "height": thickness,
            "base": "bonded",
        })
        object.__setattr__(self, "_given", (modulus or 1.0, nu, contact, thickness))

    _given: tuple[float, float, Optional[float], Optional[float]]

    def __reduce__(self) -> tuple[Any, ...]:
        modulus, nu, contact, thickness = self._given
        return _body, (None if contact is not None else modulus, nu, contact, thickness)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._given == self._given

    def __hash__(self) -> int:
        return hash(self._given)


def _body(young: Optional[float], poisson: float, e_star: Optional[float], height: Optional[float]) -> Body:
    return Body(young, poisson, e_star=e_star, height=height)


class Law(Record):
    """A law of what acts across the gap: its `name`, and its parameters. `gfmd.law` makes one."""

    def __init__(self, name: str, parameters: dict[str, float]) -> None:
        _gfmd.check_law(name, list(parameters.items()))
        super().__init__({"name": name, **parameters})

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name."""
        return {name: value for name, value in self._values.items() if name != "name"}

    @property
    def _native(self) -> tuple[str, list[tuple[str, float]]]:
        return self.name, list(self.parameters.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return Law, (self.name, self.parameters)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and other._values == self._values

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))


def law(name: str, /, **parameters: float) -> Law:
    """A law of adhesion or cohesion by its name and its parameters.

    Names: hard-wall; morse, exponential, dugdale (gamma, range); harmonic-cosine (gamma, curvature); xu-needleman, bsg,
    c3d, npb, npc (phi_n, phi_t, delta_n, delta_t). gamma and phi are stress * length, range and delta length.

    Raises:
        InputError: an unknown name or parameter, a missing one, a value out of its range.

    Example:
        >>> gfmd.law("morse", gamma=2e-4, range=1.2e-3).range
        0.0012
    """
    return Law(word("law", name), {key: number(key, value) for key, value in parameters.items()})


def as_law(value: object) -> Law:
    if value is None:
        return Law("hard-wall", {})
    if isinstance(value, str):
        return Law(value, {})
    if isinstance(value, Law):
        return value
    raise InputError(f"law is {value!r}; it must be made by gfmd.law, or a name")


def as_body(value: object) -> Body:
    if isinstance(value, Body):
        return value
    raise InputError(f"body is {type(value).__name__}; it must be a gfmd.Body")
