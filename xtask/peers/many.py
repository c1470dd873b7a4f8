"""Times `gfmd.many` over a stack of surfaces, on all cores.

    many.py '{"heights": FILE.npy, "p_star": P}'

The array is [surface, x, y]. Prints one JSON object: wall time, from the arrays to the last contact.
"""

import json
import sys
import time

import gfmd
import numpy as np


def main():
    task = json.loads(sys.argv[1])
    stack = np.load(task["heights"])
    started = time.perf_counter()
    contacts = gfmd.many((gfmd.Surface(heights) for heights in stack), gfmd.Body(), p_star=task["p_star"])
    count = sum(1 for _ in contacts)
    assert count == len(stack)
    print(json.dumps({"seconds": time.perf_counter() - started}))


main()
