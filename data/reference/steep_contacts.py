"""Frictionless contacts with finite slopes, solved densely: writes steep_contacts.json beside itself.

Independent of gfmd: numpy and scipy. Run: python3 steep_contacts.py

A rigid surface of clearance c(x) is lowered by d onto a linearly elastic half-space. A point x of the body touches
where c(x + u_x) - d - u_z = 0, and the traction there is p (grad c(x + u_x), -1), the force that the constraint exerts.
Displacements follow from tractions by the closed forms for a half-space, wave by wave (Johnson 1985, sections 2.3 and
3.2), as a dense matrix; c is scipy's spline, periodic (profiles) or through several copies of the cell (surfaces). The
unknowns u_x, u_y, p and d are found together by Newton's method with differences for the Jacobian, and the set of
points in contact by exchange. Odd grids have no shortest wave.
"""

import json
import os

import numpy as np
from scipy.interpolate import CubicSpline, RectBivariateSpline

# points, lengths, nu, rms gradient, seed, mean pressure or approach
CASES = [
    ((33, 1), (1.0, 1.0), 0.0, 0.1, 1, ("mean_pressure", 0.02)),
    ((33, 1), (1.3, 1.0), 0.3, 0.3, 2, ("mean_pressure", 0.05)),
    ((33, 1), (1.0, 1.0), 0.5, 0.4, 3, ("mean_pressure", 0.05)),
    ((33, 1), (1.0, 1.0), 0.2, 0.2, 4, ("approach", 0.02)),
    ((13, 13), (1.0, 1.0), 0.0, 0.2, 5, ("mean_pressure", 0.02)),
    ((13, 11), (1.0, 0.9), 0.3, 0.3, 6, ("mean_pressure", 0.05)),
    ((11, 13), (1.0, 1.1), 0.3, 0.15, 7, ("approach", 0.03)),
]


def compliance(points, lengths, nu):
    """Displacements (u_x, u_y, u_z) from tractions (t_x, t_y, t_z), E* = 1, as a dense matrix; z is outward."""
    nx, ny = points
    young = 1 - nu**2
    beta = (1 - 2 * nu) * (1 + nu) / young
    qx = 2 * np.pi * np.fft.fftfreq(nx, 1 / nx) / lengths[0]
    qy = 2 * np.pi * np.fft.fftfreq(ny, 1 / ny) / lengths[1]
    n = nx * ny
    columns = np.eye(n).reshape(n, nx, ny)
    spectra = np.fft.fft2(columns)
    q = np.hypot(qx[:, None], qy[None, :])
    q[0, 0] = 1
    ex, ey = qx[:, None] / q, qy[None, :] / q
    along, across = 2 * (1 - nu**2) / (young * q), 2 * (1 + nu) / (young * q)
    couple = beta / (1j * q)
    block = {
        (0, 0): along * ex**2 + across * ey**2,
        (0, 1): (along - across) * ex * ey,
        (1, 1): along * ey**2 + across * ex**2,
        (0, 2): couple * ex,
        (1, 2): couple * ey,
        (2, 2): along,
    }
    matrix = np.zeros((3 * n, 3 * n))
    for (a, b), values in block.items():
        values = values + 0j
        values[0, 0] = 0
        field = np.fft.ifft2(spectra * values)
        assert abs(field.imag).max() < 1e-12
        matrix[a * n : (a + 1) * n, b * n : (b + 1) * n] = field.real.reshape(n, n).T
        if a != b:
            matrix[b * n : (b + 1) * n, a * n : (a + 1) * n] = field.real.reshape(n, n)
    return matrix


def surface(points, lengths, gradient, seed):
    random = np.random.default_rng(seed)
    nx, ny = points
    x, y = np.meshgrid(np.arange(nx) / nx, np.arange(ny) / ny, indexing="ij")
    h, squares = np.zeros(points), 0
    for m in range(-3, 4):
        for n in range(0 if ny == 1 else -3, 1 if ny == 1 else 4):
            size = np.hypot(m, n)
            if 0 < size <= 3:
                amplitude = random.standard_normal() / size**1.5
                h += amplitude * np.cos(2 * np.pi * (m * x + n * y + random.random()))
                squares += 0.5 * amplitude**2 * (2 * np.pi) ** 2 * ((m / lengths[0]) ** 2 + (n / lengths[1]) ** 2)
    return h * gradient / np.sqrt(squares)


def spline(clearance, lengths):
    """Returns a function: positions -> c, dc/dx, dc/dy."""
    nx, ny = clearance.shape
    if ny == 1:
        line = CubicSpline(
            np.arange(nx + 1) * lengths[0] / nx, np.append(clearance[:, 0], clearance[0, 0]), bc_type="periodic"
        )
        return lambda x, y: (line(x % lengths[0]), line(x % lengths[0], 1), 0 * x)
    copies = 7
    tiled = np.tile(clearance, (copies, copies))
    at = [np.arange(copies * n) * length / n for n, length in zip((nx, ny), lengths)]
    whole = RectBivariateSpline(*at, tiled, kx=3, ky=3, s=0)
    middle = [length * (copies // 2) for length in lengths]

    def evaluate(x, y):
        x, y = x % lengths[0] + middle[0], y % lengths[1] + middle[1]
        return whole.ev(x, y), whole.ev(x, y, dx=1), whole.ev(x, y, dy=1)

    return evaluate


def solve(points, lengths, nu, heights, load):
    n = points[0] * points[1]
    matrix = compliance(points, lengths, nu)
    clearance = heights.max() - heights
    c = spline(clearance, lengths)
    x, y = (
        field.ravel()
        for field in np.meshgrid(*(np.arange(m) * length / m for m, length in zip(points, lengths)), indexing="ij")
    )
    kind, value = load

    def state(unknown):
        ux, uy, p, d = unknown[:n], unknown[n : 2 * n], unknown[2 * n : 3 * n], unknown[3 * n]
        height, cx, cy = c(x + ux, y + uy)
        u = matrix @ np.concatenate([p * cx, p * cy, -p])
        return u, height - d - u[2 * n :]

    def equations(unknown, touching):
        u, gap = state(unknown)
        p, d = unknown[2 * n : 3 * n], unknown[3 * n]
        last = p.mean() - value if kind == "mean_pressure" else d - value
        return np.concatenate([unknown[: 2 * n] - u[: 2 * n], np.where(touching, gap, p), [last]])

    d = value if kind == "approach" else np.quantile(clearance, 0.3)
    touching = clearance.ravel() < d
    unknown = np.zeros(3 * n + 1)
    unknown[3 * n] = d
    for _ in range(100):
        for _ in range(30):
            f = equations(unknown, touching)
            if abs(f).max() < 1e-14:
                break
            step = 1e-7
            jacobian = np.empty((3 * n + 1, 3 * n + 1))
            for k in range(3 * n + 1):
                moved = unknown.copy()
                moved[k] += step
                ahead = equations(moved, touching)
                moved[k] -= 2 * step
                jacobian[:, k] = (ahead - equations(moved, touching)) / (2 * step)
            unknown = unknown - np.linalg.solve(jacobian, f)
        u, gap = state(unknown)
        p = unknown[2 * n : 3 * n]
        wrong = (touching & (p < -1e-14)) | (~touching & (gap < -1e-14))
        if not wrong.any():
            break
        touching = touching ^ wrong
    else:
        raise ValueError("the points in contact do not settle")
    residual = abs(equations(unknown, touching)).max()
    assert residual < 1e-13, residual
    return {
        "pressure": p.tolist(),
        "displacement": u.reshape(3, n).tolist(),
        "gap": gap.tolist(),
        "approach": unknown[3 * n],
        "touching": int(touching.sum()),
    }


def main():
    cases = []
    for points, lengths, nu, gradient, seed, load in CASES:
        heights = surface(points, lengths, gradient, seed)
        found = solve(points, lengths, nu, heights, load)
        print(
            points, nu, gradient, load, found["touching"], "mean p", np.mean(found["pressure"]), "d", found["approach"]
        )
        cases.append(
            {
                "points": points,
                "lengths": lengths,
                "poisson": nu,
                "heights": heights.ravel().tolist(),
                "load": dict([load]),
                **found,
            }
        )
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "steep_contacts.json")
    with open(path, "w") as file:
        json.dump({"origin": "steep_contacts.py: half-spaces of E* = 1, dense Newton solutions", "cases": cases}, file)
        file.write("\n")


main()
