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
    return 9600 - burnt, np.array([4200 - 3100 * s, 26000 - 19000 * s, 26000 - 19000 * s])


def get_booster(burnt):
    s = burnt / 38e3
    return 42e3 - burnt, np.array([19000 - 16600 * s, 520e3 - 430e3 * s, 520e3 - 430e3 * s])


class Launcher:
    """State: place, velocity, attitude, rates (body) of the upper stage; masses burnt by booster and upper stage."""

    def __init__(self):
        self.staged = None  # time of the burnout

    def calc_loads(self, t, r, v, R, w):
        """Force and moment about the upper stage's origin, its axes, of the air and the attitude law."""
        latitude, altitude = earth.geodetic(r)
        local = earth.local_axes(latitude, math.atan2(r[1], r[0]))
        density, pressure, _ = earth.air(altitude)
        wind = np.array([a + (b - a) * altitude / 100e3 for a, b in WINDS] + [0])
        u = R.T @ (v - np.cross(earth.OMEGA, r) - local @ wind)
        V = np.linalg.norm(u)
        mach, alpha, beta = V / math.sqrt(1.4 * pressure / density), math.atan2(u[2], u[0]), math.asin(u[1] / V)
        force = 0.5 * density * V * V * AREA * np.array([-AXIAL(mach), -normal(mach, beta), -normal(mach, alpha)])
        E = local.T @ R
        pitch = math.atan2(-E[2, 0], math.hypot(E[0, 0], E[1, 0]))
        scale = 1 if self.staged is None else 1 + (PART - 1) * min(1, (t - self.staged) / 0.1)
        roll, yaw = math.atan2(E[2, 1], E[2, 2]), math.atan2(E[1, 0], E[0, 0])
        steer = np.array([-0.02 * (STIFF * roll + DAMP * w[0]), -STIFF * (pitch - PROGRAM(t)) - DAMP * w[1],
                          -STIFF * (yaw - 90 * DEG) * math.cos(pitch) - DAMP * w[2]])
        return force, np.cross(POINT, force) + scale * steer

    def __call__(self, t, y):
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:13]
        R = earth.matrix(q)
        force, moment = self.calc_loads(t, r, v, R, w)
        m2, J2 = get_upper(y[14])
        moment = moment + earth.gradient_torque(r, R, J2) - np.cross(w, J2 * w)
        force = force + m2 * (R.T @ earth.gravity(r))
        burn1 = burn2 = 0.0
        if self.staged is None:
            thrust, place = float(THRUST(y[13])), r + R @ BOOSTER
            m1, J1 = get_booster(y[13])
            along = np.array([thrust, 0, 0])
            pull = m1 * (R.T @ earth.gravity(place) - np.cross(w, np.cross(w, BOOSTER)))
            force = force + along + pull
            moment = moment + np.cross(NOZZLE, along) + np.cross(BOOSTER, pull) + earth.gradient_torque(place, R, J1) - np.cross(w, J1 * w)
            X = np.array([[0, -BOOSTER[2], BOOSTER[1]], [BOOSTER[2], 0, -BOOSTER[0]], [-BOOSTER[1], BOOSTER[0], 0]])
            M = np.block([[(m1 + m2) * np.eye(3), -m1 * X], [m1 * X, np.diag(J1 + J2) - m1 * X @ X]])
            burn1 = thrust / (282 * G0)
        else:
            if t >= self.staged + COAST:
                force, burn2 = force + [88e3, 0, 0], 88e3 / (325 * G0)
            M = np.diag(np.concatenate([np.full(3, m2), J2]))
        a = np.linalg.solve(M, np.concatenate([force, moment]))
        rate = 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])
        return np.concatenate([v, R @ a[:3], rate, a[3:], [burn1, burn2]])


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
    about = "tests/references/launcher_reference.py: of the upper stage at t; burnout, s"
    FILE.write_text(json.dumps({"about": about, "t": END, "burnout": launcher.staged, "end": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
