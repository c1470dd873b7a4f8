"""Edge dislocations in a half-space and in a slab: stresses and forces. Writes dislocation_images.json beside itself.

Independent of gfmd: numpy only. Run: python3 dislocation_images.py

Half-space: the closed form of Head (1953) by the potentials of Kolosov and Muskhelishvili for one dislocation at z0
below a free surface,
    phi = g ln(z - z0) - g ln(z - conj z0) - conj(g) (z - z0)/(z - conj z0),  g = mu B / (pi i (kappa + 1)),
summed over the periodic copies, with the tail of the sum by Richardson's rule. Slab on a bonded base: the field of
periodic rows in an unbounded body in closed form, in real space, and an image field found as a boundary-value problem
of Navier's equations: Fourier series along x from samples of the boundary values, Chebyshev collocation across the
thickness (no transfer matrix, no hyperbolic function). Frame: x to the right, z up, z = 0 at the surface. Units:
mu = 1.
"""

import json
import os

import numpy as np

NU = 0.3
KAPPA = 3 - 4 * NU
LENGTH = 1.0
HEIGHT = 0.35
EDGES = [(0.21, -0.08, 0.01, 0.0), (0.47, -0.15, 0.0, 0.02), (0.83, -0.27, -0.012, 0.006)]
PLACES = [(0.05, -0.03), (0.5, -0.1), (0.3, -0.3)]


def strength(bx, bz):
    return (bx + 1j * bz) / (1j * np.pi * (KAPPA + 1))


def stresses(dphi, both):
    """From phi' and conj(z) phi'' + psi'."""
    total, turned = 4 * dphi.real, 2 * both
    return np.array([(total - turned.real) / 2, (total + turned.real) / 2, turned.imag / 2])


def head(edge, x, z, self_too):
    """One dislocation below a free surface: xx, zz, xz."""
    x0, z0, bx, bz = edge
    g, p, zeta = strength(bx, bz), x0 + 1j * z0, x + 1j * z
    gb, pb = np.conj(g), np.conj(p)
    d1 = -g / (zeta - pb) - gb * (p - pb) / (zeta - pb) ** 2
    d2 = g / (zeta - pb) ** 2 + 2 * gb * (p - pb) / (zeta - pb) ** 3
    # psi1 = -conj(g) ln(z - conj z0) - z phi1'
    psi = -gb / (zeta - pb) - d1 - zeta * d2
    dphi, both = d1, np.conj(zeta) * d2 + psi
    if self_too:
        dphi = dphi + g / (zeta - p)
        both = both - g * np.conj(zeta) / (zeta - p) ** 2 + gb / (zeta - p) + g * pb / (zeta - p) ** 2
    return stresses(np.asarray(dphi), np.asarray(both))


def head_row(edge, x, z, own):
    """All copies; without the unbounded field of the dislocation itself if `own`."""
    # The field of a dislocation below a free surface decays like 1/x^2, and in pairs of copies faster: two terms of a
    # tail.
    def upto(n):
        total = head(edge, x, z, not own)
        for sign in (1, -1):
            copies = sign * LENGTH * np.arange(1, n + 1)
            total = total + head((edge[0] + copies, *edge[1:]), x, z, True).sum(axis=1)
        return total

    def richardson(values, powers):
        for power in powers:
            values = [(2**power * b - a) / (2**power - 1) for a, b in zip(values, values[1:])]
        return values[0]

    return richardson([upto(n) for n in (500, 1000, 2000, 4000, 8000)], (1, 2, 3, 4))


def row(edge, x, z):
    """A periodic row in an unbounded body."""
    x0, z0, bx, bz = edge
    g, k = strength(bx, bz), np.pi / LENGTH
    zeta = x - x0 + 1j * (z - z0)
    one, two = k / np.tan(k * zeta), (k / np.sin(k * zeta)) ** 2
    return stresses(g * one, (np.conj(g) - g) * one + 2j * (z - z0) * g * two)


def row_displacement(edge, x, z):
    """Below the row: periodic part of u_x + i u_z, and the slope of its rest along x."""
    x0, z0, bx, bz = edge
    g, k = strength(bx, bz), np.pi / LENGTH
    zeta = x - x0 + 1j * (z - z0)
    far = np.exp(-2j * k * zeta)
    logarithm = np.log(1 - far)
    rest = np.conj(1j * k * (1 + far) / (1 - far)) - np.conj(1j * k)
    u = KAPPA * g * logarithm - g * np.conj(logarithm) - 2j * (z - z0) * np.conj(g) * rest
    return u / 2, (1j * g * k * (KAPPA + 1) / 2)


def chebyshev(n):
    s = np.cos(np.pi * np.arange(n + 1) / n)
    c = np.ones(n + 1)
    c[0] = c[-1] = 2
    c *= (-1.0) ** np.arange(n + 1)
    ds = s[:, None] - s[None, :]
    d = np.outer(c, 1 / c) / (ds + np.eye(n + 1))
    return s, d - np.diag(d.sum(axis=1))


def slab(edges):
    """A function of x and z with the stress of image and uniform strain."""
    n, order, waves = 512, 60, 120
    x = LENGTH * np.arange(n) / n
    lam = 2 * NU / (1 - 2 * NU)
    top = sum(row(e, x, 0.0)[[2, 1]] for e in edges)
    moved, slope = np.zeros(n, complex), 0
    for e in edges:
        u, s = row_displacement(e, x, -HEIGHT)
        moved, slope = moved + u, slope + s
    fx, fz = np.fft.fft(top[0]) / n, np.fft.fft(top[1]) / n
    ux, uz = np.fft.fft(moved.real) / n, np.fft.fft(moved.imag) / n
    s, d = chebyshev(order)
    z, d = (s - 1) * HEIGHT / 2, d * 2 / HEIGHT
    d2, one = d @ d, np.eye(order + 1)
    columns = []
    for m in range(1, waves):
        q = 2 * np.pi * m / LENGTH
        a = np.zeros((2 * order + 2, 2 * order + 2), complex)
        b = np.zeros(2 * order + 2, complex)
        x_rows, z_rows = slice(0, order + 1), slice(order + 1, None)
        a[x_rows, x_rows] = d2 - (lam + 2) * q * q * one
        a[x_rows, z_rows] = (lam + 1) * 1j * q * d
        a[z_rows, x_rows] = (lam + 1) * 1j * q * d
        a[z_rows, z_rows] = (lam + 2) * d2 - q * q * one
        t, u = 0, order + 1
        a[t], a[u] = 0, 0
        a[t, x_rows], a[t, z_rows], b[t] = d[0], 1j * q * one[0], -fx[m]
        a[u, x_rows], a[u, z_rows], b[u] = lam * 1j * q * one[0], (lam + 2) * d[0], -fz[m]
        t, u = order, 2 * order + 1
        a[t], a[u] = 0, 0
        a[t, order], b[t] = 1, -ux[m]
        a[u, 2 * order + 1], b[u] = 1, -uz[m]
        solution = np.linalg.solve(a, b)
        columns.append((q, solution[: order + 1], solution[order + 1 :]))
    weights = np.ones(order + 1)
    weights[0] = weights[-1] = 0.5
    weights *= (-1.0) ** np.arange(order + 1)

    def stress(px, pz):
        at = weights / (pz - z)
        at /= at.sum()
        total = np.zeros(3)
        for q, vx, vz in columns:
            wave = 2 * np.exp(1j * q * px)
            exx, ezz = 1j * q * (at @ vx), at @ (d @ vz)
            gxz = at @ (d @ vx) + 1j * q * (at @ vz)
            parts = [lam * (exx + ezz) + 2 * exx, lam * (exx + ezz) + 2 * ezz, gxz]
            total += [(part * wave).real for part in parts]
        # The rest of the base's displacement is a strain along x (undone by a uniform one) and a rotation.
        total[0] += -slope.real * 2 / (1 - NU)
        return total

    return stress


def force(edge, stress):
    (_, _, bx, bz), (xx, zz, xz) = edge, stress
    return [bx * xz + bz * zz, -(bx * xx + bz * xz)]


def main():
    result = {
        "title": "Edge dislocations in a half-space and in a slab on a bonded base, free surface, periodic along x",
        "conventions": (
            "plane strain; x right, z up, z = 0 the surface; Burgers vector: jump of u along a counter-clockwise path; "
            "mean strain along x zero far below (at the base)"
        ),
        "shear_modulus": 1.0,
        "poisson": NU,
        "length": LENGTH,
        "height": HEIGHT,
        "edges": [list(e) for e in EDGES],
        "places": [list(p) for p in PLACES],
    }
    forces = []
    for i, edge in enumerate(EDGES):
        total = head_row(edge, edge[0], edge[1], True)
        for j, other in enumerate(EDGES):
            if i != j:
                total = total + head_row(other, edge[0], edge[1], False)
        forces.append(force(edge, total))
    result["half_space"] = {
        "forces": forces,
        "stresses": [list(sum(head_row(e, *place, False) for e in EDGES)) for place in PLACES],
    }
    image = slab(EDGES)
    forces = []
    for i, edge in enumerate(EDGES):
        total = image(edge[0], edge[1])
        for j, other in enumerate(EDGES):
            if i != j:
                total = total + row(other, edge[0], edge[1])
        # The own row without the own member: half the uniform field far away cancels, and the rest is -pi^2/3 terms
        # that are odd.
        forces.append(force(edge, total))
    result["slab"] = {
        "forces": forces,
        "stresses": [list(sum(row(e, *place) for e in EDGES) + image(*place)) for place in PLACES],
    }
    # One dislocation far from its copies: mu b^2/(4 pi (1 - nu) d) towards the surface.
    for bx, bz in ((0.01, 0.0), (0.0, 0.01)):
        one = force((0, -0.1, bx, bz), head((0, -0.1, bx, bz), 0.0, -0.1, False))
        assert abs(one[1] / (1e-4 / (4 * np.pi * (1 - NU) * 0.1)) - 1) < 1e-12 and abs(one[0]) < 1e-18, one
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "dislocation_images.json"), "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


main()
