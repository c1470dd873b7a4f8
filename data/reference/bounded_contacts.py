"""Small contacts with free boundaries, a hardness, or both, solved densely: writes bounded_contacts.json beside itself.

Independent of gfmd: numpy and scipy only. Run: python3 bounded_contacts.py

Minimise 1/2 p.G p + p.clearance over 0 <= p <= hardness, with the mean of p prescribed or less approach * sum(p).
E* = 1. G is a dense matrix. Free: the displacement at the centres of the cells by a uniform pressure on one of them,
Love (1929) in the form of Johnson, Contact Mechanics (1985), eq. 3.25. Periodic: 2/q for every wave of the grid, 0 for
the mean. Active sets are changed by a semismooth Newton method until every condition holds; solved with LU and one step
of refinement. "stiffness" is d(mean pressure)/d(approach) with the points at 0 and at the hardness kept.
"""

import json
import os

import numpy as np
from scipy.linalg import lu_factor, lu_solve


def johnson_3_25(x, y, a, b):
    """pi E* u_z / p at (x, y) by the pressure p on the rectangle |x| < a, |y| < b."""
    xp, xm, yp, ym = x + a, x - a, y + b, y - b

    def term(s, t, u):
        """s ln((t + hypot(t, s)) / (u + hypot(u, s)))"""
        return s * np.log((t + np.hypot(t, s)) / (u + np.hypot(u, s)))

    return term(xp, yp, ym) + term(yp, xp, xm) + term(xm, ym, yp) + term(ym, xm, xp)


def free_matrix(points, lengths):
    (nx, ny), (lx, ly) = points, lengths
    dx, dy = lx / nx, ly / ny
    i, j = np.divmod(np.arange(nx * ny), ny)
    di, dj = np.abs(i[:, None] - i), np.abs(j[:, None] - j)
    table = johnson_3_25(*np.meshgrid(np.arange(nx) * dx, np.arange(ny) * dy, indexing="ij"), dx / 2, dy / 2) / np.pi
    return table[di, dj]


def periodic_matrix(points, lengths):
    (nx, ny), (lx, ly) = points, lengths
    i, j = np.divmod(np.arange(nx * ny), ny)
    kx, ky = 2 * np.pi * np.fft.fftfreq(nx, 1 / nx) / lx, 2 * np.pi * np.fft.fftfreq(ny, 1 / ny) / ly
    q = np.hypot(kx[:, None], ky)
    q[0, 0] = np.inf
    table = np.fft.ifft2(2 / q).real
    return table[(i[:, None] - i) % nx, (j[:, None] - j) % ny]


def solve(G, clearance, hardness, mean=None, approach=None):
    N = len(clearance)
    P = np.inf if hardness is None else hardness
    p = np.full(N, mean if mean is not None else 0.0)
    delta = approach if approach is not None else 0.0
    gap = G @ p + clearance - delta if approach is not None else clearance - np.sort(clearance)[N // 3]
    free, full = (gap <= 0) if hardness is None else (gap <= 0) & (gap > gap.min() / 2), np.zeros(N, bool)
    if hardness is not None:
        full = gap <= gap.min() / 2
    for step in range(2000):
        f = np.flatnonzero(free)
        rhs = -clearance[f] - (P * G[np.ix_(f, full)].sum(1) if full.any() else 0.0)
        if mean is None:
            A, b = G[np.ix_(f, f)], rhs + approach
        else:
            A = np.block([[G[np.ix_(f, f)], -np.ones((len(f), 1))], [np.ones((1, len(f))), np.zeros((1, 1))]])
            b = np.append(rhs, N * mean - (P * full.sum() if full.any() else 0.0))
        lu = lu_factor(A)
        x = lu_solve(lu, b)
        x += lu_solve(lu, b - A @ x)
        p = np.zeros(N)
        p[f] = x[: len(f)]
        p[full] = P
        if mean is not None:
            delta = x[-1]
        gap = G @ p + clearance - delta
        gap[f] = 0.0
        new_free = (free & (p > 0) & (p < P)) | (~free & ~full & (gap < 0)) | (full & (gap > 0))
        new_full = (full & (gap <= 0)) | (free & (p >= P))
        if (new_free == free).all() and (new_full == full).all():
            break
        if not new_free.any():
            raise RuntimeError("no point is free")
        free, full = new_free, new_full
    else:
        raise RuntimeError("the sets do not settle")
    gap = G @ p + clearance - delta
    worst = max(abs(gap[free]).max(), -gap[~full].min(), gap[full].max() if full.any() else 0, -p.min(), (p - P).max())
    assert worst < 1e-13, worst
    # Stiffness: G q = 1 on the free points.
    lu = lu_factor(G[np.ix_(free, free)])
    one = np.ones(free.sum())
    q = lu_solve(lu, one)
    q += lu_solve(lu, one - G[np.ix_(free, free)] @ q)
    return p, delta, p.mean(), q.sum() / N, -(gap[full].sum()) / N, int(full.sum())


def rough(points, seed):
    rng = np.random.default_rng(seed)
    nx, ny = points
    k = np.hypot(np.fft.fftfreq(2 * nx, 1 / (2 * nx))[:, None], np.fft.fftfreq(2 * ny, 1 / (2 * ny)))
    k[0, 0] = np.inf
    h = np.fft.ifft2(np.fft.fft2(rng.standard_normal((2 * nx, 2 * ny))) * k**-1.8).real[:nx, :ny]
    return np.round(0.02 * h / h.std(), 7)


SURFACES = {
    "rough24": ((24, 24), (1.0, 1.0), rough((24, 24), 1)),
    "rough32": ((32, 32), (2.0, 2.0), rough((32, 32), 2)),
    "oblong": ((20, 27), (1.0, 1.7), rough((20, 27), 3)),
}
CASES = [
    # surface, boundary, hardness, mean pressure, approach
    ("rough24", "free", None, 0.005, None),
    ("rough24", "free", None, 0.1, None),
    ("rough24", "free", None, None, 0.02),
    ("rough32", "free", None, 0.02, None),
    ("rough32", "free", None, None, 0.06),
    ("oblong", "free", None, 0.03, None),
    ("oblong", "free", None, None, 0.03),
    ("rough24", "free", 0.12, 0.03, None),
    ("rough24", "free", 0.03, 0.029, None),
    ("rough24", "free", 0.12, None, 0.03),
    ("oblong", "free", 0.2, 0.05, None),
    ("rough24", "periodic", 0.12, 0.03, None),
    ("rough24", "periodic", 0.05, 0.049, None),
    ("rough32", "periodic", 0.1, 0.01, None),
    ("oblong", "periodic", 0.2, None, 0.03),
    ("rough24", "periodic", None, 0.02, None),
]


def main():
    problems = []
    for name, boundary, hardness, mean, approach in CASES:
        points, lengths, heights = SURFACES[name]
        clearance = (heights.max() - heights).ravel()
        G = (free_matrix if boundary == "free" else periodic_matrix)(points, lengths)
        p, delta, found, stiffness, volume, full = solve(G, clearance, hardness, mean, approach)
        problems.append(
            {
                "surface": name,
                "boundary": boundary,
                "hardness": hardness,
                "control": "mean_pressure" if approach is None else "approach",
                "mean_pressure": found if mean is None else mean,
                "approach": delta if approach is None else approach,
                "stiffness": stiffness,
                "contact_nodes": int((p > 0).sum()),
                "plastic_nodes": full,
                "plastic_volume": volume,
                "pressure": [float("%.13e" % v) for v in p],
            }
        )
        print(name, boundary, hardness, mean, approach, "->", found, delta, stiffness, (p > 0).mean(), full)
    surfaces = {k: {"points": p, "lengths": l, "heights": h.ravel().tolist()} for k, (p, l, h) in SURFACES.items()}
    conventions = (
        "E* = 1, nu = 0; peaks point at the body; arrays row by row, x first; pressures to 14 digits; made by"
        " bounded_contacts.py"
    )
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "bounded_contacts.json"), "w") as f:
        json.dump({"conventions": conventions, "surfaces": surfaces, "problems": problems}, f)


if __name__ == "__main__":
    main()
