"""Elastic bodies, and laws of what acts across the gap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Optional

from . import _gfmd
from ._check import number, optional, shown, word
from ._errors import InputError
from ._record import Record

_BASES = ("bonded", "sliding", "free", "half-space")


class Body(Record):
    """An elastic body: a half-space, or a slab or a stack of layers on a base; with `second_body` a pair of bodies.

    Args:
        young: Young's modulus E, stress; 1 by default.
        poisson: Poisson's ratio, above -1 and up to 0.5; 0 by default.
        e_star: contact modulus E* = E/(1 - poisson²), stress, in place of `young`.
        height: height of the slab, or of the top layer, length; None or infinity for a half-space.
        base: what the lowest layer stands on: "bonded" (to a rigid base), "sliding" (on a rigid base without friction), "free"
            (a plate, held by the opposite of the mean traction on its lower face), or "half-space" (bonded to an elastic one).
        base_young: Young's modulus of the half-space below, stress; with base="half-space" only.
        base_poisson: Poisson's ratio of the half-space below; with base="half-space" only.
        layers: layers below the top one, from the top down: (Young's modulus, Poisson's ratio, height) of each.
        second_body: (Young's modulus, Poisson's ratio) of a half-space, or with a height of a slab bonded at its back, to which
            the rough surface belongs. Displacements are then relative: those of both bodies together.
        prony: Prony series of a viscoelastic body, for `gfmd.path` in time: (relaxation time, fraction of the instantaneous modulus) of
            each branch.
        moduli: the moduli that are given, "long-term" or "instantaneous"; with `prony` only.
        relaxes: the moduli that relax, "both" or "shear" (with a constant bulk modulus); with `prony` only.

    `e_star` is the contact modulus of which p* is formed: that of the material of the top layer; with a second body
    1/(1/E1* + 1/E2*). `young`, `poisson` are those of the top layer.

    Raises:
        InputError: a value out of its range.

    Example:
        >>> gfmd.Body(young=70e9, poisson=0.33).e_star
        78554595443.83347
        >>> gfmd.Body(height=0.1, layers=[(3.0, 0.3, 0.2)], base="sliding").layers
        ((3.0, 0.3, 0.2),)
        >>> gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)]).prony
        ((0.1, 0.3), (10.0, 0.4))
    """

    young: float
    poisson: float
    e_star: float
    height: Optional[float]
    base: str
    layers: tuple[tuple[float, float, float], ...]
    second_body: Optional[tuple[float, ...]]
    prony: tuple[tuple[float, float], ...]
    moduli: str
    relaxes: str
    _given: tuple[float, float, Optional[float], Optional[float]]

    def __init__(
        self,
        young: Optional[float] = None,
        poisson: float = 0.0,
        *,
        e_star: Optional[float] = None,
        height: Optional[float] = None,
        base: str = "bonded",
        base_young: Optional[float] = None,
        base_poisson: Optional[float] = None,
        layers: Sequence[Sequence[float]] = (),
        second_body: Optional[Sequence[float]] = None,
        prony: Sequence[Sequence[float]] = (),
        moduli: str = "long-term",
        relaxes: str = "both",
    ) -> None:
        if young is not None and e_star is not None:
            raise InputError("young and e_star are both given; give one of the two")
        nu = _ratio("poisson", poisson)
        modulus, contact = _modulus("young", young), _modulus("e_star", e_star)
        thickness = optional("height", height)
        if thickness is not None and not thickness > 0.0:
            raise InputError(f"height is {thickness}; it must be positive, or None for a half-space")
        thickness = None if thickness == math.inf else thickness
        if contact is None:
            modulus = 1.0 if modulus is None else modulus
            contact_modulus = modulus / ((1.0 - nu) * (1.0 + nu))
        else:
            contact_modulus = contact
        second = None if second_body is None else _sheet("second_body", second_body, "(young, poisson) or (young, poisson, height)", (2, 3))
        values = {
            "young": contact_modulus * (1.0 - nu * nu) if modulus is None else modulus,
            "poisson": nu,
            "e_star": contact_modulus if second is None else _composite(contact_modulus, second),
            "height": thickness,
            "base": word("base", base),
            "layers": _layers(layers, thickness),
            "second_body": second,
            **_relaxation(prony, word("moduli", moduli), word("relaxes", relaxes)),
        }
        super().__init__({**values, **_below(base, thickness, base_young, base_poisson)})
        object.__setattr__(self, "_given", (modulus or 1.0, nu, contact, thickness))

    def __reduce__(self) -> tuple[Any, ...]:
        modulus, nu, contact, thickness = self._given
        below = self._values.get("base_young"), self._values.get("base_poisson")
        top = (None if contact is not None else modulus, nu, contact, thickness)
        relaxation = self.prony, self.moduli, self.relaxes
        return _body, (*top, self.base, *below, self.layers, self.second_body, *relaxation)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other.__reduce__()[1] == self.__reduce__()[1]

    def __hash__(self) -> int:
        return hash(self.__reduce__()[1])


def _modulus(name: str, value: object) -> Optional[float]:
    found = optional(name, value)
    if found is not None and not 0.0 < found < math.inf:
        raise InputError(f"{name} is {found}; it must be positive and finite")
    return found


def _ratio(name: str, value: object) -> float:
    found = number(name, value)
    if not -1.0 < found <= 0.5:
        raise InputError(f"{name} is {found}; it must be above -1 and at most 0.5")
    return found


def _sheet(name: str, value: object, form: str, lengths: tuple[int, ...]) -> tuple[float, ...]:
    """Young's modulus, Poisson's ratio, and perhaps the height of a layer or a slab."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence) or len(value) not in lengths:
        raise InputError(f"{name} is {shown(value)}; it must be {form}")
    found = [number(name, entry) for entry in value]
    _modulus(f"young of {name}", found[0])
    _ratio(f"poisson of {name}", found[1])
    if len(found) == 3 and not 0.0 < found[2] < math.inf:
        raise InputError(f"height of {name} is {found[2]}; it must be positive and finite")
    return tuple(found)


def _layers(value: object, height: Optional[float]) -> tuple[tuple[float, ...], ...]:
    form = "a list of (young, poisson, height)"
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
        raise InputError(f"layers is {shown(value)}; it must be {form}")
    if value and height is None:
        raise InputError(f"layers is {shown(value)}; it must be left out for a half-space, below which nothing lies")
    return tuple(_sheet("layers", layer, form, (3,)) for layer in value)


def _relaxation(prony: object, moduli: str, relaxes: str) -> dict[str, Any]:
    """The branches of a viscoelastic body, none of an elastic one."""
    form = "a list of (relaxation time, fraction of the instantaneous modulus)"
    if isinstance(prony, (str, bytes)) or not isinstance(prony, Sequence):
        raise InputError(f"prony is {shown(prony)}; it must be {form}")
    branches = []
    for branch in prony:
        if isinstance(branch, (str, bytes)) or not isinstance(branch, Sequence) or len(branch) != 2:
            raise InputError(f"prony has the branch {shown(branch)}; it must be {form}")
        time, fraction = (number("prony", entry) for entry in branch)
        if not 0.0 < time < math.inf:
            raise InputError(f"a relaxation time of prony is {time}; it must be positive and finite")
        if not 0.0 < fraction < 1.0:
            raise InputError(f"a fraction of prony is {fraction}; it must be above 0 and below 1")
        branches.append((time, fraction))
    if len({time for time, _ in branches}) < len(branches):
        raise InputError(f"prony is {shown(prony)}; its relaxation times must differ")
    if not sum(fraction for _, fraction in branches) < 1.0:
        raise InputError(f"prony is {shown(prony)}; its fractions must add up to less than 1")
    for name, value, allowed in (("moduli", moduli, ("long-term", "instantaneous")), ("relaxes", relaxes, ("both", "shear"))):
        if value not in allowed:
            raise InputError(f"{name} is {value!r}; it must be {allowed[0]!r} or {allowed[1]!r}")
        if value != allowed[0] and not branches:
            raise InputError(f"{name} is {value!r}; it must be left out without prony")
    return {"prony": tuple(branches), "moduli": moduli, "relaxes": relaxes}


def _composite(first: float, second: tuple[float, ...]) -> float:
    """The contact modulus of two bodies, as the program forms it."""
    small, large = sorted((first, second[0] / ((1.0 - second[1]) * (1.0 + second[1]))))
    return small / (1.0 + small / large)


def _below(base: str, height: Optional[float], young: object, poisson: object) -> dict[str, float]:
    """The properties of an elastic base."""
    if base not in _BASES:
        raise InputError(f"base is {base!r}; it must be one of {', '.join(map(repr, _BASES))}")
    if height is None and base != "bonded":
        raise InputError(f"base is {base!r}; it must be 'bonded' for a half-space, which has no base")
    if base != "half-space":
        for name, value in (("base_young", young), ("base_poisson", poisson)):
            if value is not None:
                raise InputError(f"{name} is {value!r}; it must be left out unless base is 'half-space'")
        return {}
    modulus = _modulus("base_young", young)
    if modulus is None or poisson is None:
        raise InputError(f"{'base_young' if modulus is None else 'base_poisson'} is missing; it is needed if base is 'half-space'")
    return {"base_young": modulus, "base_poisson": _ratio("base_poisson", poisson)}


def _body(
    young: Optional[float],
    poisson: float,
    e_star: Optional[float],
    height: Optional[float],
    base: str = "bonded",
    base_young: Optional[float] = None,
    base_poisson: Optional[float] = None,
    layers: Sequence[Sequence[float]] = (),
    second_body: Optional[Sequence[float]] = None,
    prony: Sequence[Sequence[float]] = (),
    moduli: str = "long-term",
    relaxes: str = "both",
) -> Body:
    below = {"base": base, "base_young": base_young, "base_poisson": base_poisson, "layers": layers}
    relaxation = {"prony": prony, "moduli": moduli, "relaxes": relaxes}
    return Body(young, poisson, e_star=e_star, height=height, second_body=second_body, **below, **relaxation)  # type: ignore[arg-type]


class Law(Record):
    """A law of what acts across the gap: its `name`, and its parameters as attributes. `gfmd.law` makes one.

    Raises:
        InputError: as `gfmd.law`.

    Example:
        >>> gfmd.law("dugdale", gamma=1e-4, range=2e-3).parameters
        {'gamma': 0.0001, 'range': 0.002}
    """

    name: str

    def __init__(self, name: str, parameters: dict[str, float]) -> None:
        _gfmd.check_law(name, list(parameters.items()))
        super().__init__({"name": name, **parameters})

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name, in the units of `gfmd.law`."""
        return {name: value for name, value in self._values.items() if name != "name"}

    def __reduce__(self) -> tuple[Any, ...]:
        return Law, (self.name, self.parameters)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and other._values == self._values

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))


def law(name: str, /, **parameters: float) -> Law:
    """A law of adhesion or cohesion by its name and its parameters.

    Args:
        name: "hard-wall"; "morse", "exponential", "dugdale" (`gamma`, `range`); "harmonic-cosine" (`gamma`, `curvature`);
            "xu-needleman", "bsg", "c3d", "npb", "npc" (`phi_n`, `phi_t`, `delta_n`, `delta_t`; the first also `r`).
        parameters: gamma and phi in stress * length, range and delta in length, curvature in stress/length, r without unit.

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
    raise InputError(f"law is {shown(value)}; it must be made by gfmd.law, or a name")


def as_body(value: object, in_time: bool = False) -> Body:
    if not isinstance(value, Body):
        raise InputError(f"body is {type(value).__name__}; it must be a gfmd.Body")
    if value.prony and not in_time:
        raise InputError("body is viscoelastic; it must be elastic here (gfmd.path follows a viscoelastic one in time)")
    return value
