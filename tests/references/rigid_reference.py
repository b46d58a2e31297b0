#!/usr/bin/python3
"""Tight-tolerance reference of a chain of two links that falls from a hinge, bounces on a rigid floor with its end, slides on it
and lifts off: planar, in the two angles of the links, so that neither joints nor the floor need constraints while they are apart;
SciPy's DOP853 at rtol 1e-13 from event to event. Independent of unlatch: Lagrange's equations, no bodies, no rows.

    rigid_reference.py    writes tests/data/rigid.json; needs python3-scipy
"""
import json
import math
import pathlib

import numpy as np
from scipy.integrate import solve_ivp

L1, A1, M1, J1 = 0.8, 0.4, 2.0, 0.15  # m, m, kg, kg m²: length, centre of mass, mass, inertia about it
L2, A2, M2, J2 = 0.6, 0.3, 1.0, 0.04
RADIUS, FLOOR, G = 0.05, -0.8, 9.81   # m: of the ball at the end; height of the floor under the hinge; m/s²
RESTITUTION, SETTLE = 0.2, 2e-3       # s
START = [0.3, -0.2, 0.0, 0.0]         # angles above the horizontal, their rates
END = 1.7                             # s


def gap(y):
    return L1 * math.sin(y[0]) + L2 * math.sin(y[1]) - RADIUS - FLOOR


def slope(y):
    return np.array([L1 * math.cos(y[0]), L2 * math.cos(y[1])])


def masses(y):
    coupling = M2 * L1 * A2 * math.cos(y[0] - y[1])
    return np.array([[J1 + M1 * A1**2 + M2 * L1**2, coupling], [coupling, J2 + M2 * A2**2]])


def solve(y, closed):
    """Returns accelerations and the force of the floor."""
    turn = M2 * L1 * A2 * math.sin(y[0] - y[1])
    load = np.array([-turn * y[3]**2 - (M1 * A1 + M2 * L1) * G * math.cos(y[0]), turn * y[2]**2 - M2 * A2 * G * math.cos(y[1])])
    free = np.linalg.solve(masses(y), load)
    if not closed:
        return free, 0.0
    j = slope(y)
    back = np.linalg.solve(masses(y), j)
    force = (L1 * math.sin(y[0]) * y[2]**2 + L2 * math.sin(y[1]) * y[3]**2 - j @ free) / (j @ back)
    return free + force * back, force


def rates(_, y, closed):
    a, _force = solve(y, closed)
    return [y[2], y[3], a[0], a[1]]


def gap_acceleration(y):
    a, _force = solve(y, False)
    return slope(y) @ a - L1 * math.sin(y[0]) * y[2]**2 - L2 * math.sin(y[1]) * y[3]**2


def touching(_, y, closed):
    return gap(y)


def pulling(_, y, closed):
    return solve(y, True)[1]


if __name__ == "__main__":
    touching.terminal = pulling.terminal = True
    touching.direction = pulling.direction = -1
    t, y, closed, events, impulse = 0.0, np.array(START), False, [], 0.0
    while True:
        guard = pulling if closed else touching
        out = solve_ivp(rates, (t, END), y, method="DOP853", rtol=1e-13, atol=1e-15, args=(closed,), events=[guard], max_step=2e-3)
        if out.status == 0:
            break
        t, y = out.t[-1], out.y[:, -1].copy()
        if closed:
            events.append({"t": t, "name": "lift"})
            closed = False
            # It leaves with no speed: go on to where the gap is open, so that the same zero is not found again.
            out = solve_ivp(rates, (t, t + 1e-3), y, method="DOP853", rtol=1e-13, atol=1e-15, args=(False,))
            t, y = out.t[-1], out.y[:, -1].copy()
            assert gap(y) > 0
            continue
        events.append({"t": t, "name": "touch"})
        j, before = slope(y), slope(y) @ y[2:]
        g = -gap_acceleration(y)
        settles = 2 * RESTITUTION * -before < SETTLE * g
        back = np.linalg.solve(masses(y), j)
        p = -(1 + (0.0 if settles else RESTITUTION)) * before / (j @ back)
        impulse += p
        y[2:] += p * back
        closed = settles
        if not settles:
            events.append({"t": t, "name": "lift"})
    result = {"about": "tests/references/rigid_reference.py: DOP853 at 1e-13. state: angles and their rates at t; impulse: of the bounces alone",
              "events": events, "t": END, "state": [float(v) for v in out.y[:, -1]], "impulse": float(impulse)}
    (pathlib.Path(__file__).parent.parent / "data/rigid.json").write_text(json.dumps(result, indent=1) + "\n")
