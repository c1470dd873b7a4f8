"""Elastic bodies, and laws of adhesion and cohesion."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from typing import Any, Literal, Optional, Union, get_args

import numpy as np
import numpy.typing as npt

from . import _gfmd
from ._check import KINDS, Array, Quantity, array, in_units, integer, kind_of, number, quantity, shown, word
from ._errors import InputError
from ._hints import hinted
from ._record import Record
from ._types import Fitted

_Compliance = Union[
    Array,
    "tuple[npt.ArrayLike, npt.ArrayLike | Callable[[Array], npt.ArrayLike]]",
    "tuple[npt.ArrayLike, int, npt.ArrayLike | Callable[[Array, Array], npt.ArrayLike]]",
]

_Base = Literal["bonded", "sliding", "free", "half-space"]


class Material(dict[str, Any]):
    """Arguments of `gfmd.Body` for a material, with its `name` and the `source` of its values.

    Example:
        >>> steel = gfmd.material("steel-s355")
        >>> steel.name, steel["young"]
        ('steel-s355', '210GPa')
    """

    name: str
    source: str

    @classmethod
    def named(cls, name: str, *others: str, option: str = "material") -> Material:
        """Returns the material named by an `option`, with `others` of its values.

        Example:
            >>> gfmd.Material.named("aluminium")["poisson"]
            0.3
        """
        known: dict[str, dict[str, Any]] = json.loads(_gfmd.materials())
        if name not in known:
            raise InputError(f"{option} is {shown(name)}; it must be one of {', '.join(known)}")
        found = known[name]
        for other in others:
            if other == "source" or other not in found:
                raise InputError(f"{shown(other)} is not a value that the source of {name} has: {found['source']}")
        made = cls({key: found[key] for key in ("young", "poisson", *others)})
        made.name, made.source = name, found["source"]
        return made

    @property
    def recorded(self) -> str:
        """Name and source, as in the file of a result."""
        return f"{self.name} ({self.source})"


def material(name: str, *others: str) -> Material:
    """Returns the arguments `young` and `poisson` of `gfmd.Body` for a material.

    Its attribute `source` cites the values. `gfmd.Body(material=name)` takes the same values, and results then record
    name and source.

    Args:
        name: material name, as `gfmd materials` lists it.
        others: further values, if the source has them: "yield_stress", "prony" with "relaxes" (for rubbers, whose
            moduli are then the fully relaxed ones), "conductivity".

    Raises:
        InputError: an unknown name, a value that the source lacks.

    Example:
        >>> gfmd.material("aluminium")
        {'young': '70GPa', 'poisson': 0.3}
        >>> gfmd.material("steel-s355", "yield_stress")["yield_stress"]
        '355MPa'
        >>> gfmd.Body(**gfmd.material("nbr", "prony", "relaxes")).relaxes
        'shear'
        >>> gfmd.Body(**gfmd.material("aluminium")).young
        70000000000.0
        >>> gfmd.Body(material="aluminium").material
        'aluminium (EN 1999-1-1:2007, 3.2.5 (all structural alloys))'
    """
    return Material.named(name, *others)


class Body(Record):
    """An elastic body: a half-space, a slab or a stack of layers on a base; with `second_body`, a pair of bodies.

    Args:
        young: Young's modulus E, stress; 1 by default, required for a surface with a unit. All stresses and lengths may
            be strings with a unit, such as "70GPa".
        poisson: Poisson's ratio, above -1 and at most 0.5; 0 by default.
        e_star: contact modulus E* = E/(1 - poisson²), stress, in place of `young`.
        material: name of a material, in place of `young` and `poisson`; results record its source (`gfmd.material`).
        height: height of the slab or top layer, length; None or infinity for a half-space.
        base: support of the lowest layer: "bonded" (to a rigid base), "sliding" (on a rigid base without friction),
            "free" (a plate, balanced by an opposite mean traction on its lower face), or "half-space" (bonded to an
            elastic half-space).
        base_young: Young's modulus of the half-space below, stress; with base="half-space" only.
        base_poisson: Poisson's ratio of the half-space below; with base="half-space" only.
        layers: (Young's modulus, Poisson's ratio, height) of each layer below the top one, from the top down.
        second_body: elastic body of the rough surface: (Young's modulus, Poisson's ratio) of a half-space, or (Young's
            modulus, Poisson's ratio, height) of a slab bonded at its back. Displacements are then relative: the sum
            over both bodies.
        second_material: material name, in place of `second_body`, of a half-space.
        prony: Prony series of a viscoelastic body, for `gfmd.path` in time: (relaxation time, fraction of the
            instantaneous modulus) of each branch; or the fit of `gfmd.prony`, whose fully relaxed modulus is then the
            default of `young`.
        moduli: kind of the given moduli, "long-term" (fully relaxed) or "instantaneous"; with `prony` only.
        relaxes: relaxing moduli, "both" or "shear" (with a constant bulk modulus); with `prony` only.
        yield_stress: von Mises yield stress of a body that yields below its surface, stress, for `gfmd.path`; of the
            top layer if there are several.
        hardening: isotropic hardening H, stress: slope of yield stress against equivalent plastic strain. With the
            kinematic hardening C, the tangent modulus of a bar is E (H + C)/(E + H + C).
        hardening_curve: in place of `hardening`: (equivalent plastic strain, true yield stress) from (0, yield_stress);
            constant beyond the last.
        kinematic_hardening: kinematic hardening C, stress: back stress of a bar divided by its plastic strain.
        layer_yield: yield stress of each layer below the top one, stress, 0 for an elastic layer; all elastic by
            default.
        compliance: normal compliance of the whole body, in place of its moduli, for graded and other bodies: a pair of
            wavenumbers q, rad / length, in ascending order, and the compliance u_z/pressure at each, length / stress,
            or a function of q that returns it. Four to 1000 wavenumbers, from 2 pi divided by the longest side to pi
            sqrt(2) divided by the spacing; between them ln G is a shape-preserving cubic of ln q. `young` or `e_star`,
            the modulus in p*, is then required. For an anisotropic body (wavenumbers, M, G), with the compliance
            [wavenumber, direction] in M directions of the wave vector, j pi/M from the x axis for j = 0 .. M-1, or a
            function of q_x and q_y that returns it; between directions ln G is a trigonometric polynomial. An array
            [n, 2] or [n, 3] has the rows of a table, (q, G) or (q_x, q_y, G).
        uniform_compliance: compliance of the mean level for a body with `compliance`, length / stress; None for a fixed
            mean level, as on a half-space.

    `e_star` is the contact modulus in p*: E* of the top layer, or 1/(1/E1* + 1/E2*) with a second body. `young` and
    `poisson` belong to the top layer.

    Raises:
        InputError: a value out of range.

    Example:
        >>> gfmd.Body(young=70e9, poisson=0.33).e_star
        78554595443.83347
        >>> gfmd.Body(height=0.1, layers=[(3.0, 0.3, 0.2)], base="sliding").layers
        ((3.0, 0.3, 0.2),)
        >>> gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)]).prony
        ((0.1, 0.3), (10.0, 0.4))
        >>> gfmd.Body(young="210 GPa", poisson=0.3, yield_stress="500 MPa", hardening="2 GPa").yield_stress
        '500 MPa'
        >>> graded = gfmd.Body(e_star=1.0, compliance=(np.geomspace(1, 1000, 200), lambda q: 2 / q * (1 + 1 / q)))
        >>> gfmd.contact(gfmd.self_affine(n=64), graded, p_star=0.05).converged
        True
        >>> stiffer = lambda x, y: 2 / np.hypot(4 * x, y)
        >>> fibres = gfmd.Body(e_star=1.0, compliance=(np.geomspace(1, 1000, 10), 16, stiffer))
        >>> gfmd.contact(gfmd.self_affine(n=64), fibres, p_star=0.05).converged
        True
    """

    young: float
    poisson: float
    e_star: float
    height: Optional[Quantity]
    base: str
    layers: tuple[tuple[Quantity, ...], ...]
    second_body: Optional[tuple[Quantity, ...]]
    prony: tuple[tuple[Quantity, float], ...]
    moduli: str
    relaxes: str
    yield_stress: Quantity
    hardening: Optional[Quantity]
    hardening_curve: tuple[tuple[Quantity, ...], ...]
    kinematic_hardening: Optional[Quantity]
    layer_yield: tuple[Quantity, ...]
    material: str
    second_material: str
    _given: tuple[Optional[Quantity], float, Optional[Quantity], Optional[Quantity]]

    @hinted
    def __init__(
        self,
        young: Optional[Quantity] = None,
        poisson: float = 0.0,
        *,
        e_star: Optional[Quantity] = None,
        height: Optional[Quantity] = None,
        base: _Base | str = "bonded",
        base_young: Optional[Quantity] = None,
        base_poisson: Optional[float] = None,
        layers: Sequence[Sequence[Quantity]] = (),
        second_body: Optional[Sequence[Quantity]] = None,
        prony: Sequence[Sequence[Quantity]] | Fitted = (),
        moduli: Literal["long-term", "instantaneous"] | str = "long-term",
        relaxes: Literal["both", "shear"] | str = "both",
        yield_stress: Optional[Quantity] = None,
        hardening: Optional[Quantity] = None,
        hardening_curve: Sequence[Sequence[Quantity]] = (),
        kinematic_hardening: Optional[Quantity] = None,
        layer_yield: Sequence[Quantity] = (),
        compliance: Optional[_Compliance] = None,
        uniform_compliance: Optional[float] = None,
        material: Optional[str] = None,
        second_material: Optional[str] = None,
    ) -> None:
        if material is not None:
            chosen = Material.named(material)
            for replaced, own in (("young", young), ("e_star", e_star), ("poisson", poisson or None)):
                if own is not None:
                    raise InputError(
                        f"material is {material}; it must be given without {replaced}: it has a modulus and a Poisson's"
                        " ratio"
                    )
            young, poisson = chosen["young"], chosen["poisson"]
            material = chosen.recorded
        if isinstance(prony, Fitted):
            if young is None and e_star is None:
                if moduli == "instantaneous":
                    raise InputError(
                        "young is missing; it is needed with moduli 'instantaneous': a fit has the fully relaxed one"
                    )
                young = prony.young
            prony = prony.series
        if second_material is not None:
            other = Material.named(second_material, option="second_material")
            if second_body is not None:
                raise InputError(
                    f"second_material is {second_material}; it must be given without second_body: it has a modulus and"
                    " a Poisson's ratio"
                )
            second_body, second_material = (other["young"], other["poisson"]), other.recorded
        if young is not None and e_star is not None:
            raise InputError("young and e_star are both given; give one of the two")
        nu = _ratio("poisson", poisson)
        modulus, contact = _modulus("young", young), _modulus("e_star", e_star)
        thickness = None if height is None else quantity("height", height)
        if thickness is not None and not in_units("height", thickness) > 0.0:
            raise InputError(f"height is {thickness}; it must be positive, or None for a half-space")
        thickness = None if thickness == math.inf else thickness
        if contact is None:
            contact_modulus = (1.0 if modulus is None else modulus) / ((1.0 - nu) * (1.0 + nu))
        else:
            contact_modulus = contact
        second = (
            None
            if second_body is None
            else _sheet("second_body", second_body, "(young, poisson) or (young, poisson, height)", (2, 3))
        )
        values = {
            "young": modulus if modulus is not None else 1.0 if contact is None else contact_modulus * (1.0 - nu * nu),
            "poisson": nu,
            "e_star": contact_modulus if second is None else _composite(contact_modulus, second),
            "height": thickness,
            "base": word("base", base),
            "layers": _layers(layers, thickness),
            "second_body": second,
            **_relaxation(prony, word("moduli", moduli), word("relaxes", relaxes)),
        }
        plasticity = _plasticity(yield_stress, hardening, hardening_curve, kinematic_hardening, layer_yield)
        table = _compliance(compliance, uniform_compliance)
        if table and (modulus is None and contact is None):
            raise InputError("young or e_star is missing; p* is over E*, which a table of compliances does not have")
        if table:
            others = (
                ("poisson", nu, 0.0),
                ("height", thickness, None),
                ("base", base, "bonded"),
                ("second_body", second, None),
                ("prony", tuple(prony), ()),
                ("yield_stress", yield_stress, None),
            )
            for name, found, default in others:
                if found != default:
                    raise InputError(
                        f"{name} is {shown(found)}; it must be left out with compliance, which is that of the whole"
                        " body"
                    )
        names = {"material": material, "second_material": second_material}
        known = {key: name for key, name in names.items() if name is not None}
        super().__init__(
            {**values, **known, **_below(base, thickness, base_young, base_poisson), **plasticity, **table}
        )
        given = (
            found if not isinstance(asked, str) else asked for asked, found in ((young, modulus), (e_star, contact))
        )
        first, second_given = given
        object.__setattr__(self, "_given", (first, nu, second_given, thickness))

    def __reduce__(self) -> tuple[Any, ...]:
        modulus, nu, contact, thickness = self._given
        below = self._values.get("base_young"), self._values.get("base_poisson")
        top = (None if contact is not None else modulus, nu, contact, thickness)
        relaxation = self.prony, self.moduli, self.relaxes
        plasticity = {name: self._values[name] for name in _PLASTICITY if name in self._values}
        table = self._values.get("compliance"), self._values.get("uniform_compliance")
        return _body, (
            *top,
            self.base,
            *below,
            self.layers,
            self.second_body,
            *relaxation,
            *table,
            tuple(plasticity.items()),
            self._values.get("material"),
            self._values.get("second_material"),
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._same() == self._same()

    def __hash__(self) -> int:
        return hash(self._same())

    def _same(self) -> tuple[Any, ...]:
        """Returns the arguments, including the default modulus."""
        young, *others = self.__reduce__()[1]
        return 1.0 if young is None and self._given[2] is None else young, *others


def _modulus(name: str, value: object) -> Optional[float]:
    found = None if value is None else in_units(name, value, "stress")
    if found is not None and not 0.0 < found < math.inf:
        written = value if isinstance(value, str) else found
        raise InputError(f"{name} is {written}; it must be positive and finite")
    return found


def _ratio(name: str, value: object) -> float:
    found = number(name, value)
    if not -1.0 < found <= 0.5:
        raise InputError(f"{name} is {found}; it must be above -1 and at most 0.5")
    return found


def _sheet(name: str, value: object, form: str, lengths: tuple[int, ...]) -> tuple[Quantity, ...]:
    """Checks (Young's modulus, Poisson's ratio[, height]) of a half-space, a layer or a slab."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence) or len(value) not in lengths:
        raise InputError(f"{name} is {shown(value)}; it must be {form}")
    found = [quantity(name, entry, kind) for entry, kind in zip(value, KINDS["layers"])]
    _modulus(f"young of {name}", found[0])
    _ratio(f"poisson of {name}", found[1])
    if len(found) == 3 and not 0.0 < in_units(name, found[2], "length") < math.inf:
        raise InputError(f"height of {name} is {found[2]}; it must be positive and finite")
    return tuple(found)


def _layers(value: object, height: Optional[Quantity]) -> tuple[tuple[Quantity, ...], ...]:
    form = "a list of (young, poisson, height)"
    if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
        raise InputError(f"layers is {shown(value)}; it must be {form}")
    if value and height is None:
        raise InputError(f"layers is {shown(value)}; it must be left out for a half-space, below which nothing lies")
    return tuple(_sheet("layers", layer, form, (3,)) for layer in value)


def _relaxation(prony: object, moduli: str, relaxes: str) -> dict[str, Any]:
    """Checks the Prony branches of a body; an elastic body has none."""
    form = "a list of (relaxation time, fraction of the instantaneous modulus)"
    if isinstance(prony, (str, bytes)) or not isinstance(prony, Sequence):
        raise InputError(f"prony is {shown(prony)}; it must be {form}")
    branches = []
    for branch in prony:
        if isinstance(branch, (str, bytes)) or not isinstance(branch, Sequence) or len(branch) != 2:
            raise InputError(f"prony has the branch {shown(branch)}; it must be {form}")
        given, fraction = quantity("prony", branch[0]), number("prony", branch[1])
        time = in_units("prony", given)
        if not 0.0 < time < math.inf:
            raise InputError(f"a relaxation time of prony is {given}; it must be positive and finite")
        if not 0.0 < fraction < 1.0:
            raise InputError(f"a fraction of prony is {fraction}; it must be above 0 and below 1")
        branches.append((given, fraction))
    if len({in_units("prony", time) for time, _ in branches}) < len(branches):
        raise InputError(f"prony is {shown(prony)}; its relaxation times must differ")
    if not sum(fraction for _, fraction in branches) < 1.0:
        raise InputError(f"prony is {shown(prony)}; its fractions must add up to less than 1")
    for name, value, allowed in (
        ("moduli", moduli, ("long-term", "instantaneous")),
        ("relaxes", relaxes, ("both", "shear")),
    ):
        if value not in allowed:
            raise InputError(f"{name} is {value!r}; it must be {allowed[0]!r} or {allowed[1]!r}")
        if value != allowed[0] and not branches:
            raise InputError(f"{name} is {value!r}; it must be left out without prony")
    return {"prony": tuple(branches), "moduli": moduli, "relaxes": relaxes}


_PLASTICITY = ("yield_stress", "hardening", "hardening_curve", "kinematic_hardening", "layer_yield")


def _plasticity(stress: object, slope: object, curve: object, kinematic: object, layers: object) -> dict[str, Any]:
    """Returns the yield stress and hardening of a body; empty for a body that does not yield."""
    listed = []
    for name, value in (("hardening_curve", curve), ("layer_yield", layers)):
        if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)):
            raise InputError(f"{name} is {shown(value)}; it must be a list")
        listed.append(list(value))
    for point in listed[0]:
        if isinstance(point, (str, bytes)) or not isinstance(point, (Sequence, np.ndarray)) or len(point) != 2:
            raise InputError(f"hardening_curve has the point {shown(point)}; it must be (plastic strain, yield stress)")
    given = {
        "yield_stress": None if stress is None else quantity("yield_stress", stress),
        "hardening": None if slope is None else quantity("hardening", slope),
        "hardening_curve": tuple(
            (number("hardening_curve", strain), quantity("hardening_curve", found, kind_of("hardening_curve", 1)))
            for strain, found in listed[0]
        ),
        "kinematic_hardening": None if kinematic is None else quantity("kinematic_hardening", kinematic),
        "layer_yield": tuple(quantity("layer_yield", found) for found in listed[1]),
    }
    if stress is None:
        for name, value in given.items():
            if value not in (None, ()):
                raise InputError(f"{name} is given; it must be left out without yield_stress")
        return {}
    _modulus("yield_stress", given["yield_stress"])
    if given["hardening_curve"] and slope is not None:
        raise InputError("hardening and hardening_curve are both given; give one of the two")
    return given


def _compliance(given: object, uniform: object) -> dict[str, Any]:
    """Returns the rows of a compliance table and the uniform compliance; empty without a table."""
    if given is None:
        if uniform is not None:
            raise InputError(f"uniform_compliance is {shown(uniform)}; it must be left out without compliance")
        return {}
    if isinstance(given, np.ndarray) and given.ndim == 2 and given.shape[1] in (2, 3):
        return _rows([tuple(row) for row in array("compliance", given).tolist()], uniform)
    if isinstance(given, (str, bytes)) or not isinstance(given, Sequence) or len(given) not in (2, 3):
        form = (
            "an array of rows, (wavenumbers, compliances or a function of the wavenumber), or "
            "(wavenumbers, number of directions, compliances or a function of q_x and q_y)"
        )
        raise InputError(f"compliance is {shown(given)}; it must be {form}")
    waves = array("wavenumbers of compliance", given[0])
    if waves.ndim != 1:
        raise InputError(f"wavenumbers of compliance has the shape {list(waves.shape)}; it must be [n]")
    vectors = [waves] if len(given) == 2 else _vectors(waves, integer("directions of compliance", given[1], 4, 1000))
    found = array("compliance", given[-1](*(part.copy() for part in vectors)) if callable(given[-1]) else given[-1])
    if found.shape != vectors[0].shape:
        raise InputError(
            f"compliance has the shape {list(found.shape)} at wave vectors of the shape {list(vectors[0].shape)}; it"
            " must be the same"
        )
    return _rows([tuple(row) for row in np.stack([*vectors, found], axis=-1).reshape(-1, len(given)).tolist()], uniform)


def _vectors(waves: Array, directions: int) -> list[Array]:
    """Returns the x and y components of wave vectors [wavenumber, direction]."""
    angles = np.pi * np.arange(directions) / directions
    return [waves[:, None] * np.cos(angles), waves[:, None] * np.sin(angles)]


def _rows(rows: list[tuple[float, ...]], uniform: object) -> dict[str, Any]:
    level = None if uniform is None else number("uniform_compliance", uniform)
    _gfmd.check_compliance([list(row) for row in rows], 0.0 if level is None else level)
    return {"compliance": tuple(rows), "uniform_compliance": level}


def _composite(first: float, other: tuple[Quantity, ...]) -> float:
    """Returns the composite contact modulus of two bodies, with the same arithmetic as the program."""
    young, poisson = in_units("second_body", other[0]), number("second_body", other[1])
    small, large = sorted((first, young / ((1.0 - poisson) * (1.0 + poisson))))
    return small / (1.0 + small / large)


def _below(base: str, height: Optional[Quantity], young: object, poisson: object) -> dict[str, Quantity]:
    """Returns the moduli of an elastic base."""
    if base not in get_args(_Base):
        raise InputError(f"base is {base!r}; it must be one of {', '.join(map(repr, get_args(_Base)))}")
    if height is None and base != "bonded":
        raise InputError(f"base is {base!r}; it must be 'bonded' for a half-space, which has no base")
    if base != "half-space":
        for name, value in (("base_young", young), ("base_poisson", poisson)):
            if value is not None:
                raise InputError(f"{name} is {value!r}; it must be left out unless base is 'half-space'")
        return {}
    modulus = _modulus("base_young", young)
    if modulus is None or poisson is None:
        raise InputError(
            f"{'base_young' if modulus is None else 'base_poisson'} is missing; it is needed if base is 'half-space'"
        )
    return {"base_young": young if isinstance(young, str) else modulus, "base_poisson": _ratio("base_poisson", poisson)}


def _body(
    young: Optional[Quantity],
    poisson: float,
    e_star: Optional[Quantity],
    height: Optional[Quantity],
    base: str = "bonded",
    base_young: Optional[Quantity] = None,
    base_poisson: Optional[float] = None,
    layers: Sequence[Sequence[Quantity]] = (),
    second_body: Optional[Sequence[Quantity]] = None,
    prony: Sequence[Sequence[Quantity]] = (),
    moduli: str = "long-term",
    relaxes: str = "both",
    compliance: Optional[Sequence[Sequence[float]]] = None,
    uniform_compliance: Optional[float] = None,
    plasticity: Sequence[tuple[str, Any]] = (),
    material: Optional[str] = None,
    second_material: Optional[str] = None,
) -> Body:
    below = {"base": base, "base_young": base_young, "base_poisson": base_poisson, "layers": layers}
    table = None if compliance is None else np.array(compliance, dtype=np.float64)
    relaxation = {
        "prony": prony,
        "moduli": moduli,
        "relaxes": relaxes,
        "compliance": table,
        "uniform_compliance": uniform_compliance,
    }
    options: dict[str, Any] = {**below, **relaxation, **dict(plasticity)}
    body = Body(young, poisson, e_star=e_star, height=height, second_body=second_body, **options)
    names = {"material": material, "second_material": second_material}
    body._values.update({key: name for key, name in names.items() if name is not None})
    return body


# Keys of a configuration that only a body with them has.
_RECORDED = ("compliance", "uniform_compliance", "material", "second_material")


def body_of(config: dict[str, Any]) -> Body:
    """Returns the body in a configuration."""
    e_star, height = config.get("e_star"), config.get("height", "inf")
    below: dict[str, Any] = {name: config.get(name) for name in ("base_young", "base_poisson", "second_body")}
    young = None if e_star is not None else config.get("young")
    top = (young, config.get("poisson", 0.0), e_star, None if height == "inf" else height)
    below.update({name: config.get(name) for name in _RECORDED})
    return _body(*top, config.get("base", "bonded"), layers=config.get("layer", ()), **below)


def law_of(config: dict[str, Any]) -> Law:
    """Returns the law in a configuration."""
    parameters = {key: math.nan if value is None else value for key, value in config.get("param", [])}
    return Law(config.get("law", "hard-wall"), parameters, config.get("law_table", ()))


_PARAMETERS: dict[str, str] = dict(_gfmd.law_kinds())


class Law(Record):
    """A law of adhesion or cohesion across the gap, with `name` and its parameters as attributes. See `gfmd.law`.

    Raises:
        InputError: as in `gfmd.law`.

    Example:
        >>> gfmd.law("dugdale", gamma=1e-4, range=2e-3).parameters
        {'gamma': 0.0001, 'range': 0.002}
    """

    name: str

    def __init__(self, name: str, parameters: dict[str, Quantity], table: Sequence[Sequence[Quantity]] = ()) -> None:
        rows = {"table": tuple((gap, traction) for gap, traction in table)} if table else {}
        super().__init__({"name": name, **parameters, **rows})
        _gfmd.check_law(name, self._plain(), self._rows())

    def _plain(self) -> list[tuple[str, float]]:
        """Returns the parameters as numbers."""
        return [(key, in_units(key, value, _PARAMETERS.get(key, "1"))) for key, value in self.parameters.items()]

    def _rows(self) -> list[tuple[float, float]]:
        """Returns the table as numbers."""
        return [
            (in_units("gap", gap, "length"), in_units("traction", traction, "stress")) for gap, traction in self.table
        ]

    @property
    def parameters(self) -> dict[str, Quantity]:
        """Parameters by name, in the units of `gfmd.law`; empty for a law from a table."""
        return {name: value for name, value in self._values.items() if name not in ("name", "table")}

    @property
    def table(self) -> tuple[tuple[Quantity, Quantity], ...]:
        """Rows (gap, traction) of a table, length and stress, shape [rows, 2]; empty for a law with parameters."""
        rows: tuple[tuple[Quantity, Quantity], ...] = self._values.get("table", ())
        return rows

    def traction(self, gap: npt.ArrayLike) -> Array:
        """Returns the normal traction without sliding, positive where it attracts.

        Args:
            gap: gaps, length, a number or an array of any shape; in m if the parameters are strings with units.

        Returns:
            Tractions, stress, in the shape of the gaps; in Pa if the parameters are strings with units.

        Raises:
            InputError: gaps that are not numbers.

        Example:
            >>> gfmd.law("dugdale", gamma=1.0, range=0.5).traction([0.0, 0.4, 0.6])
            array([2., 2., 0.])
        """
        gaps = array("gap", gap)
        found = _gfmd.law_traction(self.name, self._plain(), self._rows(), gaps.ravel().tolist())
        return np.asarray(found, dtype=np.float64).reshape(gaps.shape)

    def __reduce__(self) -> tuple[Any, ...]:
        return Law, (self.name, self.parameters, self.table)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and other._values == self._values

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))


def law(
    name: Union[str, npt.ArrayLike],
    traction: Union[npt.ArrayLike, Callable[[Array], npt.ArrayLike], None] = None,
    /,
    *,
    units: Optional[tuple[str, str]] = None,
    **parameters: Quantity,
) -> Law:
    """Creates a law of adhesion or cohesion, from its name and parameters or from a table.

    Args:
        name: "hard-wall"; "morse", "exponential", "dugdale" (`gamma`, `range`); "harmonic-cosine" (`gamma`,
            `curvature`); "xu-needleman", "bsg", "c3d", "npb", "npc" (`phi_n`, `phi_t`, `delta_n`, `delta_t`; the first
            also `r`); or the gaps of a table, length, in ascending order: at least four, starting at 0 (with a hard
            wall there) or at a negative gap (where the traction repels).
        traction: for a table, the traction at each gap, stress, positive where it attracts, and 0 at the last gap; or a
            function that returns the tractions at an array of gaps. The function is sampled at the gaps; if it deviates
            from the law between them by more than 1 % of its largest value, that is an error.
        units: for a table, units of gaps and tractions, such as ("nm", "MPa"); by default the units of the problem.
        parameters: gamma and phi in stress * length, range and delta in length, curvature in stress/length, r without
            unit; or strings with a unit, such as gamma="0.05 J/m^2", range="2 nm".

    Raises:
        InputError: an unknown name or parameter, a missing parameter, a value out of range, an invalid table.

    Example:
        >>> gfmd.law("morse", gamma=2e-4, range=1.2e-3).range
        0.0012
        >>> gaps = np.linspace(0.0, 1.0, 101)
        >>> gfmd.law(gaps, lambda gap: (1.0 - gap) ** 2).traction(0.305).round(3)
        np.float64(0.483)
    """
    if not isinstance(name, str):
        if parameters:
            raise InputError(f"{next(iter(parameters))} is given; it must be left out of a table")
        return _tabulated(name, traction, units)
    if traction is not None or units is not None:
        raise InputError(
            f"{'traction' if units is None else 'units'} is given; it must be left out of the law {name!r}, which has a"
            " name"
        )
    return Law(
        word("law", name), {key: quantity(key, value, _PARAMETERS.get(key, "1")) for key, value in parameters.items()}
    )


# Largest relative deviation of a function from its table.
_DEVIATION = 0.01


def _tabulated(gap: Any, traction: Any, units: Optional[tuple[str, str]]) -> Law:
    """Creates a law from a table or a sampled function."""
    gaps = array("gap", gap)
    if gaps.ndim != 1:
        raise InputError(f"gap has the shape {list(gaps.shape)}; it must have one dimension")
    found = _sampled(traction, gaps) if callable(traction) else array("traction", traction)
    if found.shape != gaps.shape:
        raise InputError(
            f"traction has the shape {list(found.shape)}; it must be {list(gaps.shape)}, the shape of the gaps"
        )
    rows: list[tuple[Quantity, Quantity]] = list(zip(gaps.tolist(), found.tolist()))
    plain = Law("table", {}, rows)
    if callable(traction):
        middle = 0.5 * (gaps[1:] + gaps[:-1])
        off, most = np.abs(plain.traction(middle) - _sampled(traction, middle)), _DEVIATION * np.abs(found).max()
        if not off.max() <= most:
            at = float(middle[int(np.argmax(off))])
            raise InputError(
                f"traction deviates by {float(off.max()):.1e} from its table at the gap {at:.3g}; it must be at most"
                f" {most:.1e}, which closer gaps make it"
            )
    if units is None:
        return plain
    first, second = (word("units", unit) for unit in units)
    return Law("table", {}, [(f"{gap!r} {first}", f"{value!r} {second}") for gap, value in rows])


def _sampled(traction: Callable[[Array], npt.ArrayLike], gaps: Array) -> Array:
    found = array("traction", traction(gaps.copy()))
    return np.broadcast_to(found, gaps.shape) if found.shape == () else found


def as_law(value: object) -> Law:
    if value is None:
        return Law("hard-wall", {})
    if isinstance(value, str):
        return Law(value, {})
    if isinstance(value, Law):
        return value
    raise InputError(f"law is {shown(value)}; it must be made by gfmd.law, or a name")


def as_body(value: object, in_time: bool = False, of_moduli: bool = False, yields: bool = False) -> Body:
    if not isinstance(value, Body):
        raise InputError(f"body is {type(value).__name__}; it must be a gfmd.Body")
    if of_moduli and "compliance" in value:
        raise InputError(
            "body has a compliance; it must be given by its moduli here, since a table has no fields inside and no"
            " shear"
        )
    if "yield_stress" in value and not yields:
        raise InputError("body yields; it must be elastic here (gfmd.path follows one that yields, step by step)")
    if value.prony and not in_time:
        raise InputError("body is viscoelastic; it must be elastic here (gfmd.path follows a viscoelastic one in time)")
    return value
