#!/usr/bin/python3
"""A ball under forces of tables and expressions, integrated by SciPy (DOP853, rtol 1e-13).

Prints the JSON of tests/data/laws.json: place and velocity at 2 s. Independent of unlatch: the smooth table is a
scipy.interpolate.CubicSpline (not a knot) over the speed of splines over x; the linear one is numpy.interp; the expressions are written out."""
import json

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

MASS, END = 2.0, 2.0
X = np.array([-2, -1.2, -0.5, 0, 0.6, 1.3, 2])
SPEED = np.array([0, 1, 2, 4.0])
VALUES = np.array([[1.1, 1.6, 2.2, 3.4], [2.9, 2.2, 1.4, 0.3], [2.6, 2.5, 2.1, 1.9], [3.0, 3.0, 3.1, 3.3], [-1.2, -1.4, -1.9, -3.0],
                   [-2.4, -2.1, -1.6, -0.2], [-4.0, -4.4, -5.0, -6.6]])
TIMES, PUSHES = [0, 0.5, 1, 2], [0, 2, -1, 0.5]


OVER_X = [CubicSpline(X, VALUES[:, j]) for j in range(len(SPEED))]


def look_up(x, speed):
    column = np.array([s(min(max(x, X[0]), X[-1])) for s in OVER_X])
    return float(CubicSpline(SPEED, column)(min(max(speed, SPEED[0]), SPEED[-1])))


def flow(t, y):
    p, v = y[:3], y[3:]
    speed = np.linalg.norm(v)
    force = [look_up(p[0], speed),
             -1.5 * p[1] * (1 + 0.2 * np.sin(3 * t)) - 0.1 * v[1] * speed,
             np.interp(t, TIMES, PUSHES) * np.exp(-0.3 * t) + 0.2 * np.arctan2(p[1], 1 + p[0]**2)]
    return np.concatenate([v, np.array(force) / MASS])


def main():
    y = np.array([1.0, 0, 0, 0, 1, 0])
    for begin, end in zip(TIMES[:-1], TIMES[1:]):  # no corner inside
        y = solve_ivp(flow, (begin, end), y, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    print(json.dumps({"about": "tests/references/laws_reference.py", "position": list(y[:3]), "velocity": list(y[3:])}, indent=1))


if __name__ == "__main__":
    main()
