"""Area and pressure of independent asperities, in another way than the program: adaptive quadrature over the principal
curvatures and the height of a summit (Longuet-Higgins 1957, Nayak 1971), Hertz contact with the elliptic integrals of
SciPy.

    python3 asperity_theories.py > asperity_theories.json
"""

import json
import math

from scipy.integrate import dblquad, quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1


def hertz(k1, k2):
    """Area over w and force over E* w^{3/2} of a paraboloid with principal curvatures k1 >= k2."""
    if k1 - k2 < 1e-6 * k1:
        return math.pi / k1, 4.0 / 3.0 / math.sqrt(k1)

    def misfit(log_ratio):
        g = math.exp(log_ratio)
        k, e = ellipkm1(g * g), ellipe(1.0 - g * g)
        return (e / g**2 - k) / (k - e) - k1 / k2

    g = math.exp(brentq(misfit, -30.0, -1e-7, xtol=1e-14))
    m = 1.0 - g * g
    k, e = ellipkm1(g * g), ellipe(m)
    square = 2.0 * (k - e) / (k * m * k2)
    return math.pi * g * square, 2.0 * math.pi / 3.0 * math.sqrt(square) / k


def over_height(mean, scatter, power):
    """Mean of w^power over w > 0 for a normal distribution of w."""
    low, high = max(0.0, mean - 12 * scatter), max(0.0, mean) + 12 * scatter
    weight = lambda w: w**power * math.exp(-0.5 * ((w - mean) / scatter) ** 2) / (math.sqrt(2 * math.pi) * scatter)
    return quad(weight, low, high, points=[max(low, mean)] if mean > low else None, epsabs=0, epsrel=1e-9, limit=400)[0]


def bush_gibson_thomas(m0, m2, m4, separation):
    scatter = math.sqrt(m0 - 1.5 * m2**2 / m4)
    result = []
    for part, power in ((0, 1.0), (1, 1.5)):

        def integrand(k2, k1):
            # Jacobian of (t, r) = ((k1 + k2)/2, (k1 - k2)/2) is 1/2.
            t, r = 0.5 * (k1 + k2), 0.5 * (k1 - k2)
            density = k1 * k2 / (2 * math.pi * m2)
            of_t = math.exp(-0.75 * t * t / m4) / math.sqrt(4 * math.pi * m4 / 3)
            of_r = 3 * r / m4 * math.exp(-1.5 * r * r / m4)
            mean = 1.5 * m2 / m4 * t - separation
            return 0.5 * density * of_t * of_r * hertz(k1, k2)[part] * over_height(mean, scatter, power)

        top = 12.0 * math.sqrt(m4)
        result.append(dblquad(integrand, 0.0, top, 1e-12, lambda k1: k1 * (1 - 1e-12), epsabs=0, epsrel=1e-6)[0])
    return result


def greenwood_williamson(m0, m2, m4, separation):
    alpha = m0 * m4 / m2**2
    density = m4 / (6 * math.pi * math.sqrt(3) * m2)
    radius = 0.375 * math.sqrt(math.pi / m4)
    scatter = math.sqrt(m0 * (1 - 0.8968 / alpha))
    mean = 4 * math.sqrt(m0 / (math.pi * alpha)) - separation
    area = math.pi * radius * density * over_height(mean, scatter, 1.0)
    return [area, 4.0 / 3.0 * math.sqrt(radius) * density * over_height(mean, scatter, 1.5)]


if __name__ == "__main__":
    cases = []
    for m0, m2, m4, level in [(1.0, 1.0, 2.0, 2.0), (0.04, 0.005, 0.08, 3.0), (2.5e-3, 5e-3, 1.0, 1.0)]:
        separation = level * math.sqrt(m0)
        cases.append(
            {
                "m0": m0,
                "m2": m2,
                "m4": m4,
                "separation": separation,
                "bush_gibson_thomas": bush_gibson_thomas(m0, m2, m4, separation),
                "greenwood_williamson": greenwood_williamson(m0, m2, m4, separation),
            }
        )
    print(json.dumps({"columns": ["area fraction", "mean pressure / E*"], "cases": cases}, indent=1))
