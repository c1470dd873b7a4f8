"""Papers behind the methods of a result."""

from __future__ import annotations

from typing import Any

from . import _gfmd

_PROGRAM = f"gfmd {_gfmd.VERSION}, contact mechanics of rough surfaces by Green's function molecular dynamics (CITATION.cff)."
_SOLVERS = {
    "cg": "Polonsky and Keer, Wear 231 (1999) 206: constrained conjugate gradients.",
    "fire": "Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201: FIRE.",
    "fire2": "Guénolé et al., Comput. Mater. Sci. 175 (2020) 109584: FIRE 2.0.",
}
_LAWS = {
    "xu-needleman": "Xu and Needleman, Modelling Simul. Mater. Sci. Eng. 1 (1993) 111.",
    "bsg": "van den Bosch, Schreurs and Geers, Eng. Fract. Mech. 73 (2006) 1220.",
    "dugdale": "Dugdale, J. Mech. Phys. Solids 8 (1960) 100.",
}


def cite(*results: Any) -> str:
    """The text to cite for the methods of these results, a line each.

    Example:
        >>> print(gfmd.cite(c))
    """
    lines = [_PROGRAM]
    for result in results:
        for one in result if hasattr(result, "_contacts") else [result]:
            settings: Any = getattr(one, "_settings", None)
            law: Any = getattr(one, "law", None)
            if settings is not None:
                lines.append("Campañá and Müser, Phys. Rev. B 74 (2006) 075420: Green's function molecular dynamics.")
                lines.append("Yastrebov, Anciaux and Molinari, Tribol. Int. 114 (2017) 161: area corrected for its perimeter.")
                lines.append(_SOLVERS.get(settings[0], ""))
            if hasattr(law, "name"):
                lines.append(_LAWS.get(law.name, ""))
    return "\n".join(dict.fromkeys(line for line in lines if line))
