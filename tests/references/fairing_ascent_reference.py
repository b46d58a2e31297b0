#!/usr/bin/python3
"""Tight-tolerance reference of fairing/ascent.yaml, the jettison in air, independent of unlatch's code: the mass points, hinges and
integration of fairing_reference.py; the Earth's field, axes and air of flight_reference.py; tables by SciPy's splines.

All vectors are in the scenario's frame at the start, from a point at rest in inertial space. Gravity acts on each mass point. On each
marker m of half k acts, in the marker's axes, (u, v, w) its velocity through the air, q = rho V^2 / 2, incidence = atan2(-v, w):
    F = share_m q S (0, NORMAL(mach, incidence) + NEAR(opening_k, opening_other), -AXIAL(mach, incidence))

    fairing_ascent_reference.py   writes tests/data/fairing_ascent.json; needs python3-scipy; some minutes
"""
import json
import math

import fairing_reference
import flight_reference as earth
import numpy as np
from ascent_reference import Spline
from fairing_reference import CORE_INERTIA, CORE_MASS, ROOT, TURNS, Half, Jettison

DEG = math.pi / 180
FOLDER = ROOT / "hil/scenarios/fairing"
LATITUDE, LONGITUDE, ALTITUDE, SPEED, CLIMB, AZIMUTH = 48 * DEG, 70 * DEG, 80e3, 2500.0, 20 * DEG, 64 * DEG
AREA = 44.0
SHARES = {"base_left": 0.1, "base_right": 0.1, "middle_left": 0.2, "middle_right": 0.2, "top_left": 0.15, "top_right": 0.15, "nose": 0.1}


def gravity(r):
    """Central field and J2 at places (n, 3) from the centre."""
    d = np.linalg.norm(r, axis=1)[:, None]
    s = r[:, 2:] / d
    k = -1.5 * earth.J2 * earth.MU * earth.A**2 / d**4
    return -earth.MU * r / d**3 + k * ((1 - 5 * s * s) * r / d + 2 * s * np.array([0, 0, 1]))


class Ascent(Jettison):
    def __init__(self, half):
        super().__init__(half, until=3.0)
        self.normal, self.axial = (Spline(FOLDER / "ascent-free.csv", ("mach", "incidence"), name) for name in ("cn", "ca"))
        self.near = Spline(FOLDER / "ascent-near.csv", ("opening", "other"), "cn")
        local = earth.local_axes(LATITUDE, LONGITUDE)
        self.axes = local @ earth.euler_matrix(0, 110 * DEG, AZIMUTH)
        self.origin = earth.place(LATITUDE, LONGITUDE, ALTITUDE)
        over = SPEED * np.array([math.cos(CLIMB) * math.cos(AZIMUTH), math.cos(CLIMB) * math.sin(AZIMUTH), -math.sin(CLIMB)])
        self.start[7:10] = self.axes.T @ (local @ over + np.cross(earth.OMEGA, self.origin))

    def calc_gravity(self, places):
        return gravity(self.origin + places @ self.axes.T) @ self.axes

    def calc_core_load(self, core):
        p, R = core[:2]
        torque = earth.gradient_torque(self.origin + self.axes @ p, self.axes @ R, CORE_INERTIA)
        return np.concatenate([CORE_MASS * self.calc_gravity(p[None])[0], torque])

    def calc_opening(self, core, own, eta, rate, k):
        """Angle of the hinge, positive outwards."""
        if len(own) == 2:
            return own[0] * fairing_reference.SIDE[k]
        turn = core[1].T @ self.pose(core, own, eta, rate, k)[1] @ self.half.turn_of("hinge", eta, rate)[0] @ TURNS[k].T
        return math.atan2(turn[2, 1] - turn[1, 2], turn[1, 1] + turn[2, 2]) * fairing_reference.SIDE[k]

    def calc_half_load(self, core, halves, k, flat):
        own, eta, rate = halves[k]
        places = self.motion(core, own, eta, rate, k, self.half.r, self.half.phi)[0]
        load = flat.T @ (np.repeat(self.half.m, 3) * self.calc_gravity(places).ravel())
        openings = [self.calc_opening(core, *halves[i], i) for i in (k, 1 - k)]
        near = self.near(*openings)
        speeds = np.concatenate([core[2], core[3], [own[1]], rate] if len(own) == 2 else [own[7:10], own[10:13], rate])
        R_half = self.pose(core, own, eta, rate, k)[1]
        for name, share in SHARES.items():
            place, phi, _ = self.half.at[name]
            p, J, _ = self.motion(core, own, eta, rate, k, place[None], phi[None])
            R = R_half @ self.half.turn_of(name, eta, rate)[0]
            at = self.origin + self.axes @ p[0]
            density, pressure, _ = earth.air(earth.geodetic(at)[1])
            u = R.T @ self.axes.T @ (self.axes @ (J[0] @ speeds) - np.cross(earth.OMEGA, at))
            mach, incidence = np.linalg.norm(u) / math.sqrt(1.4 * pressure / density), math.atan2(-u[1], u[2])
            force = [0, self.normal(mach, incidence) + near, -self.axial(mach, incidence)]
            load += J[0].T @ R @ (0.5 * density * u @ u * share * AREA * np.array(force))
        return load

    def describe(self, y):
        """As Jettison.describe(), in W: axes of the Earth at the start."""
        out = super().describe(y)
        for body in out["bodies"]:
            turn = self.axes @ fairing_reference.rotation(np.array(body[3:7]))
            body[:3], body[3:7], body[7:10] = ([float(x) for x in v] for v in (self.axes @ body[:3], fairing_reference.quaternion(turn), self.axes @ body[7:10]))
        return out


if __name__ == "__main__":
    found = Ascent(Half(FOLDER / "fairing.modes")).run()
    print(found["events"])
    about = ("tests/references/fairing_ascent_reference.py: as fairing_jettison.json; places from the start, in the Earth's axes there")
    (ROOT / "tests/data/fairing_ascent.json").write_text(json.dumps({"about": about, "looked_at": fairing_reference.LOOKED_AT, **found}, indent=1) + "\n")
