#!/usr/bin/env python3
"""Two rigid stages, six pushers and an umbilical, integrated by SciPy (DOP853, rtol 1e-12, each event a new start).

Prints the JSON of tests/data/interstage.json. Constants as in hil/scenarios/interstage/scenario.yaml, with all bolts breaking
at once at 0.6 s. Independent of unlatch: no multibody code, forces written out, rotation matrices as states.
"""
import json

import numpy as np
from scipy.integrate import solve_ivp

PLANE, BEHIND, RADIUS, STROKE = 4.0, 3.2, 1.15, 0.08
SHARES = (1, 1, 1, 1, 1, 0.7)
MASS, INERTIA = (4500.0, 6000.0), (np.diag([5200.0, 42000, 42000]), np.diag([4800.0, 19000, 19000]))
START, END = 0.6, 3.0
ANGLES = np.radians(22.5 + 60 * np.arange(6))
SPOTS = RADIUS * np.stack([np.zeros(6), np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def unpack(state):
    bodies = state.reshape(2, 18)
    return [(b[:3], b[3:12].reshape(3, 3), b[12:15], b[15:18]) for b in bodies]


def measure(state, k):
    """Returns coordinate of pusher k along the guide and its rate; arms; direction."""
    (p1, R1, v1, w1), (p2, R2, v2, w2) = unpack(state)
    base, end = np.array([PLANE, 0, 0]) + SPOTS[k], np.array([-BEHIND, 0, 0]) + SPOTS[k]
    r2 = R2 @ end
    r1 = p2 + r2 - p1  # the force acts on the base at the follower's point
    n = R1[:, 0]
    line = r1 - R1 @ base
    rate = (v2 + np.cross(R2 @ w2, r2)) - (v1 + np.cross(R1 @ w1, r1))
    return line @ n, rate @ n, r1, r2, n


def pull(state):
    (p1, R1, _, _), (p2, R2, _, _) = unpack(state)
    r1, r2 = R1 @ np.array([PLANE - 0.3, 1.32, 0]), R2 @ np.array([-BEHIND + 0.3, 1.32, 0])
    line = p2 + r2 - p1 - r1
    length = np.linalg.norm(line)
    return 40e3 * (length - 0.8), line / length, r1, r2


def flow(t, state, engaged, plugged):
    bodies = unpack(state)
    force, torque = np.zeros((2, 3)), np.zeros((2, 3))

    def push(f, r1, r2):
        force[0] -= f
        force[1] += f
        torque[0] -= np.cross(r1, f)
        torque[1] += np.cross(r2, f)

    for k in range(6):
        if engaged[k]:
            x, rate, r1, r2, n = measure(state, k)
            size = SHARES[k] * (9000 - 50e3 * x) - 150 * rate / np.hypot(rate, 1e-3)
            push(size * n, r1, r2)
    if plugged:
        size, line, r1, r2 = pull(state)
        if size > 0:
            push(-size * line, r1, r2)
    R1 = bodies[0][1]
    thrust = 15e3 * np.exp(-t / 0.3) * R1[:, 0]
    force[0] += thrust
    torque[0] += np.cross(R1 @ np.array([-6.0, 0, 0]), thrust)
    out = []
    for (p, R, v, w), m, I, f, M in zip(bodies, MASS, INERTIA, force, torque):
        cross = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        out += [v, (R @ cross).ravel(), f / m, np.linalg.solve(I, R.T @ M - np.cross(w, I @ w))]
    return np.concatenate(out)


def make_event(function):
    def event(t, state, *_):
        return function(t, state)
    event.terminal, event.direction = True, 1
    return event


def main():
    v0 = 15e3 * 0.3 * (1 - np.exp(-START / 0.3)) / sum(MASS)  # the joined stages under the thrust
    x0 = 15e3 * 0.3 * (START - 0.3 * (1 - np.exp(-START / 0.3))) / sum(MASS)
    state = np.concatenate([np.concatenate([[x0 + x, 0, 0], np.eye(3).ravel(), [v0, 0, 0], [0, 0, 0]]) for x in (0, PLANE + BEHIND)])
    engaged, plugged, t, events = [True] * 6, True, START, {}
    while t < END:
        watch = [(f"stroke_end:pusher{k + 1}", k, lambda _, s, k=k: measure(s, k)[0] - STROKE) for k in range(6) if engaged[k]]
        if plugged:
            watch.append(("taut:umbilical", None, lambda _, s: pull(s)[0]) if "taut:umbilical" not in events else
                         ("part:umbilical", None, lambda _, s: pull(s)[0] - 900))
        run = solve_ivp(flow, (t, END), state, "DOP853", args=(engaged, plugged), events=[make_event(f) for _, _, f in watch],
                        rtol=1e-12, atol=1e-13, max_step=0.01)
        t, state = run.t[-1], run.y[:, -1]
        for name, number, function in watch:
            if abs(function(t, state)) < 1e-9:  # pushers that mirror each other end together
                events[name] = t
                if number is not None:
                    engaged[number] = False
                if name == "part:umbilical":
                    plugged = False
    bodies = unpack(state)
    print(json.dumps({"about": "tests/references/interstage_reference.py", "t": END, "events": events,
                      "bodies": {name: {"p": list(p), "axis": list(R[:, 0]), "v": list(v), "w_body": list(w)}
                                 for name, (p, R, v, w) in zip(("lower", "upper"), bodies)}}, indent=1))


if __name__ == "__main__":
    main()
