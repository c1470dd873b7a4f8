"""Contacts, punches and stresses of layered bodies, on every base, solved densely: writes layered_bodies.json beside
itself.

Independent of gfmd: numpy, scipy and mpmath only. Run: python3 layered_bodies.py

For every wavenumber the equations of elasticity are solved as a boundary-value problem with 40 digits: in each layer
the general solution u = grad(phi) and 2 (1 - nu) 2 psi e_z - grad(z psi) with harmonic phi and psi ~ exp(+-q z)
(Papkovich-Neuber; a half-space has the two that decay), with unknown factors, and one linear system of the conditions
at the surface, at every interface and at the base. Contacts: active sets of bounded_contacts.py. Punches: dense system
of the held points, all components. Grids have an odd number of points along each axis where components couple, so that
no wave is its own mirror image but the uniform one. The uniform wave: layers in series, sum of h/C11 and h/C44,
whatever they stand on; a half-space at the bottom adds nothing.
"""

import json
import os

import mpmath as mp
import numpy as np

from bounded_contacts import rough, solve

mp.mp.dps = 40

# From the top down: Young's modulus, Poisson's ratio, height (None: half-space); the base below the last layer with a
# height.
BODIES = {
    "sliding": ([(1.0, 0.3, 0.2)], "sliding"),
    "plate": ([(1.0, 0.3, 0.4)], "free"),
    "coated": ([(4.0, 0.25, 0.05), (1.0, 0.4, None)], None),
    "soft coating": ([(0.2, 0.5, 0.03), (1.0, 0.3, None)], None),
    "layers": ([(2.0, 0.2, 0.04), (0.5, 0.45, 0.1), (1.5, 0.3, 0.3)], "bonded"),
    "layers on ice": ([(2.0, 0.2, 0.04), (0.5, 0.45, 0.1)], "sliding"),
    "layered plate": ([(2.0, 0.2, 0.2), (0.5, 0.45, 0.3)], "free"),
}
# The second body of a pair: a half-space, or a slab bonded at its back.
SECONDS = {"half-space": ([(0.7, 0.3, None)], None), "slab": ([(3.0, 0.45, 0.1)], "bonded")}


class Wave:
    """A body at one wavenumber: displacement (a, w) and traction (tau, s) with u_long = i a, u_z = w, sigma_xz = i tau,
    sigma_zz = s.
    """

    def __init__(self, body, q):
        self.layers, self.base = body
        self.q = mp.mpf(q)
        self.tops = [mp.mpf(0)]
        for *_, h in self.layers:
            if h is not None:
                self.tops.append(self.tops[-1] - mp.mpf(h))
        self.first = np.cumsum([0] + [2 if h is None else 4 for *_, h in self.layers])

    def states(self, layer, z):
        """Columns of (a, w, tau, s, sigma_xx) of the solutions of a layer at the height z."""
        young, nu, h = self.layers[layer]
        nu, q = mp.mpf(nu), self.q
        mu = mp.mpf(young) / (2 * (1 + nu))
        top = self.tops[layer]
        columns = []
        for sign in (1, -1) if h is not None else (1,):
            far = top if sign == 1 else top - mp.mpf(h)
            psi = mp.exp(sign * q * (z - far))
            d1, d2 = sign * q * psi, q * q * psi
            # grad(phi)
            a, w, da, dw = q * psi, d1, q * d1, d2
            columns.append((a, w, mu * (da + q * w), 2 * mu * dw, 2 * mu * (-q * a)))
            # (3 - 4 nu) psi e_z - z grad(psi); lambda div u = 4 mu nu psi'
            y = z - top
            a, da = -y * q * psi, -q * psi - y * q * d1
            w, dw = (3 - 4 * nu) * psi - y * d1, (2 - 4 * nu) * d1 - y * d2
            trace = 4 * mu * nu * d1
            columns.append((a, w, mu * (da + q * w), trace + 2 * mu * dw, trace + 2 * mu * (-q * a)))
        return columns

    def factors(self, load):
        """The factors of all solutions under the tractions (tau, s) on the surface."""
        n = self.first[-1]
        rows, right = [], []

        def add(parts, value):
            row = [mp.mpf(0)] * n
            for layer, entries in parts:
                for k, entry in enumerate(entries):
                    row[self.first[layer] + k] += entry
            rows.append(row)
            right.append(mp.mpf(value))

        at = lambda layer, z, what, sign=1: (layer, [sign * column[what] for column in self.states(layer, z)])
        add([at(0, self.tops[0], 2)], load[0])
        add([at(0, self.tops[0], 3)], load[1])
        for layer in range(len(self.layers) - 1):
            z = self.tops[layer + 1]
            for what in range(4):
                add([at(layer, z, what), at(layer + 1, z, what, -1)], 0)
        last = len(self.layers) - 1
        if self.base is not None:
            for what in {"bonded": (0, 1), "sliding": (2, 1), "free": (2, 3)}[self.base]:
                add([at(last, self.tops[-1], what)], 0)
        return mp.lu_solve(mp.matrix(rows), mp.matrix(right))

    def state(self, factors, layer, z):
        columns = self.states(layer, z)
        return [
            sum(factors[int(self.first[layer]) + k] * column[what] for k, column in enumerate(columns))
            for what in range(5)
        ]

    def sagittal(self):
        """Compliance on (a, w): columns under tau = 1 and under s = 1."""
        return [self.state(self.factors(load), 0, self.tops[0])[:2] for load in ((1, 0), (0, 1))]

    def transverse(self):
        """Displacement across the wave under unit shear: mu q tanh-like recursion from the base up."""
        q, stiffness = self.q, None
        for (young, nu, h), top in reversed(list(zip(self.layers, self.tops))):
            mu = mp.mpf(young) / (2 * (1 + mp.mpf(nu)))
            if h is None:
                stiffness = mu * q
                continue
            t = mp.tanh(q * mp.mpf(h))
            if stiffness is None:
                stiffness = mu * q / t if self.base == "bonded" else mu * q * t
            else:
                stiffness = mu * q * (stiffness + mu * q * t) / (mu * q + stiffness * t)
        return 1 / stiffness


def level(body):
    """Lateral and normal compliance of the uniform wave."""
    lateral = normal = 0.0
    for young, nu, h in body[0]:
        if h is not None:
            mu = young / (2 * (1 + nu))
            lateral += h / mu
            normal += h * (1 - 2 * nu) / (2 * (1 - nu)) / mu
    return lateral, normal


def kernels(bodies, points, lengths):
    """G_long, G_coupling (a under s), G_zz, G_transverse for all waves of a grid; the second body is upside down."""
    (nx, ny), (lx, ly) = points, lengths
    kx, ky = 2 * np.pi * np.fft.fftfreq(nx, 1 / nx) / lx, 2 * np.pi * np.fft.fftfreq(ny, 1 / ny) / ly
    q = np.hypot(kx[:, None], ky)
    table, memory = np.zeros((4, nx, ny)), {}
    for i in range(nx):
        for j in range(ny):
            if i == j == 0:
                continue
            key = round(q[i, j], 9)
            if key not in memory:
                total = np.zeros(4)
                for number, body in enumerate(bodies):
                    wave = Wave(body, q[i, j])
                    (along, down), (coupling, normal) = wave.sagittal()
                    assert abs(down - coupling) < mp.mpf(10) ** -25 * (abs(along) + abs(normal))
                    total += [float(along), float(coupling) * (1 - 2 * number), float(normal), float(wave.transverse())]
                memory[key] = total
            table[:, i, j] = memory[key]
    lateral, normal = np.sum([level(body) for body in bodies], axis=0)
    table[:, 0, 0] = lateral, 0.0, normal, lateral
    return kx, ky, q, table


def normal_matrix(bodies, points, lengths):
    nx, ny = points
    *_, table = kernels(bodies, points, lengths)
    response = np.fft.ifft2(table[2]).real
    i, j = np.divmod(np.arange(nx * ny), ny)
    return response[(i[:, None] - i) % nx, (j[:, None] - j) % ny]


def full_response(bodies, points, lengths):
    """u_a(r) under a unit traction t_b on the origin, [a, b, x, y]."""
    kx, ky, q, (along, coupling, normal, across) = kernels(bodies, points, lengths)
    q[0, 0] = 1.0
    n = np.array([np.broadcast_to(kx[:, None] / q, q.shape), np.broadcast_to(ky / q, q.shape)])
    spectrum = np.zeros((3, 3, *points), complex)
    for a in range(2):
        for b in range(2):
            spectrum[a, b] = n[a] * n[b] * (along - across) + (a == b) * across
        # u_long = i a: i coupling under sigma_zz = 1; the reverse is its conjugate.
        spectrum[a, 2] = 1j * n[a] * coupling
        spectrum[2, a] = -1j * n[a] * coupling
    spectrum[2, 2] = normal
    return np.fft.ifft2(spectrum).real


def contact(bodies, surface, mean=None, approach=None):
    points, lengths, heights = surface
    G = normal_matrix(bodies, points, lengths)
    p, delta, found, stiffness, _, _ = solve(G, (heights.max() - heights).ravel(), None, mean, approach)
    numbers = {"mean_pressure": mean or found, "approach": approach or delta, "stiffness": stiffness}
    return {**numbers, "contact_nodes": int((p > 0).sum()), "pressure": [float("%.13e" % v) for v in p]}


def punch(bodies, n, length, under, depth):
    """A sticking punch on the points under[i, j]: tractions there, zero elsewhere; displacement (0, 0, -depth)."""
    response = full_response(bodies, (n, n), (length, length))
    i, j = np.nonzero(under)
    di, dj = (i[:, None] - i) % n, (j[:, None] - j) % n
    G = np.block([[response[a, b][di, dj] for b in range(3)] for a in range(3)])
    u = np.concatenate([np.zeros(2 * len(i)), np.full(len(i), -depth)])
    t = np.linalg.solve(G, u)
    t += np.linalg.solve(G, u - G @ t)
    return [float("%.13e" % v) for v in t]


def inside(body, q):
    """The state under a unit normal traction wave, on both sides of every interface, and in the middle of every
    layer.
    """
    wave = Wave(body, q)
    factors = wave.factors((0, 1))
    rows = []
    for layer, (*_, h) in enumerate(body[0]):
        top, bottom = wave.tops[layer], wave.tops[layer] - mp.mpf(h if h is not None else 0.2)
        for z in (top, (top + bottom) / 2, bottom):
            a, w, tau, s, xx = (float(v) for v in wave.state(factors, layer, z))
            rows.append({"layer": layer, "depth": float(-z), "a": a, "w": w, "tau": tau, "zz": s, "xx": xx})
    return rows


SURFACE = ((24, 24), (1.0, 1.0), rough((24, 24), 5))


def main():
    problems, punches, waves = [], [], []
    cases = [(name, None) for name in BODIES] + [("sliding", "half-space"), ("coated", "slab")]
    for name, second in cases:
        bodies = [BODIES[name]] + ([SECONDS[second]] if second else [])
        for load in ({"mean": 0.01}, {"mean": 0.1}, {"approach": 0.02}):
            found = contact(bodies, SURFACE, **load)
            control = "approach" if "approach" in load else "mean_pressure"
            problems.append({"body": name, "second": second, "control": control, **found})
            print(name, second, load, found["mean_pressure"], found["approach"], found["contact_nodes"])
    under = np.zeros((15, 15), bool)
    under[4:9, 5:9] = True
    for name, second in [("sliding", None), ("plate", None), ("coated", None), ("layers", None), ("sliding", "slab")]:
        bodies = [BODIES[name]] + ([SECONDS[second]] if second else [])
        t = punch(bodies, 15, 1.0, under, 0.01)
        punches.append({"body": name, "second": second, "traction": t})
        print("punch", name, second, sum(t[2 * under.sum():]))
    for name in BODIES:
        waves.append({"body": name, "q": 6 * np.pi, "states": inside(BODIES[name], 6 * np.pi)})
    points, lengths, heights = SURFACE
    form = {
        k: {"layers": [[e, nu, h] for e, nu, h in layers], "base": base}
        for k, (layers, base) in {**BODIES, **SECONDS}.items()
    }
    content = {
        "conventions": (
            "layers from the top down: Young's modulus, Poisson's ratio, height (null: half-space); base below the last"
            " one; peaks point at the body; arrays row by row, x first. Contacts without friction: p >= 0, gap >= 0, p"
            " gap = 0. Punches hold u = (0, 0, -depth) on the points `under`, traction component after component on"
            " these. Waves exp(i q x): u_x = i a, u_z = w, sigma_xz = i tau, sigma_zz = zz, sigma_xx = xx under"
            " sigma_zz = 1 on the surface. Made by layered_bodies.py"
        ),
        "bodies": form,
        "surface": {"points": points, "lengths": lengths, "heights": heights.ravel().tolist()},
        "contacts": problems,
        "under": [[int(i), int(j)] for i, j in zip(*np.nonzero(under))],
        "punch": {"points": [15, 15], "lengths": [1.0, 1.0], "depth": 0.01},
        "punches": punches,
        "waves": waves,
    }
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "layered_bodies.json"), "w") as f:
        json.dump(content, f)


if __name__ == "__main__":
    main()
