"""Runs one solve of Tamaas (PolonskyKeerRey; with a hardness KatoSaturated).

    solve_tamaas.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "threads": N, "out": FILE.npy,
                      "boundary": "periodic" or "free", "hardness": P or null, "solver": S,
                      "fftw": {"library": NAME, "threads": NAME}, "plans": "estimated" or "measured"}'

The libraries in "fftw" must be preloaded; they then replace the FFTW in the package. With free boundaries S is
"default" (the operator without periodicity is registered, as its documentation says) or "dcfft" (the solver is told to
use it, too). Prints one JSON object. Only the call of the solver is timed: model, operators and plans are made before.
If the tolerance was not reached, "failure" has the reason, and the pressure so far is written.
"""

import contextlib
import ctypes
import json
import os
import re
import sys
import tempfile
import time

import numpy as np
import tamaas

from peak_memory import peak_bytes


def set_up_transforms(task, n):
    """Sets the threads of the preloaded FFTW, and makes measured plans, which Tamaas finds in the wisdom of FFTW."""
    if task["fftw"] is None:
        return
    library = ctypes.CDLL(task["fftw"]["library"])
    if task["threads"] > 1 and task["fftw"]["threads"] is not None:
        threads = ctypes.CDLL(task["fftw"]["threads"])
        threads.fftw_init_threads()
        threads.fftw_plan_with_nthreads(task["threads"])
    if task["plans"] == "measured":
        library.fftw_malloc.restype = ctypes.c_void_p
        library.fftw_malloc.argtypes = [ctypes.c_size_t]
        library.fftw_free.argtypes = [ctypes.c_void_p]
        half = n // 2 + 1
        real, spectrum = library.fftw_malloc(8 * n * n), library.fftw_malloc(16 * n * half)
        shape = (ctypes.c_int * 2)(n, n)
        a, b = ctypes.c_void_p(real), ctypes.c_void_p(spectrum)
        measure = ctypes.c_uint(0)
        library.fftw_plan_many_dft_r2c(2, shape, 1, a, None, 1, n * n, b, None, 1, n * half, measure)
        library.fftw_plan_many_dft_c2r(2, shape, 1, b, None, 1, n * half, a, None, 1, n * n, measure)
        library.fftw_free(real)
        library.fftw_free(spectrum)


@contextlib.contextmanager
def captured(lines):
    """Redirects the output of the library to `lines`."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with tempfile.TemporaryFile("w+") as file:
        try:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
            yield
        finally:
            ctypes.CDLL(None).fflush(None)
            for descriptor, original in enumerate(kept, start=1):
                os.dup2(original, descriptor)
                os.close(original)
        file.seek(0)
        lines.extend(file)


def iterations(lines):
    """Returns the first number in the last line of the table of iterations."""
    found = [re.match(r"\s*(\d+)\s+\S+e[+-]\d+\s+\S+", line) for line in lines]
    numbers = [int(match[1]) for match in found if match]
    return numbers[-1] if numbers else None


def main():
    task = json.loads(sys.argv[1])
    baseline = peak_bytes()
    heights = np.load(task["heights"])
    n = heights.shape[0]
    tamaas.set_log_level(tamaas.LogLevel.info)
    tamaas.initialize(task["threads"])
    set_up_transforms(task, n)
    model = tamaas.Model(tamaas.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E = 1.0
    model.nu = 0.0
    is_free = task.get("boundary") == "free"
    if is_free:
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    if task.get("hardness") is not None:
        solver = tamaas.KatoSaturated(model, heights, task["tolerance"], task["hardness"])
    else:
        solver = tamaas.PolonskyKeerRey(model, heights, task["tolerance"])
    if is_free and task["solver"] == "dcfft":
        solver.setIntegralOperator("dcfft")
    solver.max_iter = task.get("most", 100_000)
    solver.dump_freq = 1_000_000_000
    # The first application of the operator makes the plans.
    model.traction[:] = 1.0
    model.solveNeumann()
    model.traction[:] = 0.0
    model.displacement[:] = 0.0
    lines = []
    with captured(lines):
        started = time.perf_counter()
        error = solver.solve(task["mean_pressure"])
        seconds = time.perf_counter() - started
    peak = peak_bytes()
    np.save(task["out"], model.traction)
    # KatoSaturated does not tell its iterations.
    steps = iterations(lines) if task.get("hardness") is None else None
    # Two pairs per iteration and three more, as counted with a library between Tamaas and FFTW.
    pairs = None if steps is None else 2.0 * steps + 3.0
    report = {"seconds": seconds, "iterations": steps, "transform_pairs": pairs}
    report |= {"peak_bytes": peak, "baseline_bytes": baseline}
    # At the iteration limit Tamaas reports no error, so that convergence must be checked.
    if not error <= task["tolerance"]:
        report["failure"] = f"no convergence to {task['tolerance']:.0e} after {steps} iterations"
    print(json.dumps(report))


main()
