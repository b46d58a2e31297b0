#!/usr/bin/python3
"""Tight-tolerance reference of boosters/ascent.yaml, the separation in air, independent of unlatch's code: bodies, nodes, events and the
dense KKT system of boosters_reference.py; the Earth's field, axes and air of flight_reference.py; tables by SciPy's splines.

All vectors are in the core's axes at the start, from a point at rest in inertial space where the core then is. Equations of the air, for
a body with velocity v through it (the air turns with the planet), (u, v, w) in body axes:
    q = rho V^2 / 2, slip = asin(v / V), attack = atan2(w, u), mach = V / a
    push = PUSH(gap, slide, lean), of the booster's pose in the core's axes
    booster: F = q S (-CA(mach, slip), -CN(mach, slip) + push, -CN(mach, attack))
             M = q S (0, x_c CN(mach, attack) + k l^2 q_y / 2V, -x_c CN(mach, slip) + x_n push + k l^2 q_z / 2V), about its centre
    core: F = -0.35 q S_core along its axis, and q S times the opposite of each push, x_n before the booster's place

    ascent_reference.py    writes tests/data/boosters_ascent.json; needs python3-scipy; half a minute
"""
import json
import math
import pathlib

import boosters_reference
import flight_reference as earth
import numpy as np
from boosters_reference import DATA, P, Boosters, rotation
from scipy.interpolate import make_interp_spline

FOLDER = pathlib.Path(__file__).parent.parent.parent / "hil/scenarios/boosters"
DEG = math.pi / 180
LATITUDE, LONGITUDE, ALTITUDE = 48.5 * DEG, 66.5 * DEG, 45e3
SPEED, CLIMB, AZIMUTH, ROLL = 5 * 325.8, 40 * DEG, 64 * DEG, -90 * DEG
RADIUS, CORE_RADIUS, CENTRE, NEAR, DAMPING = 1.34, 1.475, 1.5, 6.0, -100.0
MOUNTED = np.array([-13.950076101419809, 2.466951841564218])
AREA, CORE_AREA, LENGTH = math.pi * RADIUS**2, math.pi * CORE_RADIUS**2, 2 * RADIUS


class Spline:
    """A tensor product of cubic splines without knots beside the ends, over the columns of a file (in FOLDER); constant beyond its ends."""

    def __init__(self, file, axes, column):
        lines = [line for line in (FOLDER / file).read_text().splitlines() if not line.startswith("#")]
        names = [name.strip() for name in lines[0].split(",")]
        table = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
        scales = [DEG if "[deg]" in name else 1 for name in names]
        names = [name.split(" [")[0] for name in names]
        columns = {name: table[:, i] * scales[i] for i, name in enumerate(names)}
        self.knots = [np.unique(columns[axis]) for axis in axes]
        self.values = columns[column].reshape([len(knots) for knots in self.knots])
        self.inner = make_interp_spline(self.knots[0], self.values, k=3)

    def __call__(self, *at):
        at = [min(max(x, knots[0]), knots[-1]) for x, knots in zip(at, self.knots, strict=True)]
        values = self.inner(at[0])
        for x, knots in zip(at[1:], self.knots[1:]):
            values = make_interp_spline(knots, values, k=3)(x)
        return float(values)


class Ascent(Boosters):
    tolerance = 3e-14  # velocities are 1600 m/s

    def __init__(self):
        super().__init__({"tails": [(300000, 0.35)] * 4, "until": 2.0})
        self.mode = [boosters_reference.HINGE] * 4
        self.samples = [0.0, 0.3, 0.6, 0.7, 0.9, 1.2, 1.6, 2.0]
        self.axial = Spline("ascent-free.csv", ("mach", "angle"), "ca")
        self.normal = Spline("ascent-free.csv", ("mach", "angle"), "cn")
        self.push = Spline("ascent-near.csv", ("gap", "slide", "lean"), "push")
        local = earth.local_axes(LATITUDE, LONGITUDE)
        self.axes = local @ earth.euler_matrix(ROLL, CLIMB, AZIMUTH)  # columns: the frame of this integration in the Earth's
        self.origin = earth.place(LATITUDE, LONGITUDE, ALTITUDE)
        over = SPEED * np.array([math.cos(CLIMB) * math.cos(AZIMUTH), math.cos(CLIMB) * math.sin(AZIMUTH), -math.sin(CLIMB)])
        velocity = self.axes.T @ (local @ over + np.cross(earth.OMEGA, self.origin))
        for i in range(5):
            self.start[13 * i + 7:13 * i + 10] = velocity

    def calc_gravity(self, place):
        return self.axes.T @ earth.gravity(self.origin + self.axes @ place)

    def meet(self, s, c):
        """Returns velocity through the air (body axes), density and speed of sound."""
        place = self.origin + self.axes @ s[:3]
        density, pressure, _ = earth.air(earth.geodetic(place)[1])
        through = self.axes @ s[7:10] - np.cross(earth.OMEGA, place)
        return c.T @ self.axes.T @ through, density, math.sqrt(1.4 * pressure / density)

    def calc_pushes(self, s, c):
        """PUSH of each booster."""
        pushes = []
        for k in range(4):
            place = c[0].T @ (s[k + 1, :3] - s[0, :3])
            azimuth = P["boosters"][k]["azimuth"]
            out = place[1] * math.cos(azimuth) + place[2] * math.sin(azimuth)
            lean = math.asin(c[0][:, 0] @ c[k + 1][:, 1])
            pushes.append(self.push(out - MOUNTED[1], MOUNTED[0] - place[0], lean))
        return pushes

    def calc_load(self, t, i, s, c):
        force, moment = super().calc_load(t, i, s, c)
        u, density, sound = self.meet(s[i], c[i])
        speed = np.linalg.norm(u)
        pressure = 0.5 * density * speed**2
        pushes = self.calc_pushes(s, c)
        if i == 0:
            side = pressure * AREA * np.array([0, pushes[2] - pushes[0], pushes[3] - pushes[1]])
            force = force + c[0] @ (side + [-0.35 * pressure * CORE_AREA, 0, 0])
            moment = moment + c[0] @ np.cross([MOUNTED[0] + NEAR, 0, 0], side)
        else:
            mach, slip, attack = speed / sound, math.asin(u[1] / speed), math.atan2(u[2], u[0])
            side, down, push = self.normal(mach, slip), self.normal(mach, attack), pushes[i - 1]
            spin = c[i].T @ (s[i, 10:13] - self.axes.T @ earth.OMEGA) * LENGTH / (2 * speed)
            force = force + pressure * AREA * c[i] @ [-self.axial(mach, slip), push - side, -down]
            moment = moment + pressure * AREA * c[i] @ [0, CENTRE * down + LENGTH * DAMPING * spin[1],
                                                        NEAR * push - CENTRE * side + LENGTH * DAMPING * spin[2]]
        place, turn = self.origin + self.axes @ s[i, :3], self.axes @ c[i]
        return force, moment + c[i] @ earth.gradient_torque(place, turn, np.diag(self.inertia[i]))

    def describe(self, y):
        """As Boosters.describe(), in W: axes of the Earth at the start, origin as here."""
        out = super().describe(y)
        for body in out:
            turn = self.axes @ rotation(np.array(body[3:7]))
            body[:3], body[3:7], body[7:10] = self.axes @ body[:3], earth.quaternion(turn), self.axes @ body[7:10]
        return [[float(x) for x in body] for body in out]


if __name__ == "__main__":
    events, samples = Ascent().run()
    print(events)
    about = ("tests/references/ascent_reference.py: dense KKT, DOP853 at rtol 3e-14, splines by SciPy. State: R (from the start), "
             "q (w x y z, body to inertial), V, w in body axes; core, then boosters; inertial axes, the Earth's. Events: t, name, booster")
    (DATA / "boosters_ascent.json").write_text(json.dumps({"about": about, "events": events, "samples": samples}, indent=1) + "\n")
