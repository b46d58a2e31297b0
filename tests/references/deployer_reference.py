#!/usr/bin/env python3
"""A cubesat between rails on a free stage, in a plane, integrated by SciPy (DOP853, rtol 1e-11).

Prints the JSON of tests/data/deployer.json. Constants as in hil/scenarios/deployer/misaligned.yaml, with the door shut, which
makes it a part of the stage, and the latch open at 0.1 s. The spring is off the middle along y, so that the motion stays in
the plane and every contact has a twin across it. Independent of unlatch: two bodies with three freedoms each, distances
between circles, segments and rectangles, forces written out.
"""
import json

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

PLATE, HALF, SIDE, EDGE, RAIL_Y = 1.2, 0.17025, 0.05, 1e-3, 0.0503
RAIL = (PLATE - 0.01, PLATE + 0.349)  # from, to; there the lip is
OFFSET, STROKE, PRELOAD, STIFFNESS, FRICTION, FRICTION_SPEED = 8e-3, 0.345, 26.0, 40.0, 2.0, 5e-3
K, MU, SLIP_SPEED, E, E_SPEED, TWINS = 1e6, 0.2, 2e-3, 0.2, 0.01, 2
EXIT, START, END = 0.355, 0.1, 0.6
DOOR, DOOR_INERTIA, DOOR_X = 0.2, 0.21e-3, PLATE + 0.353
MASS = (850 + DOOR, 4.0)
CENTRE = DOOR * DOOR_X / MASS[0]  # centre of mass of stage and door, in the stage's axes
INERTIA = (640 + 850 * CENTRE**2 + DOOR_INERTIA + DOOR * (DOOR_X - CENTRE)**2, 41.98e-3)
D = brentq(lambda x: x * (1 + E) - np.log((1 + x) / (1 - E * x)), 1e-3, 1 / E - 1e-9) / E_SPEED


def turn(angle, x, y):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * x - s * y, s * x + c * y])


def get_velocity(body, point):
    return body[3:5] + body[5] * np.array([-(point[1] - body[1]), point[0] - body[0]])


def find_contacts(stage, cube):
    """Returns the witness points of each pair in the plane: on the stage, on the cubesat; the depth; the normal towards the cubesat. W."""
    def to_world(body, point, centre=0.0):
        return body[:2] + turn(body[2], point[0] - centre, point[1])

    def to_stage(point):
        return turn(-stage[2], *(point - stage[:2])) + np.array([CENTRE, 0])

    for sign in (1, -1):
        inner, outer = sorted((sign * RAIL_Y, sign * (RAIL_Y + 5e-3)))
        for x in (EDGE - HALF, HALF - EDGE):  # a corner and its strip
            centre = to_stage(to_world(cube, (x, sign * (SIDE - EDGE))))
            near = np.array([np.clip(centre[0], *RAIL), np.clip(centre[1], inner, outer)])
            line = centre - near
            size = np.hypot(*line)
            n = turn(stage[2], *(line / size))
            yield to_world(stage, near, CENTRE), to_world(stage, centre, CENTRE) - EDGE * n, EDGE - size, n
        lip = to_world(stage, (RAIL[1], sign * (RAIL_Y + EDGE)), CENTRE)  # a lip and the edge that passes it
        seen = turn(-cube[2], *(lip - cube[:2]))
        near = to_world(cube, (np.clip(seen[0], EDGE - HALF, HALF - EDGE), sign * (SIDE - EDGE)))
        size = np.hypot(*(near - lip))
        n = (near - lip) / size
        yield lip + EDGE * n, near - EDGE * n, 2 * EDGE - size, n


def measure(stage, cube):
    """Returns travel of the spring and its rate; its point; its direction."""
    n = turn(stage[2], 1, 0)
    point = cube[:2] + turn(cube[2], -HALF, OFFSET)
    base = stage[:2] + turn(stage[2], PLATE - CENTRE, OFFSET)
    rate = (get_velocity(cube, point) - get_velocity(stage, point)) @ n
    return (point - base) @ n, rate, point, n


def flow(t, state, pushing):
    stage, cube = state.reshape(2, 6)
    force, torque = np.zeros((2, 2)), np.zeros(2)

    def push(f, point):
        for i, (body, sign) in enumerate(((stage, -1), (cube, 1))):
            arm = point - body[:2]
            force[i] += sign * f
            torque[i] += sign * (arm[0] * f[1] - arm[1] * f[0])

    if pushing:
        travel, rate, point, n = measure(stage, cube)
        push(max(0.0, PRELOAD - STIFFNESS * travel - FRICTION * rate / np.hypot(rate, FRICTION_SPEED)) * n, point)
    for a, b, depth, n in find_contacts(stage, cube):
        if depth <= 0:
            continue
        middle = 0.5 * (a + b)
        u = get_velocity(cube, middle) - get_velocity(stage, middle)
        rate = -n @ u
        slip = u + rate * n
        size = max(0.0, K * depth * (1 + D * rate))
        push(TWINS * size * (n - MU * slip / np.hypot(np.hypot(*slip), SLIP_SPEED)), middle)
    return np.concatenate([np.concatenate([body[3:], f / m, [M / J]])
                           for body, f, M, m, J in zip((stage, cube), force, torque, MASS, INERTIA)])


def make_event(function):
    def event(t, state, *_):
        return function(*state.reshape(2, 6))
    event.direction = 1
    return event


def calc_exit(stage, cube):
    return (cube[:2] - stage[:2] - turn(stage[2], PLATE + HALF - CENTRE, 0)) @ turn(stage[2], 1, 0) - EXIT


def main():
    state = np.array([CENTRE, 0, 0, 0, 0, 0, PLATE + HALF, 0, 0, 0, 0, 0])
    end, out = make_event(lambda stage, cube: measure(stage, cube)[0] - STROKE), make_event(calc_exit)
    end.terminal = True
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14, "max_step": 5e-5}  # because of the law's kinks at touch and lift
    first = solve_ivp(flow, (START, END), state, args=(True,), events=[end, out], **options)
    then = solve_ivp(flow, (first.t[-1], END), first.y[:, -1], args=(False,), events=[end, out], **options)
    stage, cube = then.y[:, -1].reshape(2, 6)
    print(json.dumps({"about": "tests/references/deployer_reference.py", "t": END,
                      "events": {"stroke_end:spring": first.t_events[0][0], "exit": then.t_events[1][0]},
                      "cubesat": {"p": list(cube[:2]), "angle": cube[2], "v": list(cube[3:5]), "rate": cube[5]},
                      "stage": {"v": list(stage[3:5]), "rate": stage[5]}}, indent=1))


if __name__ == "__main__":
    main()
