"""References for the methods behind a result."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from . import _gfmd
from ._below import FieldsBelow, Green, Punch
from ._check import shown
from ._contact import Contact, Contacts
from ._errors import InputError
from ._kappa import KappaSweep
from ._path import Path
from ._study import Study

_PROGRAM = (
    f"gfmd {_gfmd.VERSION}, contact mechanics of rough surfaces by Green's function molecular dynamics (CITATION.cff)."
)
_METHOD = "Campañá and Müser, Phys. Rev. B 74 (2006) 075420: Green's function molecular dynamics."
_AREA = "Yastrebov, Anciaux and Molinari, Tribol. Int. 114 (2017) 161: area corrected for its perimeter."
_LIMIT = "Prodanov, Dapp and Müser, Tribol. Lett. 53 (2014) 433: the three limits of kappa."
_CONJUGATE = "Polonsky and Keer, Wear 231 (1999) 206: constrained conjugate gradients."
_SOLVERS = {
    "auto": _CONJUGATE,
    "cg": _CONJUGATE,
    "projected-cg": _CONJUGATE,
    "preconditioned-cg": _CONJUGATE,
    "fire": "Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201: FIRE.",
    "fire2": "Guénolé et al., Comput. Mater. Sci. 175 (2020) 109584: FIRE 2.0.",
}
_LAWS = {
    "xu-needleman": "Xu and Needleman, Modelling Simul. Mater. Sci. Eng. 1 (1993) 111.",
    "bsg": "van den Bosch, Schreurs and Geers, Eng. Fract. Mech. 73 (2006) 1220.",
    "dugdale": "Dugdale, J. Mech. Phys. Solids 8 (1960) 100.",
}


def cite(*results: Any) -> str:
    """Returns the references for the methods behind these results, one per line.

    Args:
        results: contacts, paths, punches, fields below a surface, sweeps.

    Raises:
        InputError: an object that is not a result.

    Example:
        >>> "Polonsky" in gfmd.cite(c)
        True
    """
    lines = [_PROGRAM, *(line for result in results for line in _of(result))]
    return "\n".join(dict.fromkeys(line for line in lines if line))


def _of(result: Any) -> Iterator[str]:
    if isinstance(result, Contacts):
        for contact in result:
            yield from _of(contact)
    elif isinstance(result, Contact):
        yield _METHOD
        yield _AREA
        wall = result.law.name == "hard-wall"
        solver = result._settings.description["solver"]
        yield _SOLVERS.get(solver, "") if wall or solver != "auto" else ""
        yield _LAWS.get(result.law.name, "")
    elif isinstance(result, Path):
        yield _METHOD
        yield _LAWS.get(result.law, "")
    elif isinstance(result, KappaSweep):
        yield from (_METHOD, _LIMIT, _AREA, _CONJUGATE)
    elif isinstance(result, (Punch, FieldsBelow, Green, Study)):
        yield _METHOD
    else:
        raise InputError(f"the result is {shown(result)}; it must be one of this package")
