"""Contact area against load, with Persson's theory and its limit, and the limit of Bush, Gibson and Thomas."""

import math
import sys

import gfmd
import matplotlib.pyplot as plt
import numpy as np

surface = gfmd.self_affine(n=256, hurst=0.8, rms_gradient=0.1, eps_f_inv=32)
loads = np.geomspace(0.01, 1.5, 12)
cs = gfmd.contacts(surface, gfmd.Body(young=70e9, poisson=0.33), p_star=loads)

ax = cs.plot()
p = np.geomspace(0.01, 1.5, 200)
ax.plot(p, [math.erf(value * math.sqrt(2)) for value in p], "k-", label="Persson")
ax.plot(p, np.minimum(p * math.sqrt(8 / math.pi), 1), "k:", label=r"$\kappa = \sqrt{8/\pi}$")
ax.plot(p, np.minimum(p * math.sqrt(2 * math.pi), 1), "k--", label=r"$\kappa = \sqrt{2\pi}$")
ax.set_xscale("log")
ax.set_yscale("log")
ax.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "area_load.png", bbox_inches="tight")
assert np.all(np.diff(cs.area_fraction) > 0)
