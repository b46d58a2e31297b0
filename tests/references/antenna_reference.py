#!/usr/bin/env python3
"""The antennas of hil/scenarios/antenna with one degree of freedom each, integrated by SciPy (DOP853, rtol 1e-12).

Prints the JSON of tests/data/antenna.json. Constants as in scenario.yaml and ring.yaml. Independent of unlatch: no joints and
no reactions. Symmetric ribs have one angle, and a ring of scissors one by its kinematics; all bodies follow from it in
closed form. The whole floats freely from rest, so that both its momenta stay zero: they give the motion of the main body,
and what is left is Lagrange's equation of one coordinate q,

    A(q) q'' + A'(q) q'^2 / 2 = Q(q, q'),   A q'^2 / 2 the kinetic energy,

with A' by a complex step.
"""
import json

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

FIRE, END = 0.1, 4.0
TIMES = (0.5, 1.0, 1.5, 1.7, 1.75, 1.8, 2.0, 2.2, 2.25, 2.3, 2.5, 3.0, 4.0)
OPTIONS = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 5e-3}


def integrate(flow, state, stages):
    """Runs through stages, each a function that ends it at its root; `flow` gets the number of completed stages."""
    t, events, pieces = FIRE, [], []
    for k in range(len(stages) + 1):
        ends = []
        if k < len(stages):
            def end(t, y, stage=stages[k]):
                return stage(y)
            end.terminal, end.direction = True, 1
            ends = [end]
        piece = solve_ivp(lambda t, y, k=k: flow(y, k), (t, END), state, events=ends or None, dense_output=True, **OPTIONS)
        pieces.append(piece)
        t, state = piece.t[-1], piece.y[:, -1]
        if k < len(stages):
            events.append(t)
    return events, pieces


def find_peak(measure, piece, first, last):
    """Returns the largest value of a function of the state in an interval, from a grid and then between its points."""
    times = np.linspace(first, last, 200)
    best = times[np.argmax([measure(piece.sol(t)) for t in times])]
    found = minimize_scalar(lambda t: -measure(piece.sol(t)), bounds=(best - times[1] + times[0], best + times[1] - times[0]),
                            method="bounded", options={"xatol": 1e-9})
    return {"t": found.x, "value": -found.fun}


def sample(pieces, start):
    """Returns states at TIMES, `start` before the release."""
    found = {}
    for time in TIMES:
        inside = [piece for piece in pieces if piece.t[0] <= time <= piece.t[-1]]
        found[str(time)] = list(inside[0].sol(time)) if inside else list(start)
    return found


def ribs():
    """[angle from folded, its rate, position of the hub along the axis]: the hub only moves along the axis, opposite to the ribs."""
    count, radius, length, mass, hub, folded, opened = 12, 0.35, 2.4, 1.5, 400.0, np.radians(4), np.radians(75)
    effort, stiffness, damping, latch, latch_damping, stretch, cable_damping = 4.0, 1.5, 1.6, 2000.0, 12.0, 0.02, 4.0
    travel, half = opened - folded, np.sin(np.pi / count)
    spacing = 2 * (radius + length * np.sin(opened)) * half
    cable = (effort - stiffness * travel) / (2 * length * np.cos(opened) * half * stretch)

    def measure_cable(y):
        angle = folded + y[0]
        return 2 * (radius + length * np.sin(angle)) * half - (spacing - stretch), 2 * length * np.cos(angle) * half

    def flow(y, stage):
        angle, rate = folded + y[0], y[1]
        part = count * mass * length / 2  # part of each rib's speed that the hub has
        shared = part**2 / (hub + count * mass)
        inertia = count * mass * length**2 / 3 - shared * np.sin(angle)**2
        force = count * (effort - stiffness * y[0] - damping * rate)
        if stage >= 1:  # taut: every rib has two cables, every cable two ribs
            depth, slope = measure_cable(y)
            force -= count * slope * max(0.0, cable * depth + cable_damping * slope * rate)
        if stage >= 2:
            force -= count * (latch * (y[0] - travel) + latch_damping * rate)
        return [rate, (force + shared * np.sin(angle) * np.cos(angle) * rate**2) / inertia,
                part * np.sin(angle) * rate / (hub + count * mass)]

    def calc_hinge_force(y):
        """Force on a latched rib, without the pull of its two cables: its mass times the acceleration of its middle."""
        angle, rate = folded + y[0], y[1]
        _, acceleration, _ = flow(y, 2)
        axial = -mass * length / 2 * (np.sin(angle) * acceleration + np.cos(angle) * rate**2) * hub / (hub + count * mass)
        depth, slope = measure_cable(y)
        pull = 2 * half * max(0.0, cable * depth + cable_damping * slope * rate)
        return np.hypot(mass * length / 2 * (np.cos(angle) * acceleration - np.sin(angle) * rate**2) + pull, axial)

    start = np.zeros(3)
    events, pieces = integrate(flow, start, [lambda y: measure_cable(y)[0], lambda y: y[0] - travel])
    return {"events": dict(zip(("taut", "latch"), events)), "shock": find_peak(calc_hinge_force, pieces[2], events[1], events[1] + 0.2),
            "samples": sample(pieces, start)}


# --- The ring -----------------------------------------------------------------------------------------------------------

HALF, POST, BOOM, FOLDED, OPEN = 0.8, 1.7, 1.5, np.radians(8), np.radians(55)
SPACECRAFT, SPACECRAFT_INERTIA = 250.0, (60.0, 70.0, 60.0)
BAR_MASS, POST_MASS, SLIDER_MASS = 0.6, 0.8, 0.3


def turn(axis, angle):
    """Returns a rotation by Rodrigues' formula; the angle may be complex."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def list_bodies(q):
    """(mass, inertia, place, its derivative by q, angular velocity by q) of all bodies in the spacecraft's axes; q the bars' angle."""
    radius, radius_rate = 2 * HALF * np.sin(q), 2 * HALF * np.cos(q)
    height, height_rate = 2 * HALF * np.cos(q), -2 * HALF * np.sin(q)
    up, zero = np.array([0, 0, 1.0]), np.zeros(3)
    middle = np.array([-BOOM, 0, POST / 2]) - np.array([1.0, 0, 0]) * radius  # centre of the upper hinges: post 1 is fixed to the spacecraft
    middle_rate = -np.array([1.0, 0, 0]) * radius_rate
    yield SPACECRAFT, np.diag(SPACECRAFT_INERTIA), zero, zero, zero
    for i in range(6):
        out = np.array([np.cos(i * np.pi / 3), np.sin(i * np.pi / 3), 0])
        upper, upper_rate = middle + radius * out, middle_rate + radius_rate * out
        post = POST_MASS * POST**2 / 12
        yield POST_MASS, np.diag([post, post, 5e-4]), upper - POST / 2 * up, upper_rate, zero
        yield SLIDER_MASS, 2e-4 * np.eye(3), upper - height * up, upper_rate - height_rate * up, zero
        angle = (i + 0.5) * np.pi / 3
        out = np.array([np.cos(angle), np.sin(angle), 0])
        along = np.array([-np.sin(angle), np.cos(angle), 0])
        near = np.cos(np.pi / 6)
        for sign in (1, -1):  # the bar that falls along `along`, and the one that rises
            frame = np.column_stack([along, -out, up])
            axes = turn(-out, sign * (np.pi / 2 - q)) @ frame
            bar = BAR_MASS * HALF**2 / 3
            yield (BAR_MASS, axes @ np.diag([1e-4, bar, bar]) @ axes.T, middle + near * radius * out - height / 2 * up,
                   middle_rate + near * radius_rate * out - height_rate / 2 * up, sign * out)


def reduce(q):
    """A; angular velocity of the spacecraft by q', its place from the common centre of mass, velocity of that centre by q'; its axes."""
    bodies = list(list_bodies(q))
    mass = sum(m for m, *_ in bodies)
    centre = sum(m * r for m, _, r, _, _ in bodies) / mass
    drift = sum(m * v for m, _, _, v, _ in bodies) / mass
    own, momentum, inertia = 0, 0, 0
    for m, body, r, v, w in bodies:
        arm = r - centre
        own = own + m * (v @ v) + w @ body @ w
        momentum = momentum + m * np.cross(arm, v - drift) + body @ w
        inertia = inertia + body + m * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    turning = -np.linalg.solve(inertia, momentum)
    return own - mass * (drift @ drift) + momentum @ turning, turning, -centre, drift


def ring(lock, lock_damping):
    """[travel of a slider, its rate, pitch of the spacecraft, its x, its z]; it locks rigidly if `lock` is None."""
    effort, stiffness, damping, step = 3.0, 1.0, 1.8, 1e-30
    stroke = 2 * HALF * (np.cos(FOLDED) - np.cos(OPEN))

    def flow(y, stage):
        q, rate = y[0], y[1]
        if stage and lock is None:
            return [0, 0, 0]
        inertia, turning, *_ = reduce(q)
        slope = np.imag(reduce(q + 1j * step)[0]) / step
        force = 6 * 2 * (effort - stiffness * 2 * (q - FOLDED) - damping * 2 * rate)  # a pivot turns by twice a bar's angle
        if stage:
            gain = 2 * HALF * np.sin(q)
            force -= 6 * gain * (lock * (2 * HALF * (np.cos(FOLDED) - np.cos(q)) - stroke) + lock_damping * gain * rate)
        return [rate, (force - slope * rate**2 / 2) / inertia, turning[1] * rate]

    def calc_velocity(y):
        """Velocity of the spacecraft, W."""
        _, turning, place, drift = reduce(y[0])
        seen = (np.cross(turning, place) - drift) * y[1]
        return np.array([np.cos(y[2]) * seen[0] + np.sin(y[2]) * seen[2], np.cos(y[2]) * seen[2] - np.sin(y[2]) * seen[0]])

    def calc_boom_force(y):
        """Acceleration of the spacecraft, which only the boom causes."""
        return SPACECRAFT * np.hypot(*np.imag(calc_velocity(y + 1j * step * np.array(flow(y, 1)))) / step)

    def finish(y):
        _, _, place, _ = reduce(y[0])
        x, z = np.cos(y[2]) * place[0] + np.sin(y[2]) * place[2], np.cos(y[2]) * place[2] - np.sin(y[2]) * place[0]
        return [2 * HALF * (np.cos(FOLDED) - np.cos(y[0])), 2 * HALF * np.sin(y[0]) * y[1], y[2], x, z]

    start = np.array([FOLDED, 0, 0])
    events, pieces = integrate(flow, start, [lambda y: y[0] - OPEN])
    at_lock = pieces[0].y[:, -1]
    inertia = reduce(at_lock[0])[0]
    states = sample(pieces, start)
    if lock is None:
        states = {t: [y[0], y[1] if float(t) < events[0] else 0.0, y[2]] for t, y in states.items()}
    states = {t: finish(y) for t, y in states.items()}
    origin = finish(start)  # the spacecraft starts with attitude 0; positions are relative to that point
    states = {t: [*y[:3], y[3] - origin[3], y[4] - origin[4]] for t, y in states.items()}
    found = {"events": {"lock": events[0]}, "energy at the lock": inertia * at_lock[1]**2 / 2, "samples": states}
    if lock is not None:
        found["shock"] = find_peak(calc_boom_force, pieces[1], events[0], events[0] + 0.1)
    return found


def main():
    print(json.dumps({"about": "tests/references/antenna_reference.py", "ribs": ribs(), "ring": ring(None, None),
                      "ring-elastic": ring(4e3, 60.0)}, indent=1))


if __name__ == "__main__":
    main()
