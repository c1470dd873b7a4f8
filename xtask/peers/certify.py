"""Judges final pressures of any program: contact residuals from fresh transforms, and differences from a reference.

    certify.py '{"heights": FILE.npy, "mean_pressure": P, "fields": {NAME: FILE.npy, ...}, "reference": NAME,
                 "boundary": "periodic" or "free", "hardness": P or null}'

Half-space with E* = 1 in a cell of length 1, or, with free boundaries, loaded on this cell alone; heights have their
peaks pointing at the body. Prints one JSON object: for every name the residuals (defined below), contact area fraction,
approach beyond first touch, elastic energy per area, and the differences from the reference. A field that has a point
that is no number, or carries no load, is left out.
"""

import json
import sys

import numpy as np


# A pressure that is less than the hardness by this part of it is at the hardness.
ROUNDING = 1e-9


def periodic(pressure):
    """Applies the inverse of the stiffness E* |q| / 2; the mean of the displacement is zero."""
    nx, ny = pressure.shape
    qx = 2 * np.pi * np.fft.fftfreq(nx, 1 / nx)
    qy = 2 * np.pi * np.fft.rfftfreq(ny, 1 / ny)
    q = np.hypot(qx[:, None], qy[None, :])
    q[0, 0] = np.inf
    return np.fft.irfft2(2 * np.fft.rfft2(pressure) / q, s=pressure.shape)


def free(pressure):
    """Adds up the displacements at the centres of the cells by the uniform pressures on the cells (Love 1929)."""
    nx, ny = pressure.shape
    x = np.minimum(np.arange(2 * nx), 2 * nx - np.arange(2 * nx))[:, None] / nx
    y = np.minimum(np.arange(2 * ny), 2 * ny - np.arange(2 * ny))[None, :] / ny

    def primitive(x, y):
        return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

    left, right, below, above = x - 0.5 / nx, x + 0.5 / nx, y - 0.5 / ny, y + 0.5 / ny
    cell = primitive(right, above) - primitive(left, above) - primitive(right, below) + primitive(left, below)
    padded = np.fft.irfft2(np.fft.rfft2(cell / np.pi) * np.fft.rfft2(pressure, s=cell.shape), s=cell.shape)
    return padded[:nx, :ny]


def judge(heights, pressure, task):
    asked, hardness = task["mean_pressure"], task.get("hardness") or np.inf
    inwards = (free if task.get("boundary") == "free" else periodic)(pressure)
    rms_height = heights.std()
    # The gap is known up to a constant, the approach, which makes its mean over the contact zero, but for the points at
    # the hardness, which are pressed in further.
    yields = pressure >= hardness * (1 - ROUNDING)
    contact = (pressure > 0) & ~yields
    gap = heights.max() - heights + inwards
    approach = gap[contact].mean() if contact.any() else gap[yields].max()
    gap -= approach
    total = pressure.sum()
    elastic = np.where(yields, 0.0, gap)
    residual = {
        "complementarity": abs((pressure * elastic).sum()) / (total * rms_height),
        "penetration": max(0.0, -elastic.min()) / rms_height,
        "negative_pressure": max(0.0, -pressure.min()) / pressure.mean(),
        "load": abs(pressure.mean() - asked) / asked,
    }
    if hardness < np.inf:
        gaps = gap[yields].max(initial=0.0) / rms_height
        residual["saturation"] = max(gaps, (pressure.max() - hardness) / hardness, 0.0)
    return {
        "residual": residual,
        "area_fraction": (pressure > 0).mean(),
        "approach": approach / rms_height,
        "energy": 0.5 * (pressure * inwards).mean() / (pressure.mean() * rms_height),
    }


def differ(pressure, reference):
    return {
        "points": int(np.count_nonzero((pressure > 0) != (reference > 0))),
        "pressure": float(np.sqrt(((pressure - reference) ** 2).mean() / (reference**2).mean())),
    }


def main():
    task = json.loads(sys.argv[1])
    heights = np.load(task["heights"])
    reference = np.load(task["fields"][task["reference"]])
    judged = {}
    for name, file in task["fields"].items():
        pressure = np.load(file)
        if pressure.shape != heights.shape:
            sys.exit(f"{name}: pressure on {pressure.shape} points, heights on {heights.shape}")
        if np.isfinite(pressure).all() and pressure.sum() > 0:
            judged[name] = judge(heights, pressure, task) | {"differs": differ(pressure, reference)}
    print(json.dumps(judged))


if __name__ == "__main__":
    main()
