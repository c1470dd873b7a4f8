"""A soft coating on a rigid substrate: at one load, a thinner coating has a smaller contact area."""

import sys

import gfmd
import matplotlib.pyplot as plt
import numpy as np

surface = gfmd.self_affine(n=128, rms_gradient=0.01)
heights = np.geomspace(0.01, 1.0, 12)
areas = [gfmd.contact(surface, gfmd.Body(poisson=0.3, height=height), p_star=0.1).area_fraction for height in heights]
free = gfmd.contact(surface, gfmd.Body(poisson=0.3), p_star=0.1).area_fraction

plt.semilogx(heights, areas, "o-", label="coating bonded to a rigid base")
plt.axhline(free, color="k", ls="--", label="half-space")
plt.xlabel("height of the coating (cell length)")
plt.ylabel("contact area fraction")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "coating.png", bbox_inches="tight")
assert abs(areas[-1] - free) < 1e-3 < free - areas[0]
