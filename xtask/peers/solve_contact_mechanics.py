"""One solve by ContactMechanics, in a process of its own.

    solve_contact_mechanics.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "solver": S, "out": FILE.npy}'

S: "default" is the package's own constrained conjugate gradients, "no-restart" NuMPI's (Bugnicourt et al. 2018) on the
same operator. T is the largest penetration allowed, over the rms height. Prints one JSON object. Only the call of the
solver is timed.
"""

import json
import resource
import sys
import time

import ContactMechanics
import numpy as np
import SurfaceTopography
from NuMPI.Optimization import CCGWithoutRestart


def peak_bytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def default(system, force, tolerance):
    """Other criteria than the penetration are set so loose that they do not count."""
    result = system.minimize_proxy(external_force=force, pentol=tolerance, forcetol=1e30, thermotol=1e30, maxiter=100_000)
    # One evaluation to begin with, two in every iteration.
    return result, result.jac, result.nit, result.nfev


def no_restart(system, force, tolerance):
    shape = system.substrate.nb_grid_pts
    points = shape[0] * shape[1]
    applied = 0

    def gradient(pressure):
        nonlocal applied
        applied += 1
        return system.dual_objective(0.0, gradient=True)(pressure)

    def product(direction):
        nonlocal applied
        applied += 1
        return system.dual_hessian_product(direction)

    start = np.full(shape, force / points)
    result = CCGWithoutRestart.constrained_conjugate_gradients(
        gradient, product, start, mean_val=force / points, gtol=tolerance, maxiter=100_000
    )
    return result, result.x.reshape(shape), result.nit, applied


def main():
    task = json.loads(sys.argv[1])
    baseline = peak_bytes()
    heights = np.load(task["heights"])
    topography = SurfaceTopography.Topography(heights, physical_sizes=(1.0, 1.0), periodic=True)
    system = ContactMechanics.make_system(topography, young=1.0)
    # Makes the plans.
    system.substrate.evaluate_disp(np.zeros(heights.shape))
    solve = {"default": default, "no-restart": no_restart}[task["solver"]]
    tolerance = task["tolerance"] * heights.std()
    started, cpu = time.perf_counter(), time.process_time()
    # The cell has unit area: the mean pressure is the force.
    result, forces, iterations, pairs = solve(system, task["mean_pressure"], tolerance)
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    peak = peak_bytes()
    if not result.success:
        sys.exit(f"no convergence to {task['tolerance']:e}: {result.message}")
    np.save(task["out"], np.asarray(forces) * heights.size)
    report = {"seconds": seconds, "cpu_seconds": cpu, "iterations": int(iterations), "transform_pairs": float(pairs)}
    report |= {"peak_bytes": peak, "baseline_bytes": baseline}
    print(json.dumps(report))


main()
