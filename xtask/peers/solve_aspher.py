"""Runs one solve of ASPHER (solve_nested).

    solve_aspher.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "threads": N, "solver": S,
                      "out": FILE.npy, "boundary": "periodic" or "free"}'

S is "default", with the operators without approximation: "periodic", and "fft" with free boundaries; or "active" (its
active set, which leaves out points that are no candidates), with the operator "h2", an approximation, which that needs.
Prints one JSON object. The timed call contains the set-up, which the package does not offer by itself. If the tolerance
was not reached, "failure" has its status, and the pressure so far is written.
"""

import json
import sys
import time

import aspher
import numpy as np

from peak_memory import peak_bytes


def main():
    task = json.loads(sys.argv[1])
    baseline = peak_bytes()
    heights = np.load(task["heights"])
    exact = "fft" if task.get("boundary") == "free" else "periodic"
    active = task["solver"] == "active"
    started = time.perf_counter()
    result = aspher.solve_nested(
        grid_size=heights.shape[0],
        gap=-heights.ravel(),
        p_nominal=task["mean_pressure"],
        domain_size=1.0,
        E_star=1.0,
        tol=task["tolerance"],
        max_iter=task.get("most", 20_000),
        backend="h2" if active else exact,
        active_set=active,
    )
    seconds = time.perf_counter() - started
    peak = peak_bytes()
    np.save(task["out"], np.asarray(result.pressure).reshape(heights.shape))
    # Iterations of the finest grid. Transforms are not counted: the preconditioner is a stencil.
    report = {"seconds": seconds, "iterations": int(result.iterations), "transform_pairs": None}
    report |= {"peak_bytes": peak, "baseline_bytes": baseline}
    if not result.converged:
        report["failure"] = f"no convergence to {task['tolerance']:.0e}: {result.status}"
    print(json.dumps(report))


main()
