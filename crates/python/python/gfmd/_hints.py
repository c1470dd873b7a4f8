"""Hints that suggest the right name for a wrong one."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any, Optional, TypeVar, cast

_Function = TypeVar("_Function", bound=Callable[..., Any])

# Other names of arguments; the first word of a key is the argument.
_ARGUMENTS = {
    "poisson": ("nu", "poisson_ratio", "poissons_ratio", "v"),
    "young": ("E", "e", "youngs_modulus", "young_modulus", "modulus", "elastic_modulus"),
    "e_star": ("E_star", "Estar", "estar", "contact_modulus", "E_s"),
    "height": ("thickness",),
    "pressure": ("mean_pressure", "p", "nominal_pressure", "stress", "external_pressure"),
    "force": ("load", "normal_force", "external_force", "weight"),
    "p_star": ("reduced_pressure", "pstar"),
    "approach": ("displacement", "indentation", "penetration", "offset"),
    "rms_gradient": ("rms_slope", "hrms_prime", "slope", "hprime_rms"),
    "rms_height": ("rms", "hrms", "sq", "h_rms"),
    "hurst": ("H", "hurst_exponent", "h"),
    "size": ("length", "physical_sizes", "physical_size", "system_size", "L", "lengths"),
    "n": ("points", "shape", "grid", "resolution", "nb_grid_pts", "N"),
    "eps_t_inv": ("roll_off", "rolloff", "q0", "qr"),
    "tolerance": ("tol", "rtol", "gtol", "f_tol"),
    "max_iterations": ("max_iter", "maxiter", "iterations"),
    "velocity": ("speed", "velocities"),
    "unit": ("units", "length_unit"),
    "seed": ("random_state", "rng"),
    "gamma": ("work_of_adhesion", "surface_energy", "w"),
    "detrend": ("plane", "level"),
    "law": ("adhesion", "interaction", "potential"),
    "boundary": ("periodic", "bc"),
    "heat": ("thermal",),
    "out": ("output", "file"),
}

# Other names of attributes.
_ATTRIBUTES = {
    "pressure": ("traction", "tractions", "stress", "p", "pressures", "forces", "sigma"),
    "area_fraction": ("area", "contact_area", "relative_area", "fractional_area", "contact_fraction", "A"),
    "touching": ("contact", "mask", "in_contact", "contact_map", "contacting_points"),
    "displacement_z": ("displacements", "deformation", "u", "uz", "u_z", "disp"),
    "approach": ("displacement", "indentation", "penetration", "offset", "depth"),
    "mean_pressure times the area of the surface": ("force", "load", "normal_force", "total_force"),
    "gap": ("gaps", "separation", "interfacial_gap"),
    "mean_gap": ("mean_separation", "average_gap"),
    "max_pressure": ("peak_pressure", "pmax", "p_max", "maximum_pressure"),
    "elastic_energy": ("energy",),
    "stiffness": ("contact_stiffness", "normal_stiffness"),
    "surface.heights": ("heights", "height", "topography"),
    "heights": ("data", "values", "z", "h", "array", "map"),
    "size": ("length", "lengths", "physical_sizes", "L"),
    "n": ("shape", "nb_grid_pts", "points"),
    "rms_gradient": ("rms_slope", "slope", "hrms_prime"),
    "rms_height": ("rms", "Sq", "sq", "hrms"),
    "states": ("steps", "loads"),
    "steps": ("loads", "states", "history"),
    "leak_rate(viscosity=..., pressure_drop=...)": ("rate", "leak", "leakage", "flow_rate", "leakrate"),
    "to_dataframe()": ("dataframe", "df", "to_pandas", "to_csv"),
    "to_xarray()": ("xarray", "dataset", "to_dataset"),
    "save(path)": ("write", "to_hdf5", "to_file", "dump"),
    "report(path)": ("to_html", "page"),
    "units": ("stress_unit",),
    "figures()": ("plots", "svg"),
}

# Arguments of another function.
_ELSEWHERE = {
    "viscosity": "leak_rate(viscosity=..., pressure_drop=...) takes it",
    "gas": "gas_conductance('air') of the contact takes it",
    "pressure_drop": "leak_rate(viscosity=..., pressure_drop=...) takes it",
}


def _first(text: str) -> str:
    """Returns the first name in a hint."""
    return text.replace("(", " ").replace(",", " ").replace(".", " ").split()[0]


def _known(name: str, names: dict[str, tuple[str, ...]], allowed: Iterable[str]) -> Optional[str]:
    """Returns a replacement for a name; None if none is similar."""
    there = set(allowed)
    for right, others in names.items():
        if name in others and _first(right) in there:
            return right
    like = difflib.get_close_matches(name, [other for other in there if not other.startswith("_")], 1, 0.75)
    return like[0] if like else None


def argument(name: str, allowed: Iterable[str]) -> str:
    """Returns the end of a message about an unknown argument: a replacement, or all allowed names."""
    names = list(allowed)
    if name in _ELSEWHERE:
        return _ELSEWHERE[name]
    if not names:
        return "it takes none"
    right = _known(name, _ARGUMENTS, names)
    return f"it must be one of {', '.join(names)}" if right is None else f"write {right}"


def attribute(name: str, allowed: Iterable[str]) -> str:
    """Returns the end of a message about an unknown attribute: a replacement, if known."""
    there = set(allowed)
    if name in ("rate", "leak_rate") and "transmissivity" in there:
        return "; write leak_rate(viscosity=..., pressure_drop=...) of the contact"
    right = _known(name, _ATTRIBUTES, there)
    return "" if right is None else f"; write {right}"


def hinted(function: _Function) -> _Function:
    """Decorates a function to suggest the right name for an unknown argument."""
    parameters = inspect.signature(function).parameters
    names = [name for name, of in parameters.items() if name != "self" and of.kind is not of.POSITIONAL_ONLY]
    takes_more = any(of.kind is of.VAR_KEYWORD for of in parameters.values())
    called = function.__qualname__.replace(".__init__", "")

    @functools.wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        for name in () if takes_more else options:
            if name not in names:
                raise TypeError(f"{called} has no argument {name!r}; {argument(name, names)}")
        return function(*arguments, **options)

    return cast(_Function, checked)
