from collections.abc import Callable
from typing import Any, Optional, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "GIT_COMMIT",
    "Problem",
    "State",
    "VERSION",
    "adhesion",
    "check_law",
    "composite",
    "conductance",
    "detrend",
    "fill",
    "finer",
    "options",
    "periodise",
    "program",
    "read",
    "read_array",
    "read_config",
    "read_records",
    "read_text",
    "save",
    "self_affine",
    "solve",
    "statistics",
]
VERSION: str
GIT_COMMIT: str

_Array = npt.NDArray[np.float64]
_Tick = Optional[Callable[[int, float], None]]

@final
class State:
    fields: list[tuple[str, _Array]]
    def times(self, accuracy: str) -> int: ...

@final
class Problem:
    description: str
    def __new__(cls, problem: dict[str, Any], arrays: dict[str, _Array], threads: int) -> Problem: ...
    def solve(
        self, control: str, value: float, start: Optional[State], threads: int, tick: _Tick
    ) -> tuple[State, str, Optional[tuple[str, str]], Optional[BaseException]]: ...
    def check_accuracy(self, accuracy: str, control: str) -> None: ...
    def slopes(self, largest: float) -> Optional[str]: ...
    def recall(self, fields: dict[str, _Array], approach: float) -> State: ...

def adhesion(problem: dict[str, Any], arrays: dict[str, _Array]) -> str: ...
def conductance(touching: npt.NDArray[np.bool_], lengths: tuple[float, float], boundary: str, height: float) -> float: ...
def check_law(name: str, parameters: list[tuple[str, float]]) -> None: ...
def options() -> list[str]: ...
def self_affine(
    *,
    n: list[int],
    length: list[float],
    hurst: float,
    eps_t_inv: Optional[float],
    eps_f_inv: Optional[float],
    eps_c_inv: Optional[float],
    rms_gradient: float,
    rms_height: Optional[float],
    seed: int,
    dim: int,
    method: str,
    roll_off: Optional[float],
    roll_off_shape: str,
    amplitudes: str,
) -> tuple[_Array, tuple[float, float], str]: ...
def read(name: str, channel: Optional[str] = None) -> tuple[_Array, Optional[tuple[float, float]], Optional[str], str, str]: ...
def fill(heights: _Array, lengths: tuple[float, float], how: str) -> _Array: ...
def detrend(heights: _Array, trend: str) -> _Array: ...
def periodise(heights: _Array, lengths: tuple[float, float], way: str) -> tuple[_Array, tuple[float, float]]: ...
def finer(heights: _Array, lengths: tuple[float, float], times: int) -> _Array: ...
def composite(
    first: _Array, second: _Array, lengths: tuple[float, float], shift: tuple[float, float], boundary: str
) -> tuple[_Array, tuple[float, float]]: ...
def statistics(heights: _Array, lengths: tuple[float, float], fit_range: Any = None) -> str: ...
def solve(
    command: str, problem: dict[str, Any], arrays: Optional[dict[str, Any]] = None, threads: int = 0, tick: _Tick = None
) -> tuple[str, Optional[tuple[str, str]], dict[str, _Array]]: ...
def program(words: list[str]) -> int: ...
def save(
    path: str,
    problem: dict[str, Any],
    arrays: dict[str, _Array],
    words: list[tuple[Optional[str], str]],
    loads: list[tuple[str, list[_Array]]],
    config: dict[str, Any],
) -> None: ...
def read_array(path: str, name: str) -> _Array: ...
def read_text(path: str, group: str, name: str) -> str: ...
def read_config(path: str) -> str: ...
def read_records(path: str) -> tuple[list[str], list[str]]: ...
