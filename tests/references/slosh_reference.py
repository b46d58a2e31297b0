#!/usr/bin/python3
"""An upper stage with a pendulum and a mass on springs for its propellant, in a plane, integrated by SciPy (DOP853, rtol 1e-12).

Prints the JSON of tests/data/slosh.json. Independent of unlatch: Lagrange's equations of X, Y, the stage's angle a, the pendulum's angle
b and the path d of the mass, with the mass matrix from the Jacobians of the three bodies. Constants as in hil/scenarios/slosh."""
import json

import numpy as np
from scipy.integrate import solve_ivp

THRUST, STAGE, TURNS = 90e3, 7500.0, 42e3
M1, LENGTH, HINGE = 1100.0, 0.65, 1.2
M2, PLACE = 500.0, -1.5
OMEGA2 = THRUST / (STAGE + M1 + M2) / LENGTH
GYRATION2, ZETA, END = 0.05**2, 0.005, 10.0
C1, K2, C2 = 2 * ZETA * M1 * LENGTH**2 * np.sqrt(OMEGA2), M2 * OMEGA2, 2 * ZETA * M2 * np.sqrt(OMEGA2)


def e(a):
    return np.array([np.cos(a), np.sin(a)])


def n(a):
    return np.array([-np.sin(a), np.cos(a)])


def flow(t, y):
    _, _, a, b, d, _, _, wa, wb, vd = y
    # Jacobians of places to (X, Y, a, b, d), and what is left of the accelerations.
    j0 = np.hstack([np.eye(2), np.zeros((2, 3))])
    j1 = j0.copy()
    j1[:, 2], j1[:, 3] = HINGE * n(a), -LENGTH * n(b)
    r1 = -HINGE * wa**2 * e(a) + LENGTH * wb**2 * e(b)
    j2 = j0.copy()
    j2[:, 2], j2[:, 4] = PLACE * n(a) - d * e(a), n(a)
    r2 = -PLACE * wa**2 * e(a) - d * wa**2 * n(a) - 2 * vd * wa * e(a)
    mass = STAGE * j0.T @ j0 + M1 * j1.T @ j1 + M2 * j2.T @ j2 + np.diag([0, 0, TURNS + M2 * GYRATION2, M1 * GYRATION2, 0])
    jet = 3e3 * np.sin(np.pi * t / 0.4) if t < 0.4 else 0.0
    force = np.concatenate([THRUST * e(a) + jet * n(a), [3 * jet - C1 * (wa - wb), C1 * (wa - wb), -K2 * d - C2 * vd]])
    force -= M1 * j1.T @ r1 + M2 * j2.T @ r2
    return np.concatenate([y[5:], np.linalg.solve(mass, force)])


def main():
    y = np.zeros(10)
    for begin, end in ((0, 0.4), (0.4, END)):
        y = solve_ivp(flow, (begin, end), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    print(json.dumps({"about": "tests/references/slosh_reference.py", "place": list(y[:2]), "turn": y[2], "swing": y[3] - y[2], "path": y[4],
                      "rate": y[7], "path_rate": y[9]}, indent=1))


if __name__ == "__main__":
    main()
