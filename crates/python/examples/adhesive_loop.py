"""Loading and unloading with adhesion: the hysteresis loop and the energy lost in jumps."""

import sys

import gfmd
import matplotlib.pyplot as plt

surface = gfmd.self_affine(n=48, eps_f_inv=6, rms_gradient=0.1)
law = gfmd.law("exponential", gamma=1e-4, range=3e-3)
loop = gfmd.path(surface, gfmd.Body(), law=law, approach=[-0.003, 0.010, -0.006], steps=12)

ax = loop.plot("approach", "mean_pressure")
ax.axhline(0, color="k", lw=0.5)
ax.set_title(f"lost: {loop.dissipated:.2e} per area")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "adhesive_loop.png", bbox_inches="tight")
assert loop.lowest_mean_pressure < 0
