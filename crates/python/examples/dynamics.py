"""Relaxation by dynamics: the residual of Verlet and FIRE against the number of steps, from runs with a step limit."""

import sys
from typing import Literal, get_args

import gfmd
import matplotlib.pyplot as plt

Solver = Literal["verlet-critical", "verlet", "fire", "fire2", "cg"]
surface, body = gfmd.self_affine(n=64, rms_gradient=0.1), gfmd.Body()


def residual(solver: Solver, steps: int) -> float:
    try:
        return float(gfmd.contact(surface, body, p_star=0.1, solver=solver, max_iterations=steps).residual)
    except gfmd.NotConverged as error:
        return float(error.state.residual)


counts = [int(2 ** (k / 2)) for k in range(4, 21)]
for solver in get_args(Solver):
    plt.loglog(counts, [residual(solver, count) for count in counts], ".-", label=solver)
plt.axhline(1e-8, color="k", lw=0.5)
plt.xlabel("steps allowed")
plt.ylabel("largest residual")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "dynamics.png", bbox_inches="tight")
assert residual("fire", 4096) < residual("fire", 16)
