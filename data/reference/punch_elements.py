"""The punch of the thesis by finite elements with its own nodes: trilinear elements on the 128 x 128 nodes of the
surface.

A sticking square punch a quarter of the cell wide holds the nodes strictly inside its edge (eq. 4.7); all other nodes
of the surface are free, the base is fixed, the cell repeats. The elements are bricks of the spacing of the surface,
`layers` of them along the height. Since all cells of the lattice are equal, the elements are solved wave by wave: a
block-tridiagonal system along the height, eliminated from the base up; the forces on the held nodes follow by conjugate
gradients to 1e-12. No Green's function of a continuum is used. Stresses at nodes are the mean of those of the elements
around them, that is central differences.

Run: python punch_elements.py (NumPy); writes punch3d_elements/ beside itself: u_n128.npy [x, y, component];
section_y.npy and section_x.npy, the planes through the middle, [level from the surface down, point, (u_x, u_y, u_z, xx,
yy, zz, yz, xz, xy)], every second node; summary.json.
"""
import json
import os

import numpy as np

YOUNG, NU, L, ZM, DEPTH, N = 70.0, 0.33, 1.27, 1.27, 0.005, 128
HERE = os.path.dirname(os.path.abspath(__file__))
C44 = YOUNG / (2 * (1 + NU))
C12 = YOUNG * NU / ((1 + NU) * (1 - 2 * NU))
C11 = C12 + 2 * C44


def element(h):
    """Stiffness of a trilinear brick with sides h, [node (a, b, c), component, node, component], 2 x 2 x 2 Gauss
    points.
    """
    C = np.zeros((6, 6))
    C[:3, :3] = C12
    C[range(3), range(3)] = C11
    C[range(3, 6), range(3, 6)] = C44
    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    K = np.zeros((24, 24))
    for point in np.ndindex(2, 2, 2):
        x = 0.5 + (np.array(point) - 0.5) / np.sqrt(3)
        B = np.zeros((6, 24))
        for n, corner in enumerate(corners):
            f = [x[d] if corner[d] else 1 - x[d] for d in range(3)]
            s = [(1 if corner[d] else -1) / h[d] for d in range(3)]
            g = [s[0] * f[1] * f[2], f[0] * s[1] * f[2], f[0] * f[1] * s[2]]
            for row, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]):
                B[row, 3 * n + i] += g[j]
                if i != j:
                    B[row, 3 * n + j] += g[i]
        K += B.T @ C @ B * np.prod(h) / 8
    return K.reshape(2, 2, 2, 3, 2, 2, 2, 3)


def waves(layers):
    """Stiffness of the surface nodes for all waves, and the factors that carry a displacement one level down."""
    h = (L / N, L / N, ZM / layers)
    K = element(h)
    px = 2 * np.pi * np.fft.fftfreq(N)[:, None]
    py = 2 * np.pi * np.fft.rfftfreq(N)[None, :]
    A = np.zeros((2, 2, N, N // 2 + 1, 3, 3), complex)
    for a, b, c, d, e, f in np.ndindex(2, 2, 2, 2, 2, 2):
        phase = np.exp(1j * (px * (d - a) + py * (e - b)))
        A[c, f] += phase[..., None, None] * K[a, b, c, :, d, e, f, :]
    inner = A[0, 0] + A[1, 1]
    S, down = inner, []
    for level in range(1, layers):
        gain = -np.linalg.solve(S, A[0, 1])  # u below, from u above
        down.append(gain)
        S = (A[1, 1] if level == layers - 1 else inner) + A[1, 0] @ gain
    return S, down[::-1]


def apply(M, u):
    spectrum = np.fft.rfft2(u, axes=(0, 1))
    return np.fft.irfft2(np.einsum("xyij,xyj->xyi", M, spectrum), s=u.shape[:2], axes=(0, 1))


def punch(S):
    """Displacement of the surface, and the forces on its held nodes."""
    i = np.arange(N) / N
    inside = (0.375 < i) & (i < 0.625)
    held = (inside[:, None] & inside[None, :])[..., None]
    G = np.linalg.inv(S)
    asked = np.zeros((N, N, 3))
    asked[..., 2] = -DEPTH
    f, r, p, last = np.zeros_like(asked), asked * held, 0.0, np.inf
    for _ in range(500):
        if np.abs(r).max() < 1e-12 * DEPTH:
            break
        z = apply(S, r) * held
        slope = (r * z).sum()
        p = z + slope / last * p
        last = slope
        image = apply(G, p)
        step = slope / (p * image).sum()
        f += step * p
        r -= step * image * held
    u = apply(G, f)
    assert np.abs((u - asked) * held).max() < 1e-11 * DEPTH
    return u, f


def sections(u, down, layers):
    """Displacement and stress on y = L/2 and x = L/2, level by level from the surface."""
    spectrum = np.fft.rfft2(u, axes=(0, 1))
    levels = [u]
    for gain in down:
        spectrum = np.einsum("xyij,xyj->xyi", gain, spectrum)
        levels.append(np.fft.irfft2(spectrum, s=(N, N), axes=(0, 1)))
    levels.append(np.zeros_like(u))
    levels = levels[: layers + 1]
    h, hz = L / N, ZM / layers
    out = [[], []]
    for k, u in enumerate(levels):
        gx = (np.roll(u, -1, 0) - np.roll(u, 1, 0)) / (2 * h)
        gy = (np.roll(u, -1, 1) - np.roll(u, 1, 1)) / (2 * h)
        above, below = levels[max(k - 1, 0)], levels[min(k + 1, layers)]
        gz = (above - below) / (hz * (min(k + 1, layers) - max(k - 1, 0)))
        e = [gx[..., 0], gy[..., 1], gz[..., 2]]
        trace = sum(e)
        stress = [C12 * trace + 2 * C44 * part for part in e]
        stress += [C44 * (gz[..., 1] + gy[..., 2]), C44 * (gz[..., 0] + gx[..., 2]), C44 * (gy[..., 0] + gx[..., 1])]
        both = np.concatenate([u, np.stack(stress, -1)], -1)
        out[0].append(both[:, N // 2])
        out[1].append(both[N // 2, :])
    return [np.array(section) for section in out]


def main():
    folder = os.path.join(HERE, "punch3d_elements")
    os.makedirs(folder, exist_ok=True)
    spectral = np.load(os.path.join(HERE, "punch3d_sticking_zm1_nu033", "discrete_strict_u_n128.npy"))
    runs = []
    for layers in (64, 128, 256):
        S, down = waves(layers)
        u, f = punch(S)
        error = np.sqrt(((u - spectral) ** 2).mean((0, 1))) / DEPTH
        pressure = -f[..., 2].sum() / L**2
        runs.append({"layers": layers, "mean_pressure": pressure, "error": error.tolist()})
        print(layers, pressure, error)
        if layers != N:
            continue
        np.save(os.path.join(folder, "u_n128.npy"), u)
        for name, section in zip("yx", sections(u, down, layers)):
            np.save(os.path.join(folder, f"section_{name}.npy"), section[::2, ::2].astype("f4"))
    content = {
        "conventions": (
            "error: sqrt(<(u - u_spectral)^2>) / depth of u_x, u_y, u_z (eq. 4.13) against discrete_strict_u_n128.npy;"
            " mean pressure in GPa; layers of elements along the height, 128 are cubes. Made by punch_elements.py"
        ),
        "runs": runs,
    }
    with open(os.path.join(folder, "summary.json"), "w") as out:
        json.dump(content, out, indent=1)


if __name__ == "__main__":
    main()
