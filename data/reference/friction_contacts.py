"""Contacts with Coulomb friction in which pressure and shear act on each other, solved densely: writes
friction_contacts.json beside itself.

Independent of gfmd: numpy, mpmath and the scripts beside this one. Run: python3 friction_contacts.py

The compliance of all components is a dense matrix whose waves are boundary-value problems with 40 digits
(layered_bodies.py). Unknown are the pressure p, the shear tau and the approach of all points at once; the conditions
    p = max(0, p - c gap),   tau = P(tau - c slip; mu p),   mean p as prescribed,   P(.; r): projection on |.| <= r
are solved by a semismooth Newton method (Alart and Curnier 1991) with a line search, one increment after another: in an
increment the slip counts from the state before. Nothing alternates. Grids have an odd number of points along each axis.
Strips are surfaces with two levels.
"""

import json
import os

import numpy as np

from layered_bodies import full_response

NU = 0.3
SLAB = ([(1.0, NU, 0.3)], "bonded")
SOLID = ([(1.0, 0.1, None)], None)
SOFT = ([(0.5, 0.2, 0.05), (1.0, NU, 0.4)], "bonded")


def matrix(body, points, lengths):
    response = full_response([body], points, lengths)
    axes = (0, 1, 2) if points[1] > 1 else (0, 2)
    i, j = np.divmod(np.arange(points[0] * points[1]), points[1])
    di, dj = (i[:, None] - i) % points[0], (j[:, None] - j) % points[1]
    return np.block([[response[a, b][di, dj] for b in axes] for a in axes])


def increment(G, clearance, mean, mu, lateral, before):
    """One increment to the mean pressure and the lateral place of the rigid surface. State: p, tau [component, point],
    u, lateral.
    """
    n = len(clearance)
    k = len(G) // n - 1
    c = 1.0 / np.abs(np.diag(G)).mean()
    p = before["p"].copy() if before else np.full(n, mean)
    tau = before["tau"].copy() if before else np.zeros((k, n))
    delta = before["delta"] if before else float(np.median(clearance))
    stuck = np.zeros((k, n)) + np.array(lateral)[:k, None]
    if before:
        stuck += before["u"][:k] - np.array(before["lateral"])[:k, None]

    def residual(p, tau, delta, jacobian=False):
        t = np.concatenate([tau.ravel(), -p])
        u = (G @ t).reshape(k + 1, n)
        gap, slip = clearance - u[-1] - delta, u[:k] - stuck
        xi = tau - c * slip
        size, limit = np.sqrt((xi**2).sum(0)), mu * np.maximum(p, 0)
        touch, stick = p - c * gap > 0, size <= limit
        fp = np.where(touch, c * gap, p)
        along = xi / np.where(size > 0, size, 1)
        ft = np.where(stick, c * slip, tau - limit * along)
        load = p.mean() - mean
        F = np.concatenate([ft.ravel(), fp, [load]])
        if not jacobian:
            return F, u, gap, slip
        # Columns: tau, p, delta.
        D = np.hstack([G[:, : k * n], -G[:, k * n :]])
        J = np.zeros((len(F), len(F)))
        rows = np.arange(n)
        z = slice(k * n, (k + 1) * n)
        J[z, :-1] = np.where(touch[:, None], -c * D[k * n :], 0)
        J[z, -1] = np.where(touch, -c, 0)
        J[k * n + rows[~touch], k * n + rows[~touch]] += 1
        for a in range(k):
            row = a * n + rows
            J[row[stick], :-1] = c * D[row[stick]]
            slide = rows[~stick]
            J[a * n + slide, a * n + slide] += 1
            J[a * n + slide, k * n + slide] -= np.where(p[slide] > 0, mu * along[a, slide], 0)
            for b in range(k):
                turn = limit[slide] / size[slide] * ((a == b) - along[a, slide] * along[b, slide])
                J[a * n + slide, b * n + slide] -= turn
                J[a * n + slide, :-1] += turn[:, None] * c * D[b * n + slide]
        J[-1, z] = 1 / n
        return F, J

    scale = mean
    for step in range(400):
        F, J = residual(p, tau, delta, True)
        if np.abs(F).max() < 1e-14 * scale:
            break
        x = -np.linalg.lstsq(J, F, rcond=None)[0] if np.linalg.cond(J) > 1e14 else -np.linalg.solve(J, F)
        best, part = None, 1.0
        while part > 1e-3:
            trial = (p + part * x[k * n : -1], tau + part * x[: k * n].reshape(k, n), delta + part * x[-1])
            size = np.linalg.norm(residual(*trial)[0])
            if best is None or size < best[0]:
                best = (size, trial)
            if size < (1 - 0.1 * part) * np.linalg.norm(F):
                break
            part /= 2
        # Without descent a whole step changes the sets.
        p, tau, delta = (
            best[1]
            if best[0] < np.linalg.norm(F)
            else (p + x[k * n : -1], tau + x[: k * n].reshape(k, n), delta + x[-1])
        )
    F, u, gap, slip = residual(p, tau, delta)
    p = np.maximum(p, 0)
    size, limit = np.sqrt((tau**2).sum(0)), mu * p
    slipping = np.sqrt((slip**2).sum(0))
    inside = p > 1e-12 * mean
    worst = max(
        np.abs(F).max() / mean,
        -gap.min() / clearance.max(),
        (p * gap).max() / (mean * clearance.max()),
        ((size - limit).max()) / (mu * mean),
        (slipping * (limit - size))[inside].max() / (mu * mean * clearance.max()),
        ((slip * tau).sum(0) + slipping * size).max() / (mu * mean * clearance.max()),
    )
    assert worst < 1e-11, (step, worst)
    sticks = inside & (size < limit * (1 - 1e-9))
    print(step, worst, int(inside.sum()), int(sticks.sum()))
    return {
        "p": p,
        "tau": tau,
        "delta": delta,
        "u": u,
        "lateral": lateral,
        "stick": int(sticks.sum()),
        "touch": int(inside.sum()),
    }


def wave(n):
    return 0.02 * np.cos(2 * np.pi * np.arange(n) / n)[:, None]


def strip(n):
    x = np.arange(n) - n // 2
    return np.where(np.abs(x) <= n // 8, 0.0, -0.05)[:, None]


def sphere(n):
    x = (np.arange(n) - n // 2) / n
    return -0.5 * (x[:, None] ** 2 + x**2)


CASES = [
    (
        "wave on a slab",
        SLAB,
        wave(63),
        0.3,
        [(0.01, (0, 0)), (0.01, (0.004, 0)), (0.01, (-0.001, 0)), (0.015, (0.002, 0))],
    ),
    ("wave on a half-space", SOLID, wave(63), 0.3, [(0.01, (0, 0)), (0.01, (0.003, 0)), (0.01, (-0.002, 0))]),
    ("wave on layers", SOFT, wave(45), 0.5, [(0.01, (0.002, 0)), (0.02, (0.004, 0))]),
    ("strip that sticks to a slab", SLAB, strip(63), 4.0, [(0.01, (0, 0)), (0.01, (0.003, 0))]),
    ("strip that slides on a slab", SLAB, strip(63), 0.2, [(0.01, (0, 0)), (0.01, (0.05, 0))]),
    ("sphere on a slab", SLAB, sphere(15), 0.3, [(0.002, (0, 0)), (0.002, (0.0016, 0.0009)), (0.002, (0.0, 0.002))]),
]


def main():
    cases = []
    for name, body, heights, mu, path in CASES:
        points, lengths = heights.shape, (1.0, 1.0)
        G = matrix(body, points, lengths)
        clearance = (heights.max() - heights).ravel()
        states, before = [], None
        for mean, lateral in path:
            before = increment(G, clearance, mean, mu, lateral, before)
            number = lambda v: float("%.12e" % v)
            states.append(
                {
                    "mean_pressure": mean,
                    "lateral": list(lateral),
                    "approach": number(before["delta"]),
                    "contact_nodes": before["touch"],
                    "sticking_nodes": before["stick"],
                    "pressure": [number(v) for v in before["p"]],
                    "shear": [number(v) for v in before["tau"].ravel()],
                }
            )
        layers = [list(layer) for layer in body[0]]
        cases.append(
            {
                "name": name,
                "layers": layers,
                "base": body[1],
                "points": list(points),
                "lengths": list(lengths),
                "coefficient": mu,
                "heights": [float(v) for v in heights.ravel()],
                "states": states,
            }
        )
    result = {
        "title": "Contacts with Coulomb friction, pressure and shear coupled, one increment after another",
        "conventions": (
            "heights: peaks point at the body; layers: [E, nu, height or null], from the top; pressure [x, y]; shear on"
            " the elastic surface [component, x, y]; lateral: place of the rigid surface"
        ),
        "cases": cases,
    }
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "friction_contacts.json"), "w") as file:
        json.dump(result, file)
        file.write("\n")


if __name__ == "__main__":
    main()
