"""Follows loads with an exponential adhesion by Tamaas (PolonskyKeerRey on the gap, ExponentialAdhesionFunctional).

    adhesion_tamaas.py '{"heights": FILE.npy, "pressures": [P, ...], "tolerance": T, "threads": N, "gamma": W,
                         "range": R, "most": K, "fftw": {"library": NAME, "threads": NAME}}'

E* = 1, cell length 1. Prints one JSON object: for each load, which starts from the last one, the wall time, the largest
residual of docs/interface.md (recomputed from the pressure), contact area and mean gap.
"""

import ctypes
import json
import sys
import time

import numpy as np
import tamaas

from certify import periodic


def judged(heights, pressure, contact, asked, task):
    """The largest residual, the area and the mean gap of a pressure with its points in contact."""
    gap = periodic(pressure) - heights
    gap -= gap[contact].mean()
    attraction = task["gamma"] / task["range"] * np.exp(-np.maximum(gap, 0.0) / task["range"])
    wall = pressure + attraction
    # The softest wave has the stiffness pi on this cell.
    stress, length = max(np.abs(pressure).max(), np.pi * heights.std()), heights.std()
    residuals = [
        abs((wall[contact] * gap[contact]).sum()) / (wall[contact].sum() * length),
        np.abs(wall[~contact]).max(initial=0.0) / stress,
        max(0.0, -gap.min()) / length,
        max(0.0, -wall[contact].min()) / stress,
        abs(pressure.mean() - asked) / stress,
    ]
    return {"residual": float(np.max(residuals)), "area": float(contact.mean()), "mean_gap": float(gap.mean())}


def main():
    task = json.loads(sys.argv[1])
    heights = np.load(task["heights"])
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(task["threads"])
    if task["fftw"] is not None and task["threads"] > 1 and task["fftw"]["threads"] is not None:
        threads = ctypes.CDLL(task["fftw"]["threads"])
        threads.fftw_init_threads()
        threads.fftw_plan_with_nthreads(task["threads"])
    model = tamaas.Model(tamaas.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E = 1.0
    model.nu = 0.0
    kinds = tamaas.PolonskyKeerRey
    solver = tamaas.PolonskyKeerRey(model, heights, task["tolerance"], kinds.gap, kinds.pressure)
    law = tamaas.ExponentialAdhesionFunctional(heights)
    law.parameters = {"rho": task["range"], "surface_energy": task["gamma"]}
    solver.addFunctionalTerm(law)
    solver.max_iter = task["most"]
    solver.dump_freq = 1_000_000_000
    loads = []
    for asked in task["pressures"]:
        started = time.perf_counter()
        error = solver.solve(asked)
        seconds = time.perf_counter() - started
        # Points in contact have the gap zero.
        contact = model.displacement - heights <= 1e-12 * heights.std()
        found = judged(heights, model.traction, contact, asked, task) if contact.any() else {}
        loads.append({"seconds": seconds, "converged": bool(error <= task["tolerance"])} | found)
    print(json.dumps({"loads": loads}))


main()
