"""Slabs between two rough rigid surfaces, solved densely: writes squeezed_slabs.json beside itself.

Independent of gfmd: numpy, scipy, mpmath. Run: python3 squeezed_slabs.py

For every wave, displacements and stresses U sin(qx), W cos(qx), tau sin(qx), sigma cos(qx) obey d/dz (U, W, tau,
sigma) = A (U, W, tau, sigma) in each layer. The product of the matrix exponentials of the layers, with 50 digits and
more, leads from the lower face to the upper one; no shear traction on either and the pressures p_t, p_b give the
indentations d_t = -W_top and d_b = W_bottom: the 2 x 2 compliance. The uniform wave compresses the slab by p
sum(height/C11), half on either face, and cannot move it as a whole.

The contacts: minimise 1/2 p.C p + p.clearance over p >= 0 with both means prescribed, by active sets (semismooth
Newton) on the dense matrix of both faces, solved with LU and refinement, until every condition holds. If the approach
is prescribed, the mean that gives it is sought.
"""

import json
import os

import mpmath as mp
import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.optimize import brentq


def exponential(young, poisson, height, q):
    """exp(A h) of one layer, in units of its shear modulus for stresses; poisson = 1/2 is exact."""
    mu = mp.mpf(young) / (2 * (1 + mp.mpf(poisson)))
    s = (1 - 2 * mp.mpf(poisson)) / (2 * (1 - mp.mpf(poisson)))
    A = mp.matrix(4, 4)
    A[0, 1], A[0, 2] = q, 1 / mu
    A[1, 0], A[1, 3] = -(1 - 2 * s) * q, s / mu
    A[2, 0], A[2, 3] = 4 * mu * (1 - s) * q * q, (1 - 2 * s) * q
    A[3, 2] = -q
    return mp.expm(A * height, method="taylor")


def wave(layers, q):
    """C_tt, C_tb, C_bb of the layers, from the top down, at the wavenumber q."""
    # The exponentials grow as exp(q h), and their product cancels.
    mp.mp.dps = 50 + int(q * sum(height for _, _, height in layers))
    T = mp.eye(4)
    for young, poisson, height in reversed(layers):
        T = exponential(young, poisson, mp.mpf(height), q) * T
    held = mp.matrix([[T[2, 0], T[2, 1]], [T[3, 0], T[3, 1]]])
    found = []
    for top, bottom in ((1, 0), (0, 1)):
        U, W = mp.lu_solve(held, mp.matrix([T[2, 3] * bottom, -top + T[3, 3] * bottom]))
        found.append((-(T[1, 0] * U + T[1, 1] * W - T[1, 3] * bottom), W))
    (tt, bt), (tb, bb) = found
    assert abs(tb - bt) < mp.mpf(10) ** -25 * abs(tt)
    return [float(tt), float(tb), float(bb)]


def dense(layers, points, lengths):
    (nx, ny), (lx, ly) = points, lengths
    i, j = np.divmod(np.arange(nx * ny), ny)
    m, n = np.fft.fftfreq(nx, 1 / nx), np.fft.fftfreq(ny, 1 / ny)
    table = np.zeros((nx, ny, 3))
    known = {}
    for a in range(nx):
        for b in range(ny):
            number = (abs(int(m[a])), abs(int(n[b])))
            if number == (0, 0):
                continue
            if number not in known:
                q = 2 * mp.pi * mp.sqrt((number[0] / mp.mpf(lx)) ** 2 + (number[1] / mp.mpf(ly)) ** 2)
                known[number] = wave(layers, q)
            table[a, b] = known[number]
    uniform = 0.25 * sum(h * (1 + v) * (1 - 2 * v) / (E * (1 - v)) for E, v, h in layers)
    table[0, 0] = uniform
    block = lambda k: np.fft.ifft2(table[:, :, k]).real[(i[:, None] - i) % nx, (j[:, None] - j) % ny]
    return np.block([[block(0), block(1)], [block(1), block(2)]])


def solve(C, clearance, mean):
    """Pressures and gaps on both faces, and the approaches of the two surfaces."""
    N = len(clearance) // 2
    # Columns of the constraints E.T p = e, whose multipliers lower the clearances.
    E, e = np.repeat([[1.0, 0.0], [0.0, 1.0]], N, axis=0), [N * mean, N * mean]
    active = np.concatenate([c <= np.sort(c)[N // 2] for c in (clearance[:N], clearance[N:])])
    seen = set()
    for step in range(5000):
        f = np.flatnonzero(active)
        A = np.block([[C[np.ix_(f, f)], -E[f]], [E[f].T, np.zeros((2, 2))]])
        right = np.concatenate([-clearance[f], e])
        lu = lu_factor(A)
        x = lu_solve(lu, right)
        for _ in range(3):
            x += lu_solve(lu, (right - A.astype(np.longdouble) @ x).astype(float))
        p = np.zeros(2 * N)
        p[f] = x[: len(f)]
        gap = C @ p + clearance - E @ x[len(f) :]
        gap[f] = 0.0
        wrong = np.where(active, p <= 0, gap < 0)
        if not wrong.any():
            break
        # If a set returns, only the worst point changes from then on.
        key = active.tobytes()
        if key in seen or step > 200:
            worst = np.argmax(np.where(active, -p / abs(p).max(), -gap / abs(clearance).max()))
            active[worst] = ~active[worst]
        else:
            active = active ^ wrong
        seen.add(key)
    else:
        raise RuntimeError("no active set")
    assert (p >= 0).all() and (gap >= 0).all() and abs(p[:N].mean() / p[N:].mean() - 1) < 1e-12
    return p, gap, x[len(f) :]


def pressed(C, clearance, mean, approach):
    """As solve, by the mean pressure that gives the approach."""
    if approach is not None:
        mean = brentq(lambda mean: solve(C, clearance, mean)[2].sum() - approach, 1e-4, 0.3, xtol=1e-17, rtol=1e-15)
    return solve(C, clearance, mean)


def rough(points, lengths, seed, height):
    """Waves up to a third of the points, of random phases, with amplitudes falling as q^-1.6, and this rms height."""
    (nx, ny), (lx, ly) = points, lengths
    random = np.random.default_rng(seed)
    m, n = np.fft.fftfreq(nx, 1 / nx)[:, None], np.fft.fftfreq(ny, 1 / ny)
    q = np.hypot(m / lx, n / ly)
    q[0, 0] = np.inf
    spectrum = np.fft.fft2(random.standard_normal((nx, ny))) * q**-1.6 * ((abs(m) <= nx / 3) & (abs(n) <= ny / 3))
    h = np.fft.ifft2(spectrum).real
    return np.round(h * height / h.std(), 6)


CASES = [
    ("slab", [(1.0, 0.3, 0.1)], (16, 16), (1.0, 1.0), 0.02, None),
    ("incompressible slab", [(1.0, 0.5, 0.6)], (24, 16), (1.5, 1.0), 0.01, None),
    ("incompressible slab, approach", [(1.0, 0.5, 0.6)], (24, 16), (1.5, 1.0), None, 0.035),
    ("layers", [(1.0, 0.3, 0.08), (5.0, 0.45, 0.1)], (16, 16), (1.0, 1.0), 0.02, None),
    ("layers, approach", [(1.0, 0.3, 0.08), (5.0, 0.45, 0.1)], (16, 16), (1.0, 1.0), None, 0.035),
    ("profile", [(2.0, 0.2, 0.15)], (48, 1), (1.0, 1.0), 0.03, None),
    ("profile, approach", [(2.0, 0.2, 0.04)], (48, 1), (1.0, 1.0), None, 0.02),
]


def main():
    cases = []
    for number, (name, layers, points, lengths, mean, approach) in enumerate(CASES):
        upper, lower = rough(points, lengths, 2 * number + 1, 0.01), rough(points, lengths, 2 * number + 2, 0.013)
        clearance = np.concatenate([(h.max() - h).ravel() for h in (upper, lower)])
        p, gap, parts = pressed(dense(layers, points, lengths), clearance, mean, approach)
        N = len(p) // 2
        print(
            f"{name}: mean {p[:N].mean():.6g}, approach {sum(parts):.6g}, contact {(p[:N] > 0).mean():.3f}"
            f" {(p[N:] > 0).mean():.3f}"
        )
        cases.append(
            dict(
                name=name,
                layers=layers,
                points=points,
                lengths=lengths,
                control="approach" if mean is None else "mean_pressure",
                upper=upper.ravel().tolist(),
                lower=lower.ravel().tolist(),
                mean_pressure=float(p[:N].mean()),
                approach=float(sum(parts)),
                approaches=[float(part) for part in parts],
                upper_pressure=[float(f"{v:.13g}") for v in p[:N]],
                lower_pressure=[float(f"{v:.13g}") for v in p[N:]],
                upper_gap=[float(f"{v:.11g}") for v in gap[:N]],
                lower_gap=[float(f"{v:.11g}") for v in gap[N:]],
            )
        )
    conventions = (
        "layers from the top down: Young's modulus, Poisson's ratio, height; both surfaces with their peaks pointing at"
        " the slab; arrays row by row, x first; approach: of the two surfaces beyond the distance at which both touch"
        " the undeformed slab, approaches: its parts at the upper and the lower face. Made by squeezed_slabs.py"
    )
    waves = [
        dict(layers=layers, q=q, compliance=wave(layers, mp.mpf(q)))
        for layers in (
            [(1.0, 0.3, 0.1)],
            [(1.0, 0.5, 0.6)],
            [(1.0, 0.3, 0.08), (5.0, 0.45, 0.1)],
            [(2.0, -0.3, 0.2), (1.0, 0.5, 0.1), (4.0, 0.1, 0.05)],
        )
        for q in (0.5, 6.0, 20.0, 200.0)
    ]
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "squeezed_slabs.json")
    with open(path, "w") as file:
        json.dump(dict(conventions=conventions, cases=cases, waves=waves), file)
        file.write("\n")


if __name__ == "__main__":
    main()
