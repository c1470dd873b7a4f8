"""Contacts on a patch that does not repeat, with friction, on slabs, or with a law of adhesion, solved densely: writes
free_contacts.json beside itself.

Independent of gfmd: numpy, scipy, mpmath and the scripts beside this one. Run: python3 free_contacts.py

The compliance between two cells is an integral over the loaded one in polar coordinates about the displaced point, in
which every kernel of Boussinesq and Cerruti is f(angle)/r: the integral of f times the length of the chord. What a slab
adds is an integral over wavenumbers (4000 Gauss nodes) of its closed form less that of the half-space, averaged over
the cell by 7 x 7 Gauss nodes. With all components, what layers add are integrals over wavenumbers (500 Gauss nodes) of
boundary-value problems with 40 digits (layered_bodies.py). Friction: the Newton method of friction_contacts.py. Slabs:
the active sets of bounded_contacts.py. Laws: Newton's method for u with dense stiffness and an active set at the wall;
the energy is convex, since the least eigenvalue of the stiffness exceeds the steepness of the law; a load by a search
for its approach.
"""

import json
import os

import numpy as np
from scipy.optimize import brentq
from scipy.special import j0, j1, jn

import bounded_contacts
import friction_contacts
from layered_bodies import Wave

PI = np.pi


def chord_integral(f, x, y, a, b, nodes=24):
    """Integral of f(angle)/r over the rectangle |u| < a/2, |v| < b/2 as seen from (x, y), with f of the direction from
    the source to the point.
    """
    t, w = np.polynomial.legendre.leggauss(nodes)
    corners = [np.arctan2(v - y, u - x) for u in (-a / 2, a / 2) for v in (-b / 2, b / 2)]
    inside = abs(x) < a / 2 and abs(y) < b / 2
    if inside:
        ends = sorted(c % (2 * PI) for c in corners)
        ends = ends + [ends[0] + 2 * PI]
    else:
        # Outside, the rectangle is seen under less than a half-turn: angles about that of its centre.
        middle = np.arctan2(-y, -x)
        ends = sorted(middle + (c - middle + PI) % (2 * PI) - PI for c in corners)
    total = 0.0
    for low, high in zip(ends[:-1], ends[1:]):
        if high - low < 1e-15:
            continue
        for angle, weight in zip(0.5 * (low + high) + 0.5 * (high - low) * t, 0.5 * (high - low) * w):
            c, s = np.cos(angle), np.sin(angle)
            near, far = -np.inf, np.inf
            for p, d, half in ((x, c, a / 2), (y, s, b / 2)):
                if d == 0:
                    continue
                k = sorted(((-half - p) / d, (half - p) / d))
                near, far = max(near, k[0]), min(far, k[1])
            length = far - max(near, 0.0)
            # The ray leads from the point to the source; the direction from the source to the point is the opposite
            # one.
            total += weight * f(-c, -s) * max(length, 0.0)
    return total


def tangential_matrix(points, lengths, young, nu):
    """u = G t with all components, z out of the body."""
    (nx, ny), (lx, ly) = points, lengths
    a, b = lx / nx, ly / ny
    mu = young / (2 * (1 + nu))
    kernels = {
        (0, 0): lambda c, s: (1 - nu + nu * c * c) / (2 * PI * mu),
        (1, 1): lambda c, s: (1 - nu + nu * s * s) / (2 * PI * mu),
        (2, 2): lambda c, s: (1 - nu) / (2 * PI * mu),
        (0, 1): lambda c, s: nu * c * s / (2 * PI * mu),
        (0, 2): lambda c, s: (1 - 2 * nu) * c / (4 * PI * mu),
        (1, 2): lambda c, s: (1 - 2 * nu) * s / (4 * PI * mu),
    }
    i, j = np.divmod(np.arange(nx * ny), ny)
    di, dj = i[:, None] - i, j[:, None] - j
    blocks = [[None] * 3 for _ in range(3)]
    for (k, l), f in kernels.items():
        table = {(m, n): chord_integral(f, m * a, n * b, a, b) for m in range(1 - nx, nx) for n in range(1 - ny, ny)}
        block = np.array([[table[m, n] for m, n in zip(*row)] for row in zip(di, dj)])
        blocks[k][l] = block
        blocks[l][k] = block.T
    return np.block(blocks)


def layered_matrix(points, lengths, layers, base):
    """As tangential_matrix, of layers [E, nu, height or None] from the top."""
    (nx, ny), (lx, ly) = points, lengths
    a, b = lx / nx, ly / ny
    young, nu, height = layers[0]
    mu = young / (2 * (1 + nu))

    def blocks(body, q):
        """Half the sum and the difference of the compliance along and across the wave, coupling, normal; times q."""
        wave = Wave(body, q)
        (along, _), (coupling, normal) = wave.sagittal()
        along, coupling, normal, across = [float(value) * q for value in (along, coupling, normal, wave.transverse())]
        return np.array([(along + across) / 2, (along - across) / 2, coupling, normal])

    half_space = blocks(([(young, nu, None)], None), 1.0)
    closed = [(2 - nu) / (2 * mu), -nu / (2 * mu), -(1 - 2 * nu) / (2 * mu), (1 - nu) / mu]
    assert np.allclose(half_space, closed, rtol=1e-12, atol=1e-14), (half_space, closed)
    t, w = np.polynomial.legendre.leggauss(500)
    last = 30.0 / height
    q, weight = 0.5 * last * (t + 1), 0.5 * last * w
    terms = np.array([(blocks((layers, base), one) - half_space) * factor for one, factor in zip(q, weight)]).T / (
        2 * PI
    )
    g, gw = np.polynomial.legendre.leggauss(7)

    def added(m, n):
        """Integrals over the loaded cell: the point lies m, n cells from its centre."""
        x, y = np.meshgrid(m * a + 0.5 * a * g, n * b + 0.5 * b * g, indexing="ij")
        r, angle = np.hypot(x, y), np.arctan2(y, x)
        z = r[..., None] * q
        mean, split, coupling, normal = (j0(z) @ terms[0], jn(2, z) @ terms[1], -(j1(z) @ terms[2]), j0(z) @ terms[3])
        kernels = {
            (0, 0): mean - split * np.cos(2 * angle), (1, 1): mean + split * np.cos(2 * angle), (2, 2): normal,
            (0, 1): -split * np.sin(2 * angle), (0, 2): coupling * np.cos(angle), (1, 2): coupling * np.sin(angle),
        }
        return {key: a * b / 4 * (gw[:, None] * gw * kernel).sum() for key, kernel in kernels.items()}

    table = {(m, n): added(m, n) for m in range(1 - nx, nx) for n in range(1 - ny, ny)}
    i, j = np.divmod(np.arange(nx * ny), ny)
    di, dj = i[:, None] - i, j[:, None] - j
    more = [[None] * 3 for _ in range(3)]
    for key in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]:
        block = np.array([[table[m, n][key] for m, n in zip(*row)] for row in zip(di, dj)])
        more[key[0]][key[1]] = block
        more[key[1]][key[0]] = block.T
    return tangential_matrix(points, lengths, young, nu) + np.block(more)


def slab_quadrature(nu, height, base):
    """Wavenumbers, their weights, and the compliance over that of a half-space."""
    t, w = np.polynomial.legendre.leggauss(4000)
    last = 30.0 / height
    q, weight = 0.5 * last * (t + 1), 0.5 * last * w
    x = q * height
    # Over cosh 2x, so that nothing overflows.
    sech, tanh = 1 / np.cosh(2 * x), np.tanh(2 * x)
    if base == "bonded":
        ratio = ((3 - 4 * nu) * tanh - 2 * x * sech) / ((3 - 4 * nu) + (2 * x * x + 5 - 12 * nu + 8 * nu * nu) * sech)
    else:
        ratio = (1 - sech) / (tanh + 2 * x * sech)
    return q, weight, ratio


def profile_matrix(points, lengths, nu, height, base):
    """As slab_matrix, by pressures on strips, whose transform is that of a cell: G_zz of the slab less (1 - exp(-2 q
    h)) 2/q, whose transform is ln(1 + 4 h^2/s^2)/pi, with the primitive s ln(1 + 4 h^2/s^2) + 4 h atan(s/(2 h)).
    """
    n, a, depth = points[0], lengths[0] / points[0], 2 * height
    q, weight, ratio = slab_quadrature(nu, height, base)
    term = weight * 2 / q * (ratio + np.expm1(-q * depth)) / PI * 2 * np.sin(0.5 * q * a) / q
    primitive = lambda s: (s * np.log1p((depth / s) ** 2) + 2 * depth * np.arctan(s / depth)) / PI
    x = a * np.arange(n)
    table = primitive(x + 0.5 * a) - primitive(x - 0.5 * a) + (np.cos(np.outer(x, q)) * term).sum(-1)
    i = np.arange(n)
    return table[np.abs(i[:, None] - i)]


def slab_matrix(points, lengths, nu, height, base):
    """The displacement downwards by pressures, E* = 1."""
    if points[1] == 1:
        return profile_matrix(points, lengths, nu, height, base)
    (nx, ny), (lx, ly) = points, lengths
    a, b = lx / nx, ly / ny
    q, weight, ratio = slab_quadrature(nu, height, base)
    term = weight * 2 * (ratio - 1) / (2 * PI)
    g, gw = np.polynomial.legendre.leggauss(7)
    table = np.zeros((nx, ny))
    for m in range(nx):
        for n in range(ny):
            r = np.hypot((m * a + 0.5 * a * g)[:, None], n * b + 0.5 * b * g)
            c = (j0(r[..., None] * q) * term).sum(-1)
            love = chord_integral(lambda c, s: 1.0, m * a, n * b, a, b) / PI
            table[m, n] = love + a * b / 4 * (gw[:, None] * gw * c).sum()
    i, j = np.divmod(np.arange(nx * ny), ny)
    return table[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]


def exponential(gamma, reach):
    return {
        "wall": True,
        "range": reach,
        "pull": lambda g: gamma / reach * np.exp(-g / reach),
        "slope": lambda g: -gamma / reach**2 * np.exp(-g / reach),
        "energy": lambda g: -gamma * np.exp(-g / reach),
        "steepest": gamma / reach**2,
    }


def morse(gamma, reach):
    e = lambda g: np.exp(-g / reach)
    return {
        "wall": False,
        "range": reach,
        "pull": lambda g: 2 * gamma / reach * (e(g) - e(g) ** 2),
        "slope": lambda g: 2 * gamma / reach**2 * (2 * e(g) ** 2 - e(g)),
        "energy": lambda g: gamma * (e(g) ** 2 - 2 * e(g)),
        "steepest": 2 * gamma / reach**2 / 8,
    }


def with_law(G, clearance, law, approach):
    """u_z = -G p on the patch, gap = clearance - u_z - approach, p = wall pressure - pull(gap). Unknown is the gap."""
    n = len(clearance)
    K = np.linalg.inv(G)
    K = 0.5 * (K + K.T)
    least = np.linalg.eigvalsh(K)[0]
    assert least > law["steepest"], (least, law["steepest"])
    gap, held = clearance.copy(), np.zeros(n, bool)
    for step in range(400):
        force = -K @ (clearance - gap - approach) + law["pull"](gap)  # of the wall
        new = (held & (force > 0)) | (~held & (gap < 0)) if law["wall"] else held
        gap = np.where(new, 0.0, gap)
        free = ~new
        force = -K @ (clearance - gap - approach) + law["pull"](gap)
        x = np.linalg.solve(K[np.ix_(free, free)] + np.diag(law["slope"](gap[free])), force[free])
        x *= min(1.0, 0.3 * law["range"] / np.abs(x).max())
        gap[free] -= x
        same, held = (new == held).all(), new
        if same and np.abs(x).max() < 1e-15:
            break
    p = -K @ (clearance - gap - approach)
    force = p + law["pull"](gap)
    scale = np.abs(p).max()
    worst = [
        np.abs(force[~held]).max() / scale,
        -min(0.0, *force[held]) / scale if held.any() else 0.0,
        -min(0.0, gap.min()) / clearance.max() if law["wall"] else 0.0,
    ]
    assert max(worst) < 1e-11, (step, worst)
    return p, gap, law["energy"](gap).mean(), 0.5 * (p * (gap + approach - clearance)).mean()


def rounded(values, digits=13):
    return [float("%.*e" % (digits, v)) for v in values]


def main():
    rough24, rough20 = bounded_contacts.rough((24, 24), 11), bounded_contacts.rough((20, 17), 12)
    profile = bounded_contacts.rough((120, 1), 14)
    result = {
        "conventions": (
            "peaks point at the body; arrays row by row, x first; shear on the elastic surface [component, x, y]; made"
            " by free_contacts.py"
        )
    }

    cases = []
    for name, layers, base, mu, heights, lengths, path in [
        (
            "rough",
            [(1.0, 0.3, None)],
            None,
            0.4,
            bounded_contacts.rough((12, 11), 13),
            (1.0, 1.1),
            [(0.02, (0, 0)), (0.02, (0.004, 0.002)), (0.03, (-0.002, 0.004))],
        ),
        (
            "sphere",
            [(1.0, 0.1, None)],
            None,
            0.3,
            friction_contacts.sphere(13),
            (1.0, 1.0),
            [(0.004, (0, 0)), (0.004, (0.002, 0.001)), (0.004, (0.004, 0.0))],
        ),
        (
            "rough on a slab",
            [(1.0, 0.3, 0.2)],
            "bonded",
            0.4,
            bounded_contacts.rough((12, 11), 13),
            (1.0, 1.1),
            [(0.02, (0, 0)), (0.02, (0.004, 0.002)), (0.03, (-0.002, 0.004))],
        ),
        (
            "sphere on a coating",
            [(4.0, 0.25, 0.15), (1.0, 0.4, None)],
            None,
            0.3,
            friction_contacts.sphere(13),
            (1.0, 1.0),
            [(0.004, (0, 0)), (0.004, (0.002, 0.001)), (0.004, (0.004, 0.0))],
        ),
    ]:
        (young, nu, height), *below = layers
        G = (
            tangential_matrix(heights.shape, lengths, young, nu)
            if height is None
            else layered_matrix(heights.shape, lengths, layers, base)
        )
        clearance = (heights.max() - heights).ravel()
        states, before = [], None
        for mean, lateral in path:
            before = friction_contacts.increment(G, clearance, mean, mu, lateral, before)
            states.append(
                {
                    "mean_pressure": mean,
                    "lateral": list(lateral),
                    "approach": before["delta"],
                    "contact_nodes": before["touch"],
                    "sticking_nodes": before["stick"],
                    "pressure": rounded(before["p"]),
                    "shear": rounded(before["tau"].ravel()),
                }
            )
        cases.append(
            {
                "name": name,
                "layers": [list(layer) for layer in layers],
                "base": base,
                "points": list(heights.shape),
                "lengths": list(lengths),
                "coefficient": mu,
                "heights": heights.ravel().tolist(),
                "states": states,
            }
        )
    result["friction"] = cases

    cases = []
    for nu, height, base, heights, lengths, mean, approach in [
        (0.3, 0.1, "bonded", rough24, (1.0, 1.0), 0.02, None),
        (0.5, 0.3, "bonded", rough24, (1.0, 1.0), None, 0.03),
        (0.0, 0.04, "bonded", rough20, (1.0, 0.9), 0.1, None),
        (0.4, 0.2, "sliding", rough20, (1.0, 0.9), None, 0.02),
        (0.3, 0.1, "bonded", profile, (1.0, 1.0), 0.02, None),
        (0.5, 0.3, "bonded", profile, (1.0, 1.0), None, 0.03),
        (0.1, 0.02, "sliding", profile, (1.0, 1.0), None, 0.01),
    ]:
        G = slab_matrix(heights.shape, lengths, nu, height, base)
        clearance = (heights.max() - heights).ravel()
        p, delta, found, stiffness, _, _ = bounded_contacts.solve(G, clearance, None, mean, approach)
        print("slab", nu, height, base, found, delta, (p > 0).mean())
        cases.append(
            {
                "poisson": nu,
                "height": height,
                "base": base,
                "points": list(heights.shape),
                "lengths": list(lengths),
                "heights": heights.ravel().tolist(),
                "control": "mean_pressure" if approach is None else "approach",
                "mean_pressure": found if mean is None else mean,
                "approach": delta if approach is None else approach,
                "stiffness": stiffness,
                "contact_nodes": int((p > 0).sum()),
                "pressure": rounded(p),
            }
        )
    result["slabs"] = cases

    cases = []
    for law, gamma, reach, body, heights, lengths, mean, approach in [
        ("exponential", 2e-4, 0.02, None, rough24, (1.0, 1.0), 0.02, None),
        ("exponential", 2e-4, 0.02, None, rough24, (1.0, 1.0), None, -0.005),
        ("exponential", 2e-4, 0.02, (0.3, 0.1, "bonded"), rough24, (1.0, 1.0), None, 0.01),
        ("morse", 5e-4, 0.03, None, rough20, (1.0, 0.9), 0.01, None),
        ("morse", 5e-4, 0.03, None, rough20, (1.0, 0.9), None, -0.01),
        ("morse", 5e-4, 0.03, (0.4, 0.2, "sliding"), rough20, (1.0, 0.9), None, 0.02),
        ("exponential", 2e-4, 0.02, (0.3, 0.1, "bonded"), profile, (1.0, 1.0), None, 0.01),
    ]:
        points = heights.shape
        G = bounded_contacts.free_matrix(points, lengths) if body is None else slab_matrix(points, lengths, *body)
        clearance = (heights.max() - heights).ravel()
        made = {"exponential": exponential, "morse": morse}[law](gamma, reach)
        if mean is None:
            delta = approach
        else:
            delta = brentq(
                lambda delta: with_law(G, clearance, made, delta)[0].mean() - mean, 0.0, 0.1, xtol=1e-16, rtol=1e-15
            )
        p, gap, energy, elastic = with_law(G, clearance, made, delta)
        print(law, body, p.mean(), delta, (gap <= 0).mean(), energy, elastic)
        poisson, height, base = body or (0.0, None, "bonded")
        cases.append(
            {
                "law": law,
                "gamma": gamma,
                "range": reach,
                "poisson": poisson,
                "height": height,
                "base": base,
                "points": list(points),
                "lengths": list(lengths),
                "heights": heights.ravel().tolist(),
                "control": "mean_pressure" if approach is None else "approach",
                "mean_pressure": p.mean() if mean is None else mean,
                "approach": delta,
                "interface_energy": energy,
                "elastic_energy": elastic,
                "pressure": rounded(p),
                "gap": rounded(gap),
            }
        )
    result["laws"] = cases
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "free_contacts.json"), "w") as f:
        json.dump(result, f)
        f.write("\n")


if __name__ == "__main__":
    main()
