"""A small kappa sweep: area over load in the limit of an infinitely fine, infinitely large, fractal surface."""

import sys

import gfmd
import matplotlib.pyplot as plt

k = gfmd.kappa_sweep("smoke")
ax = k.plot()
ax.set_title(f"kappa = {k.fit.kappa_tfc:.3f}")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "kappa.png", bbox_inches="tight")
assert 1.0 < k.fit.kappa_tfc < 3.5
