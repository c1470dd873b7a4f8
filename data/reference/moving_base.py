"""Contacts of slabs, layers and a plate whose base moves, solved densely: writes moving_base.json beside itself.

Independent of gfmd: numpy, mpmath and the scripts beside this one. Run: python3 moving_base.py

For every wave the displacement of the unloaded surface by a displaced base, or by a traction on the lower face of a
plate, is the boundary-value problem of layered_bodies.py with 40 digits, with the conditions at the base as its
right-hand side. The contact is found by dense active sets on the sum of the compliance under pressure and of this
displacement. 24 x 24 points; the field of the base has no shortest wave.
"""

import json
import os

import mpmath as mp
import numpy as np

from bounded_contacts import solve
from layered_bodies import Wave, normal_matrix

N, LENGTHS = 24, (1.0, 1.2)
CASES = [
    ("displacement", ([(1.0, 0.3, 0.2)], "bonded"), 3, None, 0.004),
    ("displacement", ([(2.0, 0.2, 0.04), (0.5, 0.45, 0.1), (1.5, 0.3, 0.3)], "bonded"), 3, 0.003, None),
    ("displacement", ([(1.0, 0.3, 0.2)], "sliding"), 1, 0.005, None),
    ("traction", ([(1.0, 0.3, 0.4)], "free"), 3, 0.003, None),
]


class Moved(Wave):
    """A body whose base has the displacement (a, w), or the outward traction (tau, s), in place of zero."""

    def lifted(self, kind, given):
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
        add([at(0, self.tops[0], 2)], 0)
        add([at(0, self.tops[0], 3)], 0)
        for layer in range(len(self.layers) - 1):
            for what in range(4):
                add([at(layer, self.tops[layer + 1], what), at(layer + 1, self.tops[layer + 1], what, -1)], 0)
        last = len(self.layers) - 1
        # The outward traction below is minus the stress.
        what, sign = {"bonded": ((0, 1), 1), "sliding": ((2, 1), 1), "free": ((2, 3), -1)}[self.base]
        for k, value in zip(what, given):
            add([at(last, self.tops[-1], k)], sign * value)
        factors = mp.lu_solve(mp.matrix(rows), mp.matrix(right))
        return self.state(factors, 0, self.tops[0])[1]


def noise(components, seed):
    """Waves of numbers up to three, amplitude 0.004, [x, y, component]."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(N) / N, np.arange(N) / N, indexing="ij")
    field = np.zeros((N, N, components))
    for c in range(components):
        for m in range(-3, 4):
            for n in range(-3, 4):
                if (m, n) != (0, 0):
                    field[..., c] += (
                        0.001 * random.standard_normal() * np.cos(2 * np.pi * (m * x + n * y + random.random()))
                    )
    return field


def lift(kind, body, field):
    spectrum = np.fft.fft2(field, axes=(0, 1))
    kx, ky = 2 * np.pi * np.fft.fftfreq(N, 1 / N) / LENGTHS[0], 2 * np.pi * np.fft.fftfreq(N, 1 / N) / LENGTHS[1]
    found, memory = np.zeros((N, N), complex), {}
    for i in range(N):
        for j in range(N):
            if i == j == 0:
                found[0, 0] = spectrum[0, 0, -1] if kind == "displacement" else 0
                continue
            if np.abs(spectrum[i, j]).max() < 1e-12 * np.abs(spectrum).max():
                continue
            q = np.hypot(kx[i], ky[j])
            key = round(q, 9)
            if key not in memory:
                wave = Moved(body, q)
                memory[key] = [float(wave.lifted(kind, given)) for given in ((1, 0), (0, 1))]
            along, normal = memory[key]
            found[i, j] += normal * spectrum[i, j, -1]
            if field.shape[2] == 3:
                # u_long = i a and sigma_long = i tau.
                found[i, j] += along * (kx[i] * spectrum[i, j, 0] + ky[j] * spectrum[i, j, 1]) / q / 1j
    return np.fft.ifft2(found).real


def main():
    random = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(N) / N, np.arange(N) / N, indexing="ij")
    heights = sum(
        0.01 / (m * m + n * n) * random.standard_normal() * np.cos(2 * np.pi * (m * x + n * y + random.random()))
        for m in range(-4, 5) for n in range(-4, 5) if (m, n) != (0, 0)
    )
    cases = []
    for number, (kind, body, components, mean, approach) in enumerate(CASES):
        field = noise(components, number)
        if kind == "traction":
            field *= 0.5
        lifted = lift(kind, body, field)
        G = normal_matrix([body], (N, N), LENGTHS)
        under = heights + lifted
        p, delta, found, _, _, _ = solve(G, (under.max() - under).ravel(), None, mean, approach)
        u = lifted.ravel() - G @ p
        rounded = lambda values: [float("%.13e" % v) for v in np.ravel(values)]
        cases.append(
            {
                "kind": kind,
                "layers": [list(layer) for layer in body[0]],
                "base": body[1],
                "components": components,
                "field": rounded(field),
                "lift": rounded(lifted),
                "mean_pressure": mean or found,
                "approach": approach or delta,
                "control": "pressure" if mean else "approach",
                "contact_nodes": int((p > 0).sum()),
                "pressure": rounded(p),
                "displacement_z": rounded(u),
            }
        )
        print(kind, body[1], int((p > 0).sum()), np.abs(lifted).max(), u.min())
    result = {
        "title": "Frictionless contacts over a base that moves",
        "conventions": (
            "heights: peaks point at the body; field [x, y, component]: displacement of the base, or traction on the"
            " lower face; components 1: z"
        ),
        "points": [N, N],
        "lengths": list(LENGTHS),
        "heights": rounded(heights),
        "cases": cases,
    }
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "moving_base.json"), "w") as file:
        json.dump(result, file)
        file.write("\n")


if __name__ == "__main__":
    main()
