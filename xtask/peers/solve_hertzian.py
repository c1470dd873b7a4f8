"""Runs one solve of hertzian (solve_height_field), which has free boundaries only.

    solve_hertzian.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "threads": N, "out": FILE.npy}'

Prints one JSON object. The timed call contains the set-up, which the package does not offer by itself. If the tolerance
was not reached, "failure" has the reason, and the pressure so far is written if there is one.
"""

import json
import sys
import time

import hertzian
import numpy as np

from peak_memory import peak_bytes


def main():
    task = json.loads(sys.argv[1])
    baseline = peak_bytes()
    heights = np.load(task["heights"])
    nx, ny = heights.shape
    started = time.perf_counter()
    # The cell has unit area, so that the force equals the mean pressure.
    solution = hertzian.solve_height_field(
        gap=np.ascontiguousarray(heights.max() - heights),
        load=task["mean_pressure"],
        e_star=1.0,
        dx=1.0 / nx,
        dy=1.0 / ny,
        tol=task["tolerance"],
        max_iter=task.get("most", 20_000),
    )
    seconds = time.perf_counter() - started
    peak = peak_bytes()
    np.save(task["out"], np.asarray(solution.pressure).reshape(heights.shape))
    reported = solution.diagnostics
    report = {"seconds": seconds, "iterations": int(reported.iterations), "transform_pairs": None}
    report |= {"peak_bytes": peak, "baseline_bytes": baseline}
    if not reported.converged:
        report["failure"] = (
            f"no convergence to {task['tolerance']:.0e}: {reported.residual:.0e} after {reported.iterations} iterations"
        )
    print(json.dumps(report))


main()
