"""The coefficients BAND and EDGE of crates/measure/src/self_affine.rs, from the points of composed.json and low.json, and the
error of the formula on those and on the other surfaces of seeds.json. Needs numpy and scipy.

    python3 data/results/formula.py
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.special import erf

LIMIT = [0.43659, 0.64579, 8.06942, 5.40178, 15.36096]
LIGHTEST = 0.01


def points(name):
    """H, eps_f, eps_c, p*, kappa without its edge, standard error, counted kappa, edge."""
    rows = []
    for point in json.loads((Path(__file__).parent / f"{name}.json").read_text())["points"]:
        if point["p_star"] < LIGHTEST:
            continue
        edge, eps_c = point["kappa"] - point["kappa_corrected"], 1 / point["eps_c_inv"]
        kappa = point["kappa"] - (0.82 + 0.3 * eps_c) * edge
        error = max(point["kappa_corrected_sem"], 1e-4)
        rows.append([point["hurst"], 1 / point["eps_f_inv"], eps_c, point["p_star"], kappa, error, point["kappa"], edge])
    return np.array(rows).T


def kappa_of_band(b, h, eps_f, p):
    c, rest = LIMIT, 1 - h
    band = eps_f ** (b[1] + b[2] * rest)
    first = c[0] * rest ** c[1] + b[0] * band
    falls = c[2] * rest * p + (c[3] + c[4] * h) * p**2 + b[3] * (1 + b[5] * rest) * band * p ** b[4]
    return erf(np.sqrt(2) * (1 + 1 / (1 / first + falls)) * p) / p


def edge_of(e, h, eps_f, eps_c, p, area):
    log = e[0] + e[1] * h + e[2] * h**2 + (e[3] + e[4] * h) * np.log(eps_c) + e[5] * h * np.log(eps_f)
    return np.exp(log + e[6] * np.log(np.clip(1 - area, 1e-3, 1)) + e[7] * np.log(p))


def main():
    fitted, others = np.hstack([points("composed"), points("low")]), points("seeds")
    h, eps_f, eps_c, p, kappa, error, counted, edge = fitted
    starts = [1, 0.3, 0.3, 5, 0.5, 0], [0.5, 0.2, 0.5, 2, 0.7, 0], [2, 0.5, 0, 10, 1, 0]
    misfit = lambda b: (kappa_of_band(b, h, eps_f, p) / kappa - 1) / np.hypot(error / kappa, 0.004)
    band = min((least_squares(misfit, start, max_nfev=4000) for start in starts), key=lambda found: found.cost).x
    misfit = lambda e: (edge_of(e, h, eps_f, eps_c, p, kappa * p) - edge) / (0.01 * counted)
    rim = least_squares(misfit, [1, 0, 0, 1, 0, 0, 0.5, 0], max_nfev=5000).x
    print("BAND", band.tolist())
    print("EDGE", rim.tolist())
    for name, (h, eps_f, eps_c, p, kappa, _, counted, _) in (("fitted", fitted), ("others", others)):
        model = kappa_of_band(band, h, eps_f, p)
        whole = model + (0.82 + 0.3 * eps_c) * edge_of(rim, h, eps_f, eps_c, p, model * p)
        for what, errors in (("area", model / kappa - 1), ("counted area", whole / counted - 1)):
            print(f"{name}, {what}: {100 * np.sqrt((errors**2).mean()):.2f} % rms, at most {100 * abs(errors).max():.1f} %")


if __name__ == "__main__":
    main()
