"""Runs one creep test of Tamaas (MaxwellViscoelastic): a mean pressure that is applied in the first step, and kept.

    creep_tamaas.py '{"heights": FILE.npy, "mean_pressure": P, "tolerance": T, "threads": N, "step": DT, "steps": K,
                      "branches": [[TAU, C], ...], "fftw": {"library": NAME, "threads": NAME}, "out": FILE.npy}'

C is the modulus of a branch over the long-term one; E* = 1, Poisson's ratio 0. Prints one JSON object: the wall times
of the steps, the contact areas, and "held": the pressure of a wave in full contact, whose displacement does not change,
over that of the long-term modulus, for each of as many steps. A Maxwell model has 1 + C exp(-t/TAU) there, and backward
Euler 1 + C/(1 + DT/TAU)^k.
"""

import ctypes
import json
import sys
import time

import numpy as np
import tamaas


def made(task, heights):
    """The solver of a surface on a square cell of unit length."""
    model = tamaas.Model(tamaas.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E = 1.0
    model.nu = 0.0
    # E* = 2 G at this Poisson's ratio.
    moduli = [0.5 * weight for _, weight in task["branches"]]
    times = [tau for tau, _ in task["branches"]]
    solver = tamaas.MaxwellViscoelastic(model, heights, task["tolerance"], task["step"], moduli, times)
    solver.max_iter = 100_000
    # The first application of the operator makes the plans.
    model.traction[:] = 1.0
    model.solveNeumann()
    model.traction[:] = 0.0
    model.displacement[:] = 0.0
    return model, solver


def main():
    task = json.loads(sys.argv[1])
    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(task["threads"])
    if task["fftw"] is not None and task["threads"] > 1 and task["fftw"]["threads"] is not None:
        threads = ctypes.CDLL(task["fftw"]["threads"])
        threads.fftw_init_threads()
        threads.fftw_plan_with_nthreads(task["threads"])
    model, solver = made(task, np.load(task["heights"]))
    seconds, areas = [], []
    for _ in range(task["steps"]):
        started = time.perf_counter()
        solver.solve(task["mean_pressure"])
        seconds.append(time.perf_counter() - started)
        areas.append(float((model.traction > 0).mean()))
    np.save(task["out"], model.traction)
    n, amplitude = 32, 1e-3
    wave = amplitude * np.cos(2 * np.pi * np.arange(n) / n)[:, None] * np.ones((1, n))
    model, solver = made(task, wave)
    held = []
    for _ in range(task["steps"]):
        # More than full contact needs.
        solver.solve(100 * np.pi * amplitude)
        held.append(float((model.traction.max() - model.traction.mean()) / (np.pi * amplitude)))
    print(json.dumps({"seconds": seconds, "areas": areas, "held": held}))


main()
