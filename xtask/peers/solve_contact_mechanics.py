"""Runs one solve of ContactMechanics.

    solve_contact_mechanics.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "solver": S, "out": FILE.npy,
                                 "boundary": "periodic" or "free", "hardness": P or null, "answer": FILE.npy}'

S is the solver. "default" is the constrained conjugate gradient method of the package, under a load. "no-restart" and
"no-restart-load" are those of NuMPI without restart (Bugnicourt et al. 2018) with the operator of the package: the
first at a prescribed displacement, as offered by the package, which is computed from the answer; the second under a
load. T is the largest allowed gap in contact, relative to the rms height. Prints one JSON object. Only the call of the
solver is timed. If the solver gives up, "failure" has its message, and the pressure so far is written.
"""

import contextlib
import json
import sys
import time

import ContactMechanics
import numpy as np
import SurfaceTopography
from NuMPI.Optimization import CCGWithoutRestart

from peak_memory import peak_bytes


def displacement(system, file):
    """Computes the rigid displacement for which the pressure in `file` is the solution."""
    pressure = np.load(file)
    gap = system.substrate.evaluate_disp(-pressure / pressure.size) - system.surface.heights()
    return gap[pressure > 0].mean()


def default(system, force, tolerance, _, most):
    """Solves under a load; all criteria but the penetration are so loose that they have no effect."""
    result = system.minimize_proxy(external_force=force, pentol=tolerance, forcetol=1e30, thermotol=1e30, maxiter=most)
    # The solver makes one evaluation at the start and two in every iteration.
    return result, result.jac, result.nit, result.nfev


def no_restart(system, force, tolerance, offset, most):
    """Solves at the displacement `offset`, or under the force if it is None.

    Solves that converge take some hundred iterations.
    """
    shape = system.substrate.nb_grid_pts
    points = shape[0] * shape[1]
    applied = 0
    objective = system.dual_objective(offset or 0.0, gradient=True)

    def gradient(pressure):
        nonlocal applied
        applied += 1
        return objective(pressure)

    def product(direction):
        nonlocal applied
        applied += 1
        return system.dual_hessian_product(direction)

    mean = force / points
    result = CCGWithoutRestart.constrained_conjugate_gradients(
        gradient,
        product,
        np.full(shape, mean),
        mean_val=mean if offset is None else None,
        gtol=tolerance,
        maxiter=min(most, 5_000),
    )
    return result, result.x.reshape(shape), result.nit, applied


def system_of(heights, task):
    """The contact: periodic or not as the topography says it is."""
    periodic = task.get("boundary") != "free"
    topography = SurfaceTopography.Topography(heights, physical_sizes=(1.0, 1.0), periodic=periodic)
    if task.get("hardness") is None:
        return ContactMechanics.make_system(topography, young=1.0)
    plastic = SurfaceTopography.PlasticTopography(topography=topography, hardness=task["hardness"])
    return ContactMechanics.make_plastic_system(surface=plastic, young=1.0)


def main():
    task = json.loads(sys.argv[1])
    baseline = peak_bytes()
    heights = np.load(task["heights"])
    system = system_of(heights, task)
    # The first evaluation makes the plans.
    system.substrate.evaluate_disp(np.zeros(system.substrate.nb_domain_grid_pts))
    solve = default if task["solver"] == "default" else no_restart
    offset = displacement(system, task["answer"]) if task["solver"] == "no-restart" else None
    tolerance = task["tolerance"] * heights.std()
    started = time.perf_counter()
    # Both solvers print warnings to stdout. The cell has unit area, so that the force equals the mean pressure.
    with contextlib.redirect_stdout(sys.stderr):
        result, forces, iterations, pairs = solve(
            system, task["mean_pressure"], tolerance, offset, task.get("most", 100_000)
        )
    seconds = time.perf_counter() - started
    peak = peak_bytes()
    nx, ny = heights.shape
    np.save(task["out"], np.asarray(forces)[:nx, :ny] * heights.size)
    report = {"seconds": seconds, "iterations": int(iterations), "transform_pairs": float(pairs)}
    report |= {"peak_bytes": peak, "baseline_bytes": baseline}
    if not result.success:
        report["failure"] = f"no convergence to {task['tolerance']:.0e}: {result.message}"
    print(json.dumps(report))


main()
