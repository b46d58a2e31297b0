#!/usr/bin/python3
"""Tight-tolerance reference of the dual-spin capsule: equations (2.1)-(2.3) of the paper with m rho_C^2 = 0, SciPy's DOP853 at
rtol 1e-13; constants as in hil/scenarios/capsule/reference.yaml. Independent of unlatch: no multibody code, no quaternions.

    capsule_reference.py    writes tests/data/capsule_ode.json; needs python3-scipy
"""
import json
import pathlib

import numpy as np
from scipy.integrate import solve_ivp

A2, C2, A1, A1K, C1, C1K, T = 180.0, 120.0, 90.0, 30.0, 60.0, 15.0, 20.0
START = [0.03, 0.05, 0.2, 6.0, 0, 0, 0, 0]  # p, q, r, sigma, gamma, psi, phi, delta
CASES = {"free": 0.0, "friction": -1.5}      # M_delta, N m


def rate(t, y, moment):
    p, q, r, sigma, gamma, _, phi, _ = y
    a, c1 = A2 + A1 + (A1K - A1) * t / T, C1 + (C1K - C1) * t / T
    b = C2 + c1 - a
    turn = p * np.cos(phi) - q * np.sin(phi)
    return [-(b * q * r + c1 * q * sigma) / a, (b * p * r + c1 * p * sigma) / a, -moment / C2, moment / c1 + moment / C2,
            p * np.sin(phi) + q * np.cos(phi), turn / np.cos(gamma), r - np.tan(gamma) * turn, sigma]


if __name__ == "__main__":
    times = [float(t) for t in range(0, 21, 2)]
    result = {"about": "tests/references/capsule_reference.py: (2.1)-(2.3), DOP853 at 1e-13. t: p, q, r, sigma, gamma, psi, phi, delta"}
    for name, moment in CASES.items():
        out = solve_ivp(rate, (0, T), START, method="DOP853", t_eval=times, rtol=1e-13, atol=1e-13, args=(moment,))
        result[name] = {str(t): [float(x) for x in y] for t, y in zip(times, out.y.T)}
    (pathlib.Path(__file__).parent.parent / "data/capsule_ode.json").write_text(json.dumps(result, indent=1) + "\n")
