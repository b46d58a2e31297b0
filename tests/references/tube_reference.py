#!/usr/bin/python3
"""Tight-tolerance reference of a capsule that bounces in a tube: planar, in x (across the tube) and z (along it), with the
law of contact of THEORY.md (n = 1); SciPy's DOP853 at rtol 1e-13 from one touch or lift to the next. Independent of
unlatch: no geometry but |x| of the capsule's ends, no quaternions.

    tube_reference.py    writes tests/data/tube.json; needs python3-scipy
"""
import json
import math
import pathlib

from scipy.integrate import solve_ivp

RADIUS, HALF_LENGTH, TUBE = 0.125, 0.25, 0.5  # m: capsule, from its centre to the centre of an end; tube
MASS, INERTIA = 2.0, 0.0625                   # kg, kg m²
STIFFNESS, DAMPING, FRICTION, SLIP_SPEED = 5e4, 0.125, 0.25, 0.125
START = [0.03125, 0.0, 0.25, 1.5, 1.0, 0.375]            # x, z, angle of the axis from z towards x; their rates
LIFTS = 10
AFTER = 0.02                                  # s of free flight after the last lift, at the least
STEP = 1e-3                                   # s: the end is a multiple of it


def gap(y, end, side):
    return TUBE - RADIUS - side * (y[0] + end * HALF_LENGTH * math.sin(y[2]))


def force(y, end, side):
    """Returns force and moment of the touching end on the capsule."""
    x, z, angle, vx, vz, w = y
    depth = -gap(y, end, side)
    arm_x, arm_z = end * HALF_LENGTH * math.sin(angle), end * HALF_LENGTH * math.cos(angle)
    # The force acts at the midpoint of the witness points: on the wall TUBE from the axis, on the capsule `depth` beyond it.
    arm_x += side * (RADIUS - depth / 2)
    rate = side * (vx + w * arm_z)
    slip = vz - w * arm_x
    normal = max(0.0, STIFFNESS * depth * (1 + DAMPING * rate)) if depth > 0 else 0.0
    friction = -FRICTION * normal * slip / math.hypot(slip, SLIP_SPEED)
    return -side * normal, friction, -side * normal * arm_z - friction * arm_x


def rates(_, y, touching):
    fx, fz, moment = force(y, *touching) if touching else (0.0, 0.0, 0.0)
    return [y[3], y[4], y[5], fx / MASS, fz / MASS, moment / INERTIA]


def crossing(end, side, direction):
    def guard(_, y, *args):
        return gap(y, end, side)
    guard.terminal, guard.direction = True, direction
    return guard


if __name__ == "__main__":
    t, y, touching, events = 0.0, START, None, []
    ends = [(end, side) for end in (-1, 1) for side in (-1, 1)]
    while sum(e["name"] == "lift" for e in events) < LIFTS:
        guards = [crossing(*touching, 1)] if touching else []
        guards += [crossing(*e, -1) for e in ends if e != touching]
        out = solve_ivp(rates, (t, t + 10), y, method="DOP853", rtol=1e-13, atol=1e-15, args=(touching,), events=guards, max_step=5e-3)
        which = next(i for i, times in enumerate(out.t_events) if len(times))
        t, y = out.t[-1], out.y[:, -1]
        assert not touching or which == 0, "two ends touch at once"
        events.append({"t": t, "name": "lift" if touching else "touch"})
        touching = None if touching else ends[which]
    end = math.ceil((t + AFTER) / STEP) * STEP
    out = solve_ivp(rates, (t, end), y, method="DOP853", rtol=1e-13, atol=1e-15, args=(None,), events=[crossing(*e, -1) for e in ends])
    assert out.status == 0, "it touches again before the end"
    result = {"about": "tests/references/tube_reference.py: DOP853 at 1e-13. state: x, z, angle, and their rates, at t",
              "events": events, "t": end, "state": [float(v) for v in out.y[:, -1]]}
    (pathlib.Path(__file__).parent.parent / "data/tube.json").write_text(json.dumps(result, indent=1) + "\n")
