"""Punches of any shape that stick and are shifted sideways, with a traction on the surface beside them: dense
solutions.

The compliance of every wave is the boundary-value problem of layered_bodies.py with 40 digits. 15 points have no
Nyquist mode.
Run: python masked_punches.py (NumPy, SciPy, mpmath); writes masked_punches.json beside itself.
"""
import json
import os

import numpy as np

from layered_bodies import full_response

N = 15
DEPTH, SHIFT = 0.01, (0.004, -0.007)
BODIES = {
    "slab": ([(1.0, 0.3, 0.4)], "bonded"),
    "coated": ([(3.0, 0.2, 0.1), (1.0, 0.4, 0.3)], "bonded"),
}


def mask():
    """A ring that is open on one side, and a point apart: no symmetry."""
    under = np.zeros((N, N), bool)
    under[3:10, 4:11] = True
    under[5:8, 6:11] = False
    under[12, 2] = True
    return under


def traction(under):
    """Numbers without a pattern beside the punch, zero below it."""
    t = np.random.default_rng(7).normal(0.0, 0.02, (N, N, 3)).round(6)
    t[under] = 0.0
    return t


def solve(body, under, given, sticking):
    response = full_response([body], (N, N), (1.0, 1.0))
    points = np.arange(N * N)
    i, j = points // N, points % N
    di, dj = (i[:, None] - i) % N, (j[:, None] - j) % N
    G = np.block([[response[a, b][di, dj] for b in range(3)] for a in range(3)])
    held = np.concatenate([under.ravel() & sticking, under.ravel() & sticking, under.ravel()])
    t = np.concatenate([given[..., c].ravel() for c in range(3)])
    u = np.concatenate([np.full(N * N, v) for v in ((*SHIFT, -DEPTH) if sticking else (0.0, 0.0, -DEPTH))])
    H = G[np.ix_(held, held)]
    asked = u[held] - G[np.ix_(held, ~held)] @ t[~held]
    t[held] = np.linalg.solve(H, asked)
    t[held] += np.linalg.solve(H, asked - H @ t[held])
    return t, G @ t


def main():
    under = mask()
    given = traction(under)
    cases = []
    for name, body in BODIES.items():
        for sticking in (True, False):
            t, u = solve(body, under, given, sticking)
            shaped = [np.stack(np.split(field, 3), -1).reshape(N, N, 3) for field in (t, u)]
            cases.append({
                "body": name,
                "sticking": sticking,
                "traction": [float("%.13e" % v) for v in shaped[0].ravel()],
                "displacement": [float("%.13e" % v) for v in shaped[1].ravel()],
            })
            print(name, sticking, shaped[0].mean((0, 1)))
    content = {
        "conventions": (
            "u = (shift, -depth) on the points `under` (u_z = -depth alone if not sticking), traction `given`"
            " elsewhere; arrays [x, y, component] row by row; bodies: layers from the top down (Young's modulus,"
            " Poisson's ratio, height), base. Made by masked_punches.py"
        ),
        "points": [N, N],
        "lengths": [1.0, 1.0],
        "depth": DEPTH,
        "shift": SHIFT,
        "under": under.astype(int).ravel().tolist(),
        "given": given.ravel().tolist(),
        "bodies": {name: {"layers": layers, "base": base} for name, (layers, base) in BODIES.items()},
        "cases": cases,
    }
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "masked_punches.json"), "w") as f:
        json.dump(content, f)


if __name__ == "__main__":
    main()
