"""A scan in an instrument format (X3P, ISO 25178-72): read, fill holes, level, make periodic, press.

The file holds a generated surface, tilted, with some undefined points.
"""

import sys
from pathlib import Path

import gfmd
import matplotlib.pyplot as plt

scan = gfmd.read(Path(__file__).with_name("scan.x3p"), fill="harmonic")
print(scan, scan.details)
surface = scan.detrend("plane").periodise("mirror")
c = gfmd.contact(surface, gfmd.Body(young=70e9, poisson=0.33), pressure=2e9)

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4))
scan.detrend("plane").plot(left)
left.set_title(f"{scan.n[0]} x {scan.n[1]} points, {scan.undefined} filled")
c.plot("pressure", right)
right.set_title(f"{100 * c.area_fraction:.1f} % in contact")
figure.tight_layout()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "scan.png", bbox_inches="tight")
assert scan.unit == "m" and scan.undefined > 0 and c.converged
