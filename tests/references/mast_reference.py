#!/usr/bin/env python3
"""The boom of hil/scenarios/mast until it locks, integrated by SciPy (DOP853, rtol 1e-12): prints the JSON of tests/data/mast.json.

Independent of unlatch: no joints and no reactions. All places follow from four coordinates: the bus's x, y and turn p, and the angle q of
the bars from the boom's axis. In axes of the bus, whose origin is the root, unit i has its hinge at ((2 i - 1) h cos q, h sin q), its bars
turned by +q and -q, and the foot is at (0, 2 h sin q). With the places r(q) of all bodies and the rotation R(p), velocities are
P' + p' S R r + q' R r_q; Newton's equations are projected on the four coordinates.
"""
import json

import numpy as np
from scipy.integrate import solve_ivp

HALF, BAR, STOWED, LOCKED, UNITS = 0.5, 0.8, np.radians(84), np.radians(40), 20
PULL, CABLE, DAMPING, RUB = 600.0, 1400.0, 500.0, 0.5
BUS, BUS_INERTIA, FOOT, FOOT_INERTIA, BAR_INERTIA = 600.0, 250.0, 0.3, 1e-3, BAR * HALF**2 / 3
GAP = 2 * HALF * np.sin(STOWED)
ODD = 2 * np.arange(1, UNITS + 1) - 1
MASSES = np.concatenate([[BUS, FOOT], np.full(UNITS, 2 * BAR)])  # the two bars of a unit have one centre
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
TIMES = (1.0, 3.0, 5.0, 6.5, 7.0)


def place(q):
    """Places of bus, foot and units in axes of the bus, and their first and second derivatives by q; each n x 2."""
    c, s = np.cos(q), np.sin(q)
    zero = np.zeros(1)
    r = np.stack([np.concatenate([zero, zero, ODD * HALF * c]), np.concatenate([zero, [2 * HALF * s], np.full(UNITS, HALF * s)])], 1)
    d = np.stack([np.concatenate([zero, zero, -ODD * HALF * s]), np.concatenate([zero, [2 * HALF * c], np.full(UNITS, HALF * c)])], 1)
    return r, d, np.concatenate([np.zeros((1, 2)), -r[1:]])


def calc_tension(q, rate):
    stretch = 2 * HALF * np.sin(q) - (GAP - PULL / CABLE)
    return max(0.0, CABLE * stretch + DAMPING * 2 * HALF * np.cos(q) * rate)


def flow(_, state):
    _, _, p, q, *speeds = state
    turn, rate = speeds[2], speeds[3]
    R = np.array([[np.cos(p), -np.sin(p)], [np.sin(p), np.cos(p)]])
    r, d, e = (part @ R.T for part in place(q))
    swing, swing_d = r @ TURN.T, d @ TURN.T
    J = np.zeros((len(MASSES), 2, 4))
    J[:, 0, 0] = J[:, 1, 1] = 1
    J[:, :, 2], J[:, :, 3] = swing, d
    bias = -r * turn**2 + 2 * turn * rate * swing_d + e * rate**2
    M = np.einsum("n,nia,nib->ab", MASSES, J, J)
    M[2, 2] += BUS_INERTIA + FOOT_INERTIA + 2 * UNITS * BAR_INERTIA
    M[3, 3] += 2 * UNITS * BAR_INERTIA
    force = -np.einsum("n,nia,ni->a", MASSES, J, bias)
    force[3] -= calc_tension(q, rate) * 2 * HALF * np.cos(q) + UNITS * 4 * RUB * rate
    return np.concatenate([speeds, np.linalg.solve(M, force)])


def locks(_, state):
    return state[3] - LOCKED


def main():
    locks.terminal = True
    run = solve_ivp(flow, (0, 12), [0, 0, 0, STOWED, 0, 0, 0, 0], events=locks, dense_output=True, method="DOP853", rtol=1e-12, atol=1e-14, max_step=5e-3)
    samples = []
    for t in TIMES:
        x, y, p, q = run.sol(t)[:4]
        samples.append({"t": t, "bus": [x, y, p], "angle": q})
    print(json.dumps({"lock": run.t_events[0][0], "rate": run.y_events[0][0][7], "samples": samples}, indent=1))


if __name__ == "__main__":
    main()
