#!/usr/bin/python3
"""Tight-tolerance reference of launcher/scenario.yaml, independent of unlatch's code: both stages as one rigid body whose two masses,
inertias and centre change with what is burnt, its staging found as a root, the second stage alone; the Earth, its axes and air of
flight_reference.py, about the Earth's centre; tables by SciPy's splines. DOP853 at rtol 3e-14. Until 153 s, below 86 km.

    launcher_reference.py    writes tests/data/launcher.json; needs python3-scipy
"""
import json
import math
import pathlib

import flight_reference as earth
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

FILE = pathlib.Path(__file__).parent.parent / "data/launcher.json"
DEG, G0, END = math.pi / 180, 9.80665, 153.0
AREA, STIFF, DAMP, PART, COAST = math.pi * 0.9**2, 6e6, 4e6, 0.02, 2.0
POINT, BOOSTER, NOZZLE = np.array([1.5, 0, 0]), np.array([-9.0, 0, 0]), np.array([-17.0, 0, 0])  # upper stage's axes
WINDS = ((2, -10), (5, 60))  # m/s at 0 and 100 km: towards north and east

THRUST = make_interp_spline([0, 8e3, 20e3, 32e3, 38e3], [690e3, 720e3, 740e3, 700e3, 560e3], k=3)
AXIAL = make_interp_spline([0, 0.6, 0.9, 1.1, 1.5, 2.5, 4, 7, 12, 25], [0.30, 0.31, 0.42, 0.58, 0.52, 0.40, 0.30, 0.24, 0.21, 0.20], k=3)
ANGLES = np.array([-40, -20, -10, 0, 10, 20, 40]) * DEG
HALF = np.array([[0.50, 1.20, 3.2], [0.55, 1.30, 3.4], [0.60, 1.50, 3.8], [0.52, 1.35, 3.6], [0.48, 1.20, 3.2], [0.45, 1.10, 3.0], [0.45, 1.10, 3.0]])
NORMAL = make_interp_spline([0, 0.8, 1.2, 2.5, 5, 12, 25], np.hstack([-HALF[:, ::-1], np.zeros((7, 1)), HALF]), k=3)
PROGRAM = make_interp_spline([0, 20, 45, 70, 110, 180, 240], np.array([84, 76, 60, 47, 33, 20, 12]) * DEG, k=3)


def normal(mach, angle):
    return float(make_interp_spline(ANGLES, NORMAL(mach), k=3)(angle))


def get_upper(burnt):
    s = burnt / 7600
    return 9600 - burnt, np.zeros(3), np.diag([4200 - 3100 * s, 26000 - 19000 * s, 26000 - 19000 * s])


def get_booster(burnt):
    s = burnt / 38e3
    return 42e3 - burnt, BOOSTER, np.diag([19000 - 16600 * s, 520e3 - 430e3 * s, 520e3 - 430e3 * s])


class Launcher:
    """State: place, velocity, attitude, rates (body) of the upper stage; masses burnt by booster and upper stage."""

    def __init__(self):
        self.staged = None  # time of the burnout

    def __call__(self, t, y):
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:13]
        R = earth.matrix(q)
        air = earth.look_around(r, v, R, earth.air, lambda altitude: np.array([a + (b - a) * altitude / 100e3 for a, b in WINDS] + [0]))
        mach, pitch = air["mach"], air["pitch"]
        force = 0.5 * air["density"] * air["V"]**2 * AREA * np.array([-AXIAL(mach), -normal(mach, air["beta"]), -normal(mach, air["alpha"])])
        scale = 1 if self.staged is None else 1 + (PART - 1) * min(1, (t - self.staged) / 0.1)
        steer = np.array([-0.02 * (STIFF * air["roll"] + DAMP * w[0]), -STIFF * (pitch - PROGRAM(t)) - DAMP * w[1],
                          -STIFF * (air["yaw"] - 90 * DEG) * math.cos(pitch) - DAMP * w[2]])
        moment, parts, burn1, burn2 = np.cross(POINT, force) + scale * steer, [get_upper(y[14])], 0.0, 0.0
        if self.staged is None:
            along = np.array([float(THRUST(y[13])), 0, 0])
            force, moment = force + along, moment + np.cross(NOZZLE, along)
            parts.append(get_booster(y[13]))
            burn1 = along[0] / (282 * G0)
        elif t >= self.staged + COAST:
            force, burn2 = force + [88e3, 0, 0], 88e3 / (325 * G0)
        faster, spun = earth.accelerate(parts, r, R, w, force, moment, torque=True)
        return np.concatenate([v, R @ faster, earth.turn(q, w), spun, [burn1, burn2]])


def main():
    climb = 84 * DEG
    over = 100 * np.array([0, math.cos(climb), -math.sin(climb)])
    y = earth.start(28.5 * DEG, -80.6 * DEG, 1000, over, (0, climb, 90 * DEG), (0, 0, 0))
    y, launcher = np.concatenate([y, [0, 0]]), Launcher()

    def burnout(_, z):
        return z[13] - 38e3

    burnout.terminal = True
    options = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-12, "max_step": 0.5}
    out = solve_ivp(launcher, (0, END), y, events=burnout, **options)
    launcher.staged, y = out.t[-1], out.y[:, -1]
    for begin, end in ((0, 0.1), (0.1, COAST), (COAST, END - launcher.staged)):
        y = solve_ivp(launcher, (launcher.staged + begin, launcher.staged + end), y, **options).y[:, -1]
    found = earth.describe(y, END)
    del found["inertial_position"], found["inertial_velocity"]
    found = {name: float(value) for name, value in found.items()}
    print(launcher.staged, found)
    about = "tests/references/launcher_reference.py: of the upper stage at t; events in s"
    events = {"burnout": launcher.staged, "ignition": launcher.staged + COAST}
    FILE.write_text(json.dumps({"about": about, "events": events, "at": [{"t": END, **found}]}, indent=1) + "\n")


if __name__ == "__main__":
    main()
