"""A sticking flat punch and the stress below it."""

import sys

import gfmd
import matplotlib.pyplot as plt

punch = gfmd.punch(gfmd.Body(young=70.0, poisson=0.33, height=1.27), n=64, contact="sticking", nodes="inclusive")
below = gfmd.interior(punch, levels=32, quantities=["von-mises"])

middle = below.von_mises[:, :, 32]
plt.imshow(middle, extent=(0, punch.size[0], punch.height, 0), cmap="magma", aspect="equal")
plt.colorbar(label="von Mises stress (GPa)")
plt.xlabel("x (µm)")
plt.ylabel("depth (µm)")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "punch.png", bbox_inches="tight")
assert punch.converged and middle.max() > punch.mean_pressure
