"""Judges final pressures of any program: contact residuals from fresh transforms, and differences from a reference.

    certify.py '{"heights": FILE.npy, "mean_pressure": P, "fields": {NAME: FILE, ...}, "reference": NAME}'

Half-space with E* = 1 in a cell of length 1; heights have their peaks pointing at the body. A field is FILE.npy, or the
first load of /fields/pressure in FILE.h5. Prints one JSON object: for every name the residuals (defined below), contact
area fraction, approach beyond first touch, elastic energy per area, and the differences from the reference.
"""

import json
import sys

import numpy as np


def read(file):
    if not file.endswith(".h5"):
        return np.load(file)
    import h5py

    with h5py.File(file, "r") as archive:
        return archive["/fields/pressure"][0]


def displacement_into_body(pressure):
    """Applies the inverse of the stiffness E* |q| / 2; the mean of the displacement is zero."""
    nx, ny = pressure.shape
    qx = 2 * np.pi * np.fft.fftfreq(nx, 1 / nx)
    qy = 2 * np.pi * np.fft.rfftfreq(ny, 1 / ny)
    q = np.hypot(qx[:, None], qy[None, :])
    q[0, 0] = np.inf
    return np.fft.irfft2(2 * np.fft.rfft2(pressure) / q, s=pressure.shape)


def judge(heights, pressure, asked):
    contact = pressure > 0
    inwards = displacement_into_body(pressure)
    rms_height = heights.std()
    # The gap is known up to a constant, the approach, which makes its mean over the contact zero.
    clearance = heights.max() - heights
    gap = clearance + inwards
    approach = gap[contact].mean()
    gap -= approach
    total = pressure.sum()
    return {
        "residual": {
            "complementarity": abs((pressure * gap).sum()) / (total * rms_height),
            "penetration": max(0.0, -gap.min()) / rms_height,
            "negative_pressure": max(0.0, -pressure.min()) / pressure.mean(),
            "load": abs(pressure.mean() - asked) / asked,
        },
        "area_fraction": contact.mean(),
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
    reference = read(task["fields"][task["reference"]])
    judged = {}
    for name, file in task["fields"].items():
        pressure = read(file)
        if pressure.shape != heights.shape:
            sys.exit(f"{name}: pressure on {pressure.shape} points, heights on {heights.shape}")
        judged[name] = judge(heights, pressure, task["mean_pressure"]) | {"differs": differ(pressure, reference)}
    print(json.dumps(judged))


main()
