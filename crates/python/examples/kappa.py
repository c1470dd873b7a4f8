"""A small kappa sweep: contact area per load in the limit of an infinitely fine, infinitely large, fractal surface."""

import sys

import gfmd
import matplotlib.pyplot as plt

# Small grids, which take a few seconds; use gfmd.kappa_sweep("default") for a result to quote.
points = {"eps_t_inv": [1, 2], "eps_f_inv": [4, 8], "eps_c_inv": [4, 8], "centre": [2, 8, 4]}
k = gfmd.kappa_sweep({"points": points, "statistics": {"realisations": 3}, "fit": {"resamples": 500}})
ax = k.plot()
ax.set_title(f"kappa = {k.fit.kappa_tfc:.3f}")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "kappa.png", bbox_inches="tight")
assert 1.0 < k.fit.kappa_tfc < 3.5
