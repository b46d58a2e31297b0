#!/usr/bin/python3
"""A block on rough feet, twice. A blow: it falls flat on three feet at once, sliding and spinning; Newton's law along the normals and
Coulomb's on impulses, by trying all 27 combinations of feet that leave, stick and slip, each solved by SciPy's least squares, of which
those are solutions that keep all inequalities. A run: four feet of unequal load, pushed to and fro above the floor, stick and slip:
one coordinate, SciPy's DOP853 at rtol 1e-12 from event to event. Independent of unlatch: no iteration over feet, no rows.

    rough_feet_reference.py    writes tests/data/rough_feet.json; needs python3-scipy
"""
import itertools
import json
import pathlib

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

MASS, INERTIA, HEIGHT, G = 2.0, np.array([0.02, 0.03, 0.04]), 0.25, 9.81  # kg, kg m², m: of the middle above the floor
FEET = [(-0.25, -0.2), (0.25, -0.1), (0.05, 0.2)]                         # m
FRICTION, RESTITUTION = 0.6, 0.3
BEFORE = np.array([-0.55, 0.65, -0.8, 0, 0, 3.0])                         # m/s, rad/s
TIMES, FORCES = [0, 0.4, 1.0, 2.0], [0, 10.0, -2.0, -12.0]                # s, N: along x, at the middle
PUSHED = 0.3                                                              # friction of the run


def rates(x, y):
    """Rows of the velocity of a foot's lowest point: along z, x, y."""
    arm = np.array([x, y, -HEIGHT])
    rows = np.zeros((3, 6))
    for k, axis in enumerate(np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])):
        rows[k, :3], rows[k, 3:] = axis, np.cross(arm, axis)
    return rows


def find_blow():
    J = np.vstack([rates(*foot) for foot in FEET])
    back = np.diag(1 / np.array([MASS] * 3 + list(INERTIA)))
    before = J @ BEFORE
    wanted = -RESTITUTION * before[::3]
    found = []
    for modes in itertools.product("lsg", repeat=len(FEET)):  # it leaves, sticks, glides
        def lack(p):
            after, out = before + J @ back @ J.T @ p, []
            for i, mode in enumerate(modes):
                u, q = after[3 * i:3 * i + 3], p[3 * i:3 * i + 3]
                if mode == "l":
                    out += list(q)
                elif mode == "s":
                    out += [u[0] - wanted[i], u[1], u[2]]
                else:
                    out += [u[0] - wanted[i], *(q[1:] * np.hypot(*u[1:]) + FRICTION * q[0] * u[1:])]
            return np.array(out)

        for start in range(8):
            guess = np.random.default_rng(start).normal(size=J.shape[0])
            guess[::3] = np.abs(guess[::3])
            result = least_squares(lack, guess, xtol=1e-15, ftol=1e-15, gtol=1e-15)
            if np.abs(result.fun).max() > 1e-11:
                continue
            p, after = result.x, before + J @ back @ J.T @ result.x
            good = True
            for i, mode in enumerate(modes):
                u, q = after[3 * i:3 * i + 3], p[3 * i:3 * i + 3]
                good &= {"l": u[0] >= wanted[i] - 1e-10, "s": q[0] >= 0 and np.hypot(*q[1:]) <= FRICTION * q[0],
                         "g": q[0] > 0 and np.hypot(*u[1:]) > 1e-9 and q[1:] @ u[1:] < 0}[mode]
            if good and not any(np.allclose(v, BEFORE + back @ J.T @ p, atol=1e-8) for _, v in found):
                found.append(("".join(modes), BEFORE + back @ J.T @ p))
    assert len(found) == 1, found
    return found[0]


def run():
    def push(t):
        return np.interp(t, TIMES, FORCES)

    hold, t, y, sign, events = PUSHED * MASS * G, 0.0, np.zeros(2), 0, []
    knots = TIMES[1:]
    for end in knots:
        while t < end:
            if sign == 0:
                line = lambda s: abs(push(s)) - hold
                if line(t + 1e-12) < 0:
                    # the push is linear up to `end`
                    a, b = push(t), push(end)
                    out = [s for s in (t + (end - t) * (k * hold - a) / (b - a) for k in (1, -1)) if t + 1e-12 < s < end]
                    if not out:
                        t = end
                        break
                    t = min(out)
                sign = 1 if push(t + 1e-9) > 0 else -1
                events.append(t)
            stop = lambda s, v: sign * v[1]
            stop.terminal, stop.direction = True, -1
            went = solve_ivp(lambda s, v: [v[1], (push(s) - sign * hold) / MASS], (t, end), y, method="DOP853", rtol=1e-12, atol=1e-15,
                             events=[stop], max_step=1e-2)
            t, y = went.t[-1], went.y[:, -1].copy()
            if went.status == 1:
                y[1] = 0
                events.append(t)
                sign = 0 if abs(push(t)) <= hold else (1 if push(t) > 0 else -1)
                if sign != 0:
                    continue
    return {"t": TIMES[-1], "place": float(y[0]), "speed": float(y[1]), "changes": [float(e) for e in events]}


if __name__ == "__main__":
    modes, after = find_blow()
    result = {"about": "tests/references/rough_feet_reference.py. blow: velocity, angular velocity after it, and whether each foot leaves (l), sticks (s) or glides (g)",
              "blow": {"modes": modes, "velocity": [float(v) for v in after[:3]], "spin": [float(v) for v in after[3:]]}, "run": run()}
    (pathlib.Path(__file__).parent.parent / "data/rough_feet.json").write_text(json.dumps(result, indent=1) + "\n")
