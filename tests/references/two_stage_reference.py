#!/usr/bin/python3
"""Tight-tolerance reference of checkcases/two-stage.yaml, independent of unlatch's code: both stages as one rigid body with the sum of
their changing masses, centres and inertias about a point of the structure, in fixed axes at the Earth's centre; burnout and cut-off as
roots; tables by SciPy's splines; the Earth, its axes and its air up to 86 km of flight_reference.py, above that cubic polynomials
through the published values of the standard. DOP853 at rtol 3e-14.

    two_stage_reference.py    writes tests/data/two_stage.json; needs python3-scipy
"""
import csv
import json
import math
import pathlib

import flight_reference as earth
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

ROOT = pathlib.Path(__file__).parent.parent.parent
FOLDER, FILE = ROOT / "hil/scenarios/checkcases", ROOT / "tests/data/two_stage.json"
DEG, END = math.pi / 180, 560.0
TIMES = (60.0, 150.0, 300.0, 450.0, END)
AREA, LENGTH, SWING = math.pi * 1.8**2, 3.6, 6 * DEG
VACUUM, ENERGY = 3350.0, -3.986004418e14 / (2 * (6378137.0 + 210e3))
WIND = np.array([0, 3e3, 11e3, 25e3, 60e3]), ([3, -4, -12, 2, 10], [-2, 8, 42, 6, 25])


# --- Tables ----------------------------------------------------------------------------------------------------------

def read(name):
    lines = [line for line in (FOLDER / name).read_text().splitlines() if not line.startswith("#")]
    return np.array([[float(x) for x in row] for row in list(csv.reader(lines))[1:]])


def spline(x, y):
    """Not-a-knot; beyond the ends the values at the ends."""
    curve = make_interp_spline(x, y, k=3)
    return lambda at: curve(min(max(at, x[0]), x[-1]))


AERO, ENGINE = read("two-stage-aero.csv"), read("two-stage-engine.csv")
MACHS, ANGLES = np.unique(AERO[:, 0]), np.unique(AERO[:, 1]) * DEG
SURFACES = [spline(MACHS, AERO[:, column].reshape(len(MACHS), len(ANGLES))) for column in (2, 3, 4)]  # ca, cn, moment over the Mach number
THRUST, FLOW = spline(ENGINE[:, 0] * 1e3, ENGINE[:, 1] * 1e3), spline(ENGINE[:, 0] * 1e3, ENGINE[:, 2])
THRUST2 = spline([0, 5, 60, 200, 400], np.array([170, 182, 184, 180, 172]) * 1e3)
PROGRAM = spline([0, 15, 40, 70, 110, 150, 200, 300, 400, 500, 600], np.array([85, 78, 66, 52, 37, 23, 19.8, 13.4, 6.9, 0.5, -5.9]) * DEG)
CN_Q = spline([0, 1, 3, 8], [-60.0, -90, -70, -50])


def look_up(surface, mach, angle):
    return float(spline(ANGLES, surface(mach))(angle))


# Published values above 86 km: altitude in km, pressure in Pa, density in kg/m³ (US Standard Atmosphere 1976, table I).
UPPER = np.array([
    [90, 1.8359e-1, 3.416e-6], [95, 7.5966e-2, 1.393e-6], [100, 3.2011e-2, 5.604e-7], [105, 1.4477e-2, 2.325e-7], [110, 7.1042e-3, 9.708e-8],
    [115, 4.0096e-3, 4.289e-8], [120, 2.5382e-3, 2.222e-8], [125, 1.7354e-3, 1.291e-8], [130, 1.2505e-3, 8.152e-9], [140, 7.2028e-4, 3.831e-9],
    [150, 4.5422e-4, 2.076e-9], [160, 3.0395e-4, 1.233e-9], [180, 1.5271e-4, 5.194e-10], [200, 8.4736e-5, 2.541e-10], [250, 2.4767e-5, 6.073e-11],
    [300, 8.7704e-6, 1.916e-11], [350, 3.4498e-6, 7.014e-12], [400, 1.4518e-6, 2.803e-12]])
TOP = earth.air(86e3)
HIGH = np.concatenate([[86e3], UPPER[:, 0] * 1e3])
LOGS = np.log(np.vstack([[TOP[1], TOP[0]], UPPER[:, 1:]]))
UPPER_AIR = CubicHermiteSpline(HIGH, LOGS, np.gradient(LOGS, HIGH, axis=0, edge_order=2))  # slopes of parabolas through neighbours


def air(altitude):
    """Density, pressure."""
    if altitude <= 86e3:
        return earth.air(altitude)[:2]
    pressure, density = np.exp(UPPER_AIR(altitude))
    return density, pressure


def blow(altitude):
    return np.array([*(np.interp(altitude, WIND[0], values) for values in WIND[1]), 0])


# --- The rocket: axes of the second stage, from its origin ------------------------------------------------------------

class Stage:
    def __init__(self, at, mass, inertia, centre, shift):
        self.at, self.rows, self.shift = at, np.column_stack([mass, inertia, centre]), np.array(shift)

    def get(self, burnt):
        """Mass, centre, inertia about it."""
        row = [np.interp(burnt, self.at, column) for column in self.rows.T]
        return row[0], np.array(row[4:]) + self.shift, np.diag(row[1:4])


SECOND = Stage([0, 6e3, 13e3, 19.5e3], [23.5e3, 17.5e3, 10.5e3, 4e3], [[30e3, 211e3, 211e3], [23e3, 170e3, 170e3], [15e3, 110e3, 110e3], [6e3, 45e3, 45e3]],
               [[0, 0, 0], [0.5, 2e-3, 0], [1.1, 4e-3, -1e-3], [1.4, 12e-3, -4e-3]], (0, 0, 0))
FIRST = Stage([0, 30e3, 60e3, 90e3, 108e3], [120e3, 90e3, 60e3, 30e3, 12e3],
              [[194e3, 5.9e6, 5.9e6], [150e3, 4.1e6, 4.1e6], [105e3, 2.7e6, 2.7e6], [58e3, 1.5e6, 1.5e6], [25e3, 0.75e6, 0.75e6]],
              [[0, 0, 0], [-1.1, 0, 1e-3], [-2.3, 1e-3, 2e-3], [-3.1, 2e-3, 4e-3], [-1.5, 5e-3, 10e-3]], (-16, 0, 0))
POINT, NOZZLE, NOZZLE2 = np.array([-14.0, 0, 0]), np.array([-28.0, 0, 0]), np.array([-4.5, 0, 0])


def deflect(thrust, pitch, yaw):
    pitch, yaw = (min(max(angle, -SWING), SWING) for angle in (pitch, yaw))
    return thrust * np.array([math.cos(pitch) * math.cos(yaw), math.sin(yaw), -math.sin(pitch) * math.cos(yaw)])


class Rocket:
    """State: place, velocity, attitude, rates (body) of the second stage; burnt by the first and the second."""
    staged = ignited = cut = math.inf

    def __call__(self, t, y):
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:13]
        R = earth.matrix(q)
        around = earth.look_around(r, v, R, air, blow)
        pressure, u, V, mach, alpha, beta, roll, pitch, yaw = (around[key] for key in ("pressure", "u", "V", "mach", "alpha", "beta", "roll", "pitch", "yaw"))
        q_s = 0.5 * around["density"] * V * V * AREA
        error, aside = pitch - PROGRAM(t), (yaw - 90 * DEG) * math.cos(pitch)

        moment = np.array([-20e3 * roll - 60e3 * w[0], 0, 0])
        flow, flow2 = 0.0, 0.0
        if t < self.staged:
            turn, damp = w - R.T @ earth.OMEGA, CN_Q(mach) * LENGTH / (2 * V)
            force = q_s * np.array([-look_up(SURFACES[0], mach, alpha), -look_up(SURFACES[1], mach, beta), -look_up(SURFACES[1], mach, alpha)])
            moment = moment + q_s * LENGTH * np.array([0, look_up(SURFACES[2], mach, alpha) + damp * turn[1], -look_up(SURFACES[2], mach, beta) + damp * turn[2]])
            moment = moment + np.cross(POINT, force)
            jet = deflect(float(THRUST(y[13])), 1.2 * error + 1.1 * w[1], 1.2 * aside + 1.1 * w[2]) - [1.5 * pressure, 0, 0]
            force, moment, flow = force + jet, moment + np.cross(NOZZLE, jet), float(FLOW(y[13]))
            parts = [SECOND.get(y[14]), FIRST.get(y[13])]
        else:
            force, parts = -0.5 * q_s * u / V, [SECOND.get(y[14])]
            if self.ignited <= t < self.cut:
                thrust = float(THRUST2(t - self.ignited))
                jet = deflect(thrust, 0.12 * error + 0.26 * w[1], 0.12 * aside + 0.26 * w[2])
                force, moment, flow2 = force + jet, moment + np.cross(NOZZLE2, jet), thrust / VACUUM

        faster, spun = earth.accelerate(parts, r, R, w, force, moment, torque=False)
        return np.concatenate([v, R @ faster, earth.turn(q, w), spun, [flow, flow2]])


def start():
    climb, latitude, longitude, altitude = 85 * DEG, 28.6 * DEG, -80.6 * DEG, 300.0
    east = 60 * math.cos(climb)
    s, c = math.sin(latitude), math.cos(latitude)
    across = earth.A / math.sqrt(1 - earth.E2 * s * s) + altitude
    turn = np.array([earth.RATE * c + east / across, 0, -earth.RATE * s - east / across * s / c])  # of north, east, down
    rate = earth.euler_matrix(0, climb, 90 * DEG).T @ turn
    return np.concatenate([earth.start(latitude, longitude, altitude, (0, east, -60 * math.sin(climb)), (0, climb, 90 * DEG), rate), [0, 0]])


def main():
    rocket, y, t = Rocket(), start(), 0.0
    found = []

    def fly(end, event=None):
        """To `end`, or to where the event is 0; True if that came first."""
        nonlocal t, y
        while t < end:
            stop = min([at for at in TIMES if at > t] + [end])
            stop = min(stop, end)
            out = solve_ivp(rocket, (t, stop), y, "DOP853", rtol=3e-14, atol=1e-12, max_step=0.5, events=event)
            t, y = out.t[-1], out.y[:, -1]
            if out.status == 1:
                return True
            if stop in TIMES:
                found.append({"t": stop, **{key: float(value) for key, value in earth.describe(y, stop).items() if not key.startswith("inertial")},
                              "spent": y[13], "spent2": y[14]})
        return False

    def burnout(_, z):
        return z[13] - 108e3

    def cutoff(_, z):
        return 0.5 * z[3:6] @ z[3:6] - earth.MU / math.sqrt(z[:3] @ z[:3]) - ENERGY

    burnout.terminal = cutoff.terminal = True
    assert fly(END, burnout)
    rocket.staged = t
    rocket.ignited = t + 3
    fly(rocket.ignited)
    assert fly(END, cutoff)
    rocket.cut = t
    fly(END)
    about = "tests/references/two_stage_reference.py: of the second stage at t; events in s"
    FILE.write_text(json.dumps({"about": about, "events": {"burnout": rocket.staged, "ignition": rocket.ignited, "cutoff": rocket.cut}, "at": found},
                               indent=1) + "\n")


if __name__ == "__main__":
    main()
