"""Presses a sphere on a body that yields, step by step, by Tamaas (EPICSolver, accelerated, with DFSANESolver), or runs
another program and measures it.

    yielding_tamaas.py '{"heights": FILE.npy, "pressures": [P, ...], "tolerance": T, "depth": D, "nodes": N,
                         "yield": Y, "hardening": H, "threads": 1}'
    yielding_tamaas.py '{"program": [NAME, ARGUMENT, ...]}'

E = 1, Poisson's ratio 0.3, cell length 1. Prints one JSON object: processor time in s, memory in bytes, and for each
pressure the evaluations of the strain and the contact area; or processor time and the output of the program.
"""

import json
import resource
import subprocess
import sys
import time

from peak_memory import peak_bytes


def measured(program):
    done = subprocess.run(program, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return {"cpu": resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, "printed": done.stdout}


def pressed(task):
    import numpy as np
    import tamaas
    from tamaas.nonlinear_solvers import DFSANESolver

    class Counted(DFSANESolver):
        """Counts the evaluations of the strain."""

        evaluations = 0

        def _scipy_solve(self, evaluate):
            def counted(vector):
                self.evaluations += 1
                return evaluate(vector)

            return super()._scipy_solve(counted)

    tamaas.set_log_level(tamaas.LogLevel.error)
    tamaas.initialize(task["threads"])
    heights = np.load(task["heights"])
    before, started = peak_bytes(), time.process_time()
    kind = tamaas.model_type.volume_2d
    model = tamaas.Model(kind, [task["depth"], 1.0, 1.0], [task["nodes"], *heights.shape])
    model.E, model.nu = 1.0, 0.3
    material = tamaas.materials.IsotropicHardening(model, sigma_y=task["yield"], hardening=task["hardening"])
    strain = Counted(tamaas.Residual(model, material))
    strain.tolerance = task["tolerance"]
    contact = tamaas.PolonskyKeerRey(model, heights, 0.1 * task["tolerance"])
    solver = tamaas.EPICSolver(contact, strain, task["tolerance"], 0.5)
    solver.max_iter = 1000
    steps = []
    for pressure in task["pressures"]:
        counted = strain.evaluations
        solver.acceleratedSolve(pressure)
        area = float((model.traction[..., 2] > 0).mean())
        steps.append({"evaluations": strain.evaluations - counted, "area": area})
    return {"cpu": time.process_time() - started, "peak": peak_bytes() - before, "steps": steps}


def main():
    task = json.loads(sys.argv[1])
    print(json.dumps(measured(task["program"]) if "program" in task else pressed(task)))


main()
