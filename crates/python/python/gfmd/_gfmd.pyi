from collections.abc import Callable
from typing import Any, Optional, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "FileDraft",
    "GIT_COMMIT",
    "Problem",
    "State",
    "StoredFile",
    "VERSION",
    "adhesion",
    "canonical",
    "check_compliance",
    "check_law",
    "composite",
    "conductance",
    "gas_conductance",
    "gas_in_gap",
    "converted",
    "detrend",
    "even",
    "figures",
    "fill",
    "finer",
    "fluids",
    "in_units",
    "kinds",
    "law_kinds",
    "law_text",
    "materials",
    "law_traction",
    "option_kinds",
    "options",
    "path_vjp",
    "periodise",
    "prepared",
    "program",
    "psd",
    "read",
    "readable",
    "save",
    "self_affine",
    "solve",
    "statistics",
    "surface_report",
    "texture",
    "unit_name",
    "write_file",
    "write_page",
    "with_limit",
]
VERSION: str
GIT_COMMIT: str

_Array = npt.NDArray[np.float64]
_Tick = Optional[Callable[[str, int, int], None]]

@final
class FileDraft:
    def write(self, path: str, fields: dict[str, _Array]) -> None: ...

@final
class StoredFile:
    path: str
    kind: Optional[str]
    def __new__(cls, path: str) -> StoredFile: ...
    def check(self) -> None: ...
    def array(self, name: str) -> _Array: ...
    def cell(self, group: str) -> tuple[tuple[float, float], Optional[str]]: ...
    def text(self, group: str, name: str) -> str: ...
    def bytes(self) -> bytes: ...
    def config(self) -> str: ...
    def records(self) -> tuple[list[str], list[str]]: ...
    def report(self) -> tuple[str, list[str]]: ...

@final
class State:
    fields: list[tuple[str, _Array]]
    def times(self, accuracy: str) -> int: ...

@final
class Problem:
    description: str
    stress_unit: Optional[str]
    def __new__(cls, problem: dict[str, Any], arrays: dict[str, _Array], threads: int) -> Problem: ...
    def solve(
        self, control: str, value: float, start: Optional[State], threads: int, tick: _Tick
    ) -> tuple[State, str, Optional[tuple[str, str]], Optional[BaseException]]: ...
    def check_accuracy(self, accuracy: str, control: str) -> None: ...
    def slopes(self, largest: float) -> Optional[str]: ...
    def strain(self, approach: float) -> Optional[str]: ...
    def value(self, name: str, text: str, kind: str) -> float: ...
    def unit_warnings(self, control: str, largest: float) -> list[str]: ...
    def measure(self, state: State, options: dict[str, Any]) -> tuple[str, list[dict[str, Any]]]: ...
    def vjp(
        self, state: State, is_driven: bool, fields: dict[str, _Array], numbers: dict[str, float]
    ) -> tuple[_Array, float, float, Optional[_Array], float]: ...
    def recall(self, fields: dict[str, _Array], approach: float) -> State: ...

def path_vjp(
    problem: dict[str, Any],
    arrays: dict[str, Any],
    fields: dict[str, _Array],
    numbers: dict[str, list[float]],
    threads: int = 0,
    tick: _Tick = None,
) -> dict[str, Any]: ...
def adhesion(problem: dict[str, Any], arrays: dict[str, _Array]) -> str: ...
def conductance(
    touching: npt.NDArray[np.bool_], lengths: tuple[float, float], boundary: str, height: float
) -> float: ...
def gas_in_gap(
    name: str, temperature: Optional[float], pressure: Optional[float], accommodation: Optional[tuple[float, float]]
) -> tuple[float, float]: ...
def gas_conductance(touching: npt.NDArray[np.bool_], gap: _Array, conductivity: float, jump: float) -> float: ...
def check_compliance(table: list[list[float]], uniform: float) -> None: ...
def check_law(name: str, parameters: list[tuple[str, float]], table: list[tuple[float, float]]) -> None: ...
def law_traction(
    name: str, parameters: list[tuple[str, float]], table: list[tuple[float, float]], gaps: list[float]
) -> list[float]: ...
def options() -> list[str]: ...
def in_units(
    name: str, text: str, kind: str, unit: Optional[str] = None, stress: Optional[str] = None
) -> Optional[float]: ...
def canonical(unit: str) -> str: ...
def unit_name(kind: str, unit: Optional[str] = None, stress: Optional[str] = None) -> str: ...
def law_text(realisations: str, unit: Optional[str], stress: Optional[str], format: str) -> str: ...
def with_limit(value: float, limit: float, error: float) -> str: ...
def readable(
    kind: str, largest: float, unit: Optional[str] = None, stress: Optional[str] = None
) -> Optional[tuple[float, str]]: ...
def kinds() -> list[tuple[str, str]]: ...
def option_kinds() -> dict[str, list[str]]: ...
def fluids() -> str: ...
def materials() -> str: ...
def law_kinds() -> list[tuple[str, str]]: ...
def converted(
    heights: _Array, lengths: tuple[float, float], unit: str, to: str
) -> tuple[_Array, tuple[float, float], str]: ...
def psd(heights: _Array, lengths: tuple[float, float], window: str) -> tuple[list[float], list[float]]: ...
def self_affine(
    *,
    n: list[int],
    size: list[float],
    shape: Optional[str],
    unit: Optional[str],
    hurst: Optional[float],
    eps_t_inv: Optional[float],
    eps_f_inv: Optional[float],
    eps_c_inv: Optional[float],
    rms_gradient: Optional[float],
    rms_height: Optional[float],
    seed: int,
    dim: int,
    method: str,
    roll_off: Optional[float],
    roll_off_shape: str,
    amplitudes: str,
    aspect: Optional[float],
    lay: Optional[float],
    marginal: Optional[str],
) -> tuple[_Array, tuple[float, float], str, bool]: ...
def read(
    name: str, channel: Optional[str] = None, image_heights: bool = False
) -> tuple[_Array, Optional[tuple[float, float]], Optional[str], str, str]: ...
def fill(heights: _Array, lengths: tuple[float, float], how: str) -> _Array: ...
def even(places: list[float], heights: list[float], points: Optional[int]) -> tuple[_Array, float]: ...
def detrend(heights: _Array, trend: str) -> _Array: ...
def prepared(
    heights: _Array,
    lengths: tuple[float, float],
    given: tuple[Optional[str], str, str, bool],
    excluded: Optional[npt.NDArray[np.bool_]] = None,
) -> tuple[_Array, tuple[float, float], str, str]: ...
def periodise(heights: _Array, lengths: tuple[float, float], way: str) -> tuple[_Array, tuple[float, float]]: ...
def texture(
    heights: _Array, lengths: tuple[float, float], part: str, repeats: bool
) -> tuple[str, Optional[_Array]]: ...
def surface_report(
    heights: _Array, lengths: tuple[float, float], words: tuple[Optional[str], str], boundary: str, path: str
) -> None: ...
def finer(heights: _Array, lengths: tuple[float, float], times: int) -> _Array: ...
def composite(
    first: _Array, second: _Array, lengths: tuple[float, float], shift: tuple[float, float], boundary: str
) -> tuple[_Array, tuple[float, float]]: ...
def statistics(
    heights: _Array,
    lengths: tuple[float, float],
    fit_range: Any = None,
    section: Optional[float] = None,
    features: Optional[tuple[str, float, Optional[str]]] = None,
) -> str: ...
def solve(
    command: str,
    problem: dict[str, Any],
    arrays: Optional[dict[str, Any]] = None,
    threads: int = 0,
    tick: _Tick = None,
    out: Optional[str] = None,
    words: Optional[str] = None,
) -> tuple[str, Optional[tuple[str, str]], dict[str, _Array], Optional[FileDraft]]: ...
def write_file(path: str, contents: bytes) -> None: ...
def figures(path: str) -> list[tuple[str, str]]: ...
def program(words: list[str]) -> int: ...
def write_page(path: str, page: str) -> None: ...
def save(
    path: str,
    problem: dict[str, Any],
    arrays: dict[str, _Array],
    words: list[tuple[Optional[str], str]],
    loads: list[tuple[str, list[_Array]]],
    config: dict[str, Any],
) -> None: ...
