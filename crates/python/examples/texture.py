"""A texture designed for a given stiffness: the amplitudes of three waves by gradient descent through the contact."""

import sys

import gfmd
import matplotlib.pyplot as plt
import numpy as np

body = gfmd.Body(young=1.0, poisson=0.3)
x, y = np.meshgrid(np.arange(48) / 48, np.arange(48) / 48, indexing="ij")
waves = np.array([np.cos(2 * np.pi * k * x) * np.cos(2 * np.pi * k * y) for k in (1, 2, 3)])
low, high, target = 0.002, 0.004, 0.8


def secant(amplitudes: np.ndarray) -> tuple[float, np.ndarray]:
    """Returns the secant stiffness between two approaches and its derivatives by the amplitudes."""
    heights = np.tensordot(amplitudes, waves, 1)
    ends = [gfmd.contact(heights, body, approach=approach) for approach in (low, high)]
    gradients = [end.vjp(mean_pressure=1.0).heights for end in ends]
    stiffness = (ends[1].mean_pressure - ends[0].mean_pressure) / (high - low)
    return stiffness, np.tensordot(waves, (gradients[1] - gradients[0]) / (high - low), 2)


amplitudes, history = np.array([0.005, 0.001, 0.0005]), []
for _ in range(30):
    stiffness, slope = secant(amplitudes)
    history.append(stiffness)
    if abs(stiffness - target) < 1e-6:
        break
    amplitudes = amplitudes - (stiffness - target) / (slope @ slope) * slope  # Newton step along the gradient

plt.plot(history, "o-")
plt.axhline(target, color="k", ls="--", label="target")
plt.xlabel("step")
plt.ylabel("stiffness (E / cell length)")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "texture.png", bbox_inches="tight")
assert abs(secant(amplitudes)[0] - target) < 1e-5 < abs(history[0] - target)
