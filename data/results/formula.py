"""The coefficients of crates/measure/src/self_affine.rs: COEFFICIENTS and COVARIANCE from the limits of ladders.json,
BAND and EDGE from its points, and the error of the formula on those and on the other surfaces of ladders-2.json. Needs
numpy, scipy.

    python3 data/results/formula.py
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.special import erf

LIGHTEST = 0.01


def report(name):
    return json.loads((Path(__file__).parent / f"{name}.json").read_text())


def limits(name):
    """H, p*, kappa, relative error: the statistical one and 0.1 % for the form."""
    fits = [fit for fit in report(name)["fits"] if fit["area"] == "raw"]
    rows = [[f["hurst"], f["p_star"], f["kappa_tfc"], f["kappa_tfc_standard_error"] / f["kappa_tfc"]] for f in fits]
    h, p, kappa, error = np.array(rows).T
    return h, p, kappa, np.hypot(error, 1e-3)


def points(name):
    """H, eps_f, eps_c, p*, kappa without its edge, relative standard error, counted kappa, edge."""
    rows = []
    for point in report(name)["points"]:
        if point["p_star"] < LIGHTEST:
            continue
        edge, counted = point["edge"], point["kappa"]
        error = max(point["kappa_corrected_sem"], 1e-4) / (counted - edge)
        eps = [1 / point["eps_f_inv"], 1 / point["eps_c_inv"]]
        rows.append([point["hurst"], *eps, point["p_star"], counted - edge, error, counted, edge])
    return np.array(rows).T


def kappa(c, band, h, p, w=0.0, b=None):
    rest = 1 - h
    first = c[0] * rest ** (c[1] + c[5] * h) + band
    falls = c[2] * rest * p + (c[3] + c[4] * h) * p**2
    if b is not None:
        falls = falls + b[3] * (1 + b[5] * rest) * w * p ** b[4]
    return erf(np.sqrt(2) * (1 + 1 / (1 / first + falls)) * p) / p


def kappa_of_band(c, b, h, eps_f, p):
    w = eps_f ** (b[1] + b[2] * (1 - h))
    return kappa(c, b[0] * w, h, p, w, b)


def edge_of(e, h, eps_f, eps_c, p, area):
    log = e[0] + e[1] * h + e[2] * h**2 + (e[3] + e[4] * h) * np.log(eps_c) + e[5] * h * np.log(eps_f)
    return np.exp(log + e[6] * np.log(np.clip(1 - area, 1e-3, 1)) + e[7] * np.log(p))


def shown(name, errors):
    print(f"{name}: {100 * np.sqrt((errors**2).mean()):.2f} % rms, at most {100 * abs(errors).max():.2f} %")


def main():
    h, p, wanted, error = limits("ladders")
    found = least_squares(
        lambda c: (kappa(c, 0.0, h, p) / wanted - 1) / error, [0.44, 0.65, 8, 5, 15, 0.1], x_scale="jac"
    )
    c = found.x
    stretch = max(1.0, 2 * found.cost / (len(h) - len(c)))
    covariance = np.linalg.inv(found.jac.T @ found.jac) * stretch
    print("COEFFICIENTS", np.round(c, 5).tolist())
    print("COVARIANCE", [[float(f"{value:.4e}") for value in row] for row in covariance])
    print("standard errors", np.sqrt(np.diag(covariance)).tolist())
    shown("limits", kappa(c, 0.0, h, p) / wanted - 1)
    h, p, wanted, _ = limits("ladders-2")
    shown("limits of others", kappa(c, 0.0, h, p) / wanted - 1)

    h, eps_f, eps_c, p, wanted, error, counted, edge = points("ladders")
    starts = [1, 0.3, 0.3, 5, 0.5, 0], [0.5, 0.2, 0.5, 2, 0.7, 0], [2, 0.5, 0, 10, 1, 0]
    misfit = lambda b: (kappa_of_band(c, b, h, eps_f, p) / wanted - 1) / np.hypot(error, 0.004)
    band = min((least_squares(misfit, start, max_nfev=4000) for start in starts), key=lambda one: one.cost).x
    misfit = lambda e: (edge_of(e, h, eps_f, eps_c, p, wanted * p) - edge) / (0.01 * counted)
    rim = least_squares(misfit, [1, 0, 0, 1, 0, 0, 0.5, 0], max_nfev=5000).x
    print("BAND", np.round(band, 6).tolist())
    print("EDGE", np.round(rim, 6).tolist())
    for name in ("ladders", "ladders-2"):
        h, eps_f, eps_c, p, wanted, _, counted, _ = points(name)
        model = kappa_of_band(c, band, h, eps_f, p)
        whole = model + edge_of(rim, h, eps_f, eps_c, p, model * p)
        shown(f"{name}, area", model / wanted - 1)
        shown(f"{name}, counted area", whole / counted - 1)


if __name__ == "__main__":
    main()
