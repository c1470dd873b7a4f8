"""A sphere on a half-space, compared with the Hertz pressure."""

import sys

import gfmd
import matplotlib.pyplot as plt
import numpy as np

n, length, radius, e_star = 256, 1.0, 5.0, 1.0
x = (np.arange(n) - n / 2) * length / n
distance = np.hypot(*np.meshgrid(x, x, indexing="ij"))
sphere = gfmd.Surface(-(distance**2) / (2 * radius), size=length)

a = 0.1  # contact radius, small compared with the cell
force = 4 * e_star * a**3 / (3 * radius)
c = gfmd.contact(sphere, gfmd.Body(e_star=e_star), pressure=force / length**2)

hertz = 2 * e_star * a / (np.pi * radius) * np.sqrt(np.maximum(1 - (x / a) ** 2, 0))
plt.plot(x, c.pressure[:, n // 2], ".", label="gfmd")
plt.plot(x, hertz, label="Hertz")
plt.xlim(-0.15, 0.15)
plt.xlabel("x (cell)")
plt.ylabel("pressure (E*)")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "hertz.png", bbox_inches="tight")
assert abs(c.max_pressure / hertz.max() - 1) < 0.03
