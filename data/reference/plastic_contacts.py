"""Small contacts with a hardness that is a field, on layers, and along a path, solved densely: writes
plastic_contacts.json beside itself.

Independent of gfmd: numpy, scipy and mpmath only. Run: python3 plastic_contacts.py

Minimise 1/2 p.G p + p.clearance over 0 <= p <= P, P a number or one for each point, with the mean of p prescribed or
less approach * sum(p). G is the dense matrix of bounded_contacts.py (E* = 1) or layered_bodies.py. Active sets are
changed by a semismooth Newton method until every condition holds; LU and one step of refinement. "paths": the plastic
depth stays. Each step is solved with the clearance plus the depth so far; where p = P the depth grows by -gap. "work"
is the energy lost in a step, mean of P times the growth.
"""

import json
import os

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from bounded_contacts import SURFACES, free_matrix, periodic_matrix
from layered_bodies import BODIES, normal_matrix


# Far below the sizes of pressures and heights here.
ROUND_OFF = 1e-15


def solve(G, clearance, P, mean=None, approach=None):
    """Pressure, approach, gap (negative where p = P), and the points at P."""
    N = len(clearance)
    P = np.broadcast_to(np.asarray(P, float), (N,))
    p = np.minimum(P, mean if mean is not None else P.min() * 0.1)
    # Projected gradients bring the sets near those of the solution.
    step = 1.0 / np.linalg.eigvalsh(G)[-1]
    for _ in range(600):
        g = G @ p + clearance - (approach or 0.0)
        p = p - step * g
        if mean is None:
            p = np.clip(p, 0, P)
        else:
            low, high = (p - P).min() - 1, p.max()
            for _ in range(80):
                mu = 0.5 * (low + high)
                low, high = (mu, high) if np.clip(p - mu, 0, P).mean() > mean else (low, mu)
            p = np.clip(p - mu, 0, P)
    free, full = (p > 0) & (p < P), p >= P
    for _ in range(500):
        f = np.flatnonzero(free)
        rhs = -clearance[f] - G[np.ix_(f, np.flatnonzero(full))] @ P[full]
        if mean is None:
            A, b = G[np.ix_(f, f)], rhs + approach
        else:
            A = np.block([[G[np.ix_(f, f)], -np.ones((len(f), 1))], [np.ones((1, len(f))), np.zeros((1, 1))]])
            b = np.append(rhs, N * mean - P[full].sum())
        lu = lu_factor(A)
        x = lu_solve(lu, b)
        x += lu_solve(lu, b - A @ x)
        p = np.zeros(N)
        p[f], p[full] = x[: len(f)], P[full]
        delta = approach if mean is None else x[-1]
        gap = G @ p + clearance - delta
        gap[f] = 0.0
        # On the way back to a load the points at P are so with a gap of zero: they stay in either set.
        new_free = (
            (free & (p > 0) & (p < P + ROUND_OFF)) | (~free & ~full & (gap < -ROUND_OFF)) | (full & (gap > ROUND_OFF))
        )
        new_full = (full & (gap <= ROUND_OFF)) | (free & (p >= P + ROUND_OFF))
        if (new_free == free).all() and (new_full == full).all():
            break
        free, full = new_free, new_full
    else:
        raise RuntimeError("the sets do not settle")
    worst = max(-gap[~full].min(), gap[full].max() if full.any() else 0, -p.min(), (p - P).max())
    assert worst < 1e-13, worst
    return p, delta, gap, full


def stiffness(G, p, P):
    free = (p > 0) & (p < P)
    A, one = G[np.ix_(free, free)], np.ones(free.sum())
    q = np.linalg.solve(A, one)
    q += np.linalg.solve(A, one - A @ q)
    return q.sum() / len(p)


def grains(points, hardness):
    i, j = np.indices(points)
    return np.round(hardness * np.array([1.0, 0.1, 0.4])[(i // 5 + j // 7) % 3], 12).ravel()


def digits(values):
    return [float("%.13e" % v) for v in values]


CASES = [
    # surface, body (a boundary of a half-space or a name of layered_bodies.py), hardness, grains, mean pressure,
    # approach
    ("rough24", "periodic", 0.2, True, 0.03, None),
    ("rough24", "periodic", 0.2, True, 0.095, None),
    ("rough24", "periodic", 0.2, True, None, 0.03),
    ("oblong", "periodic", 0.3, True, 0.05, None),
    ("rough24", "free", 0.2, True, 0.03, None),
    ("rough24", "free", 0.2, True, None, 0.03),
    ("oblong", "free", 0.3, True, 0.05, None),
    ("rough24", "coated", 0.3, False, 0.05, None),
    ("rough24", "coated", 0.5, True, 0.05, None),
    ("rough24", "layers", 0.2, False, None, 0.03),
    ("rough24", "layers", 0.2, True, 0.04, None),
]

# A paraboloid of radius 1 on a patch of side 1: Hertz.
ROUND = ((24, 24), (1.0, 1.0))
PATHS = [
    # surface, boundary, hardness, grains, control, its values
    ("hertz", "free", 0.15, False, "mean_pressure", [0.01, 0.02, 0.03, 0.02, 0.005, 0.02, 0.03, 0.035]),
    ("hertz", "free", 0.15, False, "approach", [0.03, 0.09, 0.06, 0.04, 0.09]),
    ("rough24", "periodic", 0.12, False, "mean_pressure", [0.01, 0.03, 0.015, 0.003, 0.03, 0.05]),
    ("rough24", "free", 0.2, True, "mean_pressure", [0.02, 0.05, 0.02, 0.05]),
]


def matrix(body, surface):
    points, lengths, _ = surface
    if body in ("free", "periodic"):
        return (free_matrix if body == "free" else periodic_matrix)(points, lengths)
    return normal_matrix([BODIES[body]], points, lengths)


def main():
    x = ((np.arange(24) + 0.5) / 24 - 0.5)[:, None]
    surfaces = {**SURFACES, "hertz": (*ROUND, np.round(-0.5 * (x**2 + x.T**2), 12))}
    problems, paths = [], []
    for name, body, hardness, grainy, mean, approach in CASES:
        points, _, heights = surfaces[name]
        P = grains(points, hardness) if grainy else np.full(heights.size, hardness)
        G = matrix(body, surfaces[name])
        p, delta, gap, full = solve(G, (heights.max() - heights).ravel(), P, mean, approach)
        control = "approach" if mean is None else "mean_pressure"
        problems.append(
            {
                "surface": name,
                "body": body,
                "hardness": digits(P) if grainy else hardness,
                "control": control,
                "mean_pressure": mean or p.mean(),
                "approach": approach or delta,
                "stiffness": stiffness(G, p, P),
                "contact_nodes": int((p > 0).sum()),
                "plastic_nodes": int(full.sum()),
                "plastic_volume": -gap[full].sum() / p.size,
                "pressure": digits(p),
            }
        )
        print(name, body, control, mean or approach, "->", p.mean(), delta, (p > 0).mean(), full.mean())
    for name, body, hardness, grainy, control, values in PATHS:
        points, _, heights = surfaces[name]
        P = grains(points, hardness) if grainy else np.full(heights.size, hardness)
        G, depth, steps = matrix(body, surfaces[name]), np.zeros(heights.size), []
        for value in values:
            p, delta, gap, full = solve(
                G,
                (heights.max() - heights).ravel() + depth,
                P,
                **({"mean": value} if control == "mean_pressure" else {"approach": value}),
            )
            growth = np.where(full, -gap, 0.0)
            depth = depth + growth
            steps.append(
                {
                    "mean_pressure": p.mean(),
                    "approach": delta,
                    "contact_nodes": int((p > 0).sum()),
                    "plastic_nodes": int(full.sum()),
                    "plastic_volume": depth.mean(),
                    "work": (P * growth).mean(),
                    "energy": 0.5 * (p @ (G @ p)) / p.size,
                }
            )
            print(name, body, value, steps[-1])
        paths.append(
            {
                "surface": name,
                "body": body,
                "hardness": digits(P) if grainy else hardness,
                "control": control,
                "values": values,
                "steps": steps,
                "pressure": digits(p),
                "plastic_depth": digits(depth),
            }
        )
    used = {case[0] for case in CASES + PATHS}
    content = {
        "conventions": (
            "E* = 1, nu = 0 of half-spaces, bodies as in layered_bodies.json; peaks point at the body; arrays row by"
            " row, x first; pressure and plastic_depth of a path after its last step; made by plastic_contacts.py"
        ),
        "bodies": {
            name: {"layers": [[e, nu, h] for e, nu, h in BODIES[name][0]], "base": BODIES[name][1]}
            for name in ("coated", "layers")
        },
        "surfaces": {
            k: {"points": p, "lengths": l, "heights": h.ravel().tolist()}
            for k, (p, l, h) in surfaces.items()
            if k in used
        },
        "problems": problems,
        "paths": paths,
    }
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "plastic_contacts.json"), "w") as f:
        json.dump(content, f)


if __name__ == "__main__":
    main()
