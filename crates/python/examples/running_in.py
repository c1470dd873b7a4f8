"""Running-in: a rough surface wears until its whole surface carries the load evenly."""

import sys

import gfmd
import matplotlib.pyplot as plt
import numpy as np

surface = gfmd.self_affine(n=64, eps_f_inv=16, rms_gradient=0.1)
legs = [0.0, *np.geomspace(1e-3, 1.0, 30)]
worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=legs, p_star=0.05, steps=1)

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5))
worn.plot("distance", "area_fraction", left)
left.set_xscale("symlog", linthresh=1e-3)
row = int(worn.wear_depth[-1].max(axis=0).argmax())
for waypoint in (0, 15, 20, 25):
    profile = surface.heights[:, row] - worn.wear_depth[waypoint][:, row]
    right.plot(profile, label=f"after {worn.steps.distance[waypoint]:.2g}")
right.set_xlabel("point along x")
right.set_ylabel("height left")
right.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "running_in.png", bbox_inches="tight")
# Fully run in: full contact, with the mean pressure everywhere.
assert worn.steps.area_fraction[-1] == 1.0
assert worn.steps.max_pressure[-1] < 1.01 * worn.steps.mean_pressure[-1]
