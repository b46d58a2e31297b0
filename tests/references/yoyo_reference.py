#!/usr/bin/python3
"""Yo-yo despin in a plane, integrated by SciPy (DOP853, rtol 1e-13).

Prints the JSON of tests/data/yoyo.json. Constants as in hil/scenarios/yoyo, with the cords in the plane of the centre of mass;
both masses free at once, and the second one 60 ms late. Independent of unlatch: a mass is described by the angle of the tangent
point and the length of the tangent, Lagrange's equations are written out, and no path is ever measured:

    P = C + R u(b) - s t(b),   u = (cos b, sin b),  t = (-sin b, cos b),   q = s - R b
    stretch x = q + R theta + const,  T = k x + c x'
    q'' = s b'^2 - T/m + C''.t,   s b'' = R b'^2 - 2 s' b' - C''.u
"""
import json

import numpy as np
from scipy.integrate import solve_ivp

SPIN, INERTIA, MASS, TIP, R, BALL = 120 * 2 * np.pi / 60, 16.0, 180.0, 0.8, 0.4, 0.03
K, C, TENSION, FIRE, END = 2e4, 20.0, 20.0, 0.2, 1.5
RHO = R + BALL
STRAIGHT = np.sqrt(RHO**2 - R**2)
LENGTH = np.sqrt(RHO**2 + INERTIA / (2 * TIP))
WOUND = (LENGTH - STRAIGHT + TENSION / K) / R
OWN = 0.4 * TIP * BALL**2  # inertia of a mass, which counts while it is held
SIDES = (0.0, np.pi)       # angles of the masses about the satellite
OFFSET = TIP * RHO / (MASS + TIP)  # offset of the centre of mass of the satellite with the second mass, towards that
BOTH = INERTIA + OWN + MASS * TIP / (MASS + TIP) * RHO**2


def u(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def t(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


def begin(side, theta, rate):
    """Releases a mass: it has moved with the satellite."""
    b = side + np.arctan(STRAIGHT / R) + theta
    return [STRAIGHT - R * b, b, -R * rate, rate]


def get_wound(side, theta, b):
    return WOUND + side + np.arctan(STRAIGHT / R) + theta - b


def measure(y, i):
    """Returns stretch of a cord, and its force."""
    q, b, q_rate, _ = y[6 + 4 * i:10 + 4 * i]
    x = q + R * b + R * get_wound(SIDES[i], y[2], b) - LENGTH
    return x, max(0.0, K * x + C * (q_rate + R * y[5])) if x > 0 else 0.0


def flow(_, y, free, on):
    theta, rate = y[2], y[5]
    force, torque = np.zeros(2), 0.0
    pulls = [measure(y, i)[1] if free[i] and on[i] else 0.0 for i in range(2)]
    for i in range(2):
        b = y[7 + 4 * i]
        arm = R * u(b) - (0 if free[1] else OFFSET * u(theta + np.pi))
        pull = -pulls[i] * t(b)
        force += pull
        torque += arm[0] * pull[1] - arm[1] * pull[0]
    if free[1]:
        centre, turn = force / MASS, torque / INERTIA
    else:
        e = u(theta + np.pi)
        turn = torque / BOTH
        centre = force / (MASS + TIP) - OFFSET * (turn * t(theta + np.pi) - rate**2 * e)
    out = [*y[3:6], *centre, turn]
    for i in range(2):
        q, b, q_rate, b_rate = y[6 + 4 * i:10 + 4 * i]
        s, s_rate = q + R * b, q_rate + R * b_rate
        if not free[i]:
            out += [0, 0, 0, 0]
            continue
        out += [q_rate, b_rate, s * b_rate**2 - pulls[i] / TIP + centre @ t(b), (R * b_rate**2 - 2 * s_rate * b_rate - centre @ u(b)) / s]
    return out


def get_tip(y, i):
    q, b, q_rate, b_rate = y[6 + 4 * i:10 + 4 * i]
    s, s_rate = q + R * b, q_rate + R * b_rate
    return y[:2] + R * u(b) - s * t(b), y[3:5] + (R * b_rate - s_rate) * t(b) + s * b_rate * u(b)


def fly(late):
    theta = SPIN * FIRE
    y = np.array([0, 0, theta, 0, 0, SPIN, *begin(SIDES[0], theta, SPIN), *begin(SIDES[1], theta, SPIN)])
    now, free, on, tips, times, peaks = FIRE, [True, late == 0], [True, True], [None, None], {}, [0.0, 0.0]
    while any(on):
        def unwound(i):
            def event(_, state, *__):
                return get_wound(SIDES[i], state[2], state[7 + 4 * i]) if free[i] else 1.0
            event.terminal = True
            return event
        watch = [i for i in range(2) if on[i]]
        end = END if free[1] else FIRE + late
        run = solve_ivp(flow, (now, end), y, "DOP853", args=(list(free), list(on)), events=[unwound(i) for i in watch], rtol=1e-13,
                        atol=1e-14, max_step=1e-3)
        for state in run.y.T:
            for i in watch:
                if free[i]:
                    stretch, force = measure(state, i)
                    assert stretch > 0 and force > 0, "a cord is slack: its law has a corner"
                    peaks[i] = max(peaks[i], force)
        now, y = run.t[-1], run.y[:, -1].copy()
        if run.status == 0:
            assert not free[1], "a cord does not unwind"
            free[1] = True
            y[10:14] = begin(SIDES[1], y[2], y[5])
            continue
        i = watch[next(k for k, times_ in enumerate(run.t_events) if len(times_))]
        times[f"release:cord{i + 1}"], on[i], tips[i] = float(now), False, get_tip(y, i)
        for k in watch:  # both at once, apart from rounding
            if k != i and abs(get_wound(SIDES[k], y[2], y[7 + 4 * k])) < 1e-11:
                times[f"release:cord{k + 1}"], on[k], tips[k] = float(now), False, get_tip(y, k)
    return {"events": times, "rate": float(y[5]), "satellite": [float(v) for v in y[3:5]], "peaks": peaks,
            "tips": [[float(v) for v in tip[1]] for tip in tips]}


def main():
    print(json.dumps({"about": "tests/references/yoyo_reference.py", "both": fly(0), "late": fly(0.06)}, indent=1))


if __name__ == "__main__":
    main()
