#!/usr/bin/python3
"""Random flights with forces of the air by tables and expressions, integrated by SciPy (DOP853, rtol 3e-14).

Writes tests/data/coefficients.json: scenarios (JSON is YAML) with what their quantities are at the end. A body with products of inertia
starts in random local axes at a point of a trajectory over an oblate planet, the Earth or another with a tilted pole; wind over the
altitude; coefficients over Mach number, angle of attack, sideslip, altitude and rates, as tables, expressions and sums; damping by tables
and expressions. Independent of unlatch: the planet of flight_reference.py, splines of SciPy, all formulas written out; about the planet's
centre, whatever the origin of the scenario.
"""
import json
import math
import pathlib

import flight_reference as earth
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

FILE = pathlib.Path(__file__).parent.parent / "data/coefficients.json"
SEEDS, END, STEP = range(1, 7), 10.0, 0.000625
DEG = math.pi / 180
MACHS, ATTACKS = [0.5, 2, 4, 6, 9, 13, 20, 30], [float(a) for a in range(-180, 181, 10)]  # deg
DAMPED = [0.5, 3, 8, 15, 30]


def draw_vector(dice, size):
    return [float(x) for x in dice.uniform(-size, size, 3)]


def draw_planet(dice, seed):
    """Scenario's keys, and numbers of the reference; every second one is not the Earth."""
    if seed % 2:
        return "wgs84", {"A": 6378137.0, "F": 1 / 298.257223563, "MU": 3.986004418e14, "J2": 1.08262982e-3, "RATE": 7.292115e-5}, [0, 0, 1.0], 0.0
    own = {"A": 3.4e6, "F": 0.04, "MU": 4.3e13, "J2": 4e-3, "RATE": 2.1e-4}
    pole, meridian = draw_vector(dice, 1), float(dice.uniform(-3, 3))
    keys = {"radius": own["A"], "flattening": own["F"], "mu": own["MU"], "j2": own["J2"], "rate": own["RATE"], "pole": pole, "meridian": meridian}
    return keys, own, pole, meridian


class Case:
    def __init__(self, seed):
        dice = np.random.default_rng(seed)
        self.planet_keys, self.planet, pole, meridian = draw_planet(dice, seed)
        for name, value in self.planet.items():
            setattr(earth, name, value)
        earth.B, earth.E2, earth.OMEGA = earth.A * (1 - earth.F), earth.F * (2 - earth.F), np.array([0, 0, earth.RATE])
        z = np.array(pole) / np.linalg.norm(pole)
        x = np.array([1.0, 0, 0]) - z[0] * z
        x /= np.linalg.norm(x)
        y = np.cross(z, x)
        self.to_w = np.stack([math.cos(meridian) * x + math.sin(meridian) * y, math.cos(meridian) * y - math.sin(meridian) * x, z], axis=1)
        self.scale_height, self.thin = float(dice.uniform(6e3, 9e3)), float(dice.uniform(0.5, 1.5))
        self.earthly = seed % 2 == 1
        self.winds = [[float(v) for v in dice.uniform(-60, 60, 2)] for _ in range(3)]  # at 0 and 120 km: north, east, down
        self.at = {"latitude": float(dice.uniform(-1.4, 1.4)), "longitude": float(dice.uniform(-3, 3)), "altitude": float(dice.uniform(25e3, 40e3))}
        self.speed, self.climb, self.azimuth = float(dice.uniform(900, 2200)), float(dice.uniform(-0.5, 0.5)), float(dice.uniform(-3, 3))
        self.inertial, self.rates_in = bool(dice.integers(2)), ("inertial", "planet", "local")[dice.integers(3)]
        self.euler = [float(dice.uniform(-3, 3)), self.climb + float(dice.uniform(-0.2, 0.2)), self.azimuth + float(dice.uniform(-0.2, 0.2))]
        self.rate = draw_vector(dice, 0.1)
        self.mass = float(dice.uniform(300, 900))
        turn = earth.euler_matrix(*dice.uniform(-0.3, 0.3, 3))
        self.inertia = turn @ np.diag([250.0, 900, 1000]) @ turn.T
        self.area, self.lengths, self.point = float(dice.uniform(0.5, 2)), [float(x) for x in dice.uniform(0.5, 3, 3)], draw_vector(dice, 0.02)
        wave = dice.uniform(0.8, 1.2, 6)
        m, a = np.meshgrid(MACHS, np.array(ATTACKS) * DEG, indexing="ij")
        self.axial = wave[0] * (0.2 + 0.8 / m) * (0.6 + 0.4 * np.cos(a) ** 2)
        self.normal = wave[1] * np.sin(2 * a) * (1.5 + 1 / m)
        self.pitching = -wave[2] * 0.6 * np.sin(a) * (1 + 0.3 / m)
        self.damped = -wave[3] * (0.5 + 1 / np.array(DAMPED))
        self.scales = [float(x) for x in dice.uniform(0.8, 1.2, 3)]
        self.offsets = [float(x) for x in dice.uniform(-0.02, 0.02, 3)]
        self.origin = ("centre", "start", "falling")[seed % 3]

    def write(self):
        def over(values):
            return {"axes": {"mach": {"of": "mach", "at": MACHS}, "attack": {"of": "alpha", "at": [f"{a} deg" for a in ATTACKS], "unit": "rad", "ends": "error"}},
                    "values": values.tolist(), "interpolation": "smooth"}
        tables = {"axial": over(self.axial), "normal": over(self.normal), "pitching": over(self.pitching),
                  "damped": {"axes": {"mach": {"of": "mach", "at": DAMPED}}, "values": self.damped.tolist(), "interpolation": "smooth"}}
        for name, scale, offset in zip(("axial", "normal", "pitching"), self.scales, self.offsets):
            tables[name].update(scale=scale, offset=offset)
        if self.earthly:
            atmosphere = "us1976"
        else:
            heights = [0.0, 10e3, 30e3, 60e3, 100e3]
            atmosphere = {"altitude": heights, "density": [self.thin * math.exp(-z / self.scale_height) for z in heights],
                          "pressure": [6e4 * self.thin * math.exp(-z / self.scale_height) for z in heights]}
        parts = {"altitude": "body", "latitude": "body", "longitude": "body"}
        quantities = {name: {name: body} for name, body in parts.items()}
        quantities.update({name: {"surface_velocity": {"body": "body", "component": name}} for name in ("north", "east", "down")})
        quantities.update({name: {"euler_angles": {"body": "body", "component": name}} for name in ("roll", "pitch", "yaw")})
        quantities.update({name: {"rate": {"body": "body", "component": axis}} for name, axis in zip("pqr", "xyz")})
        quantities.update({f"place_{axis}": {"inertial_position": {"body": "body", "component": axis}} for axis in "xyz"})
        quantities.update(mach={"mach": "body"}, alpha={"angle_of_attack": "body"}, beta={"sideslip": "body"}, height={"altitude": "body"},
                          thin={"expression": "exp(-height / (50 km))"})
        air = {"type": "aerodynamics", "body": "body", "area": self.area, "lengths": self.lengths, "point": self.point,
               "cx": {"expression": "-axial"}, "cy": [{"expression": "-1.5 * sin(beta) * cos(beta)", "scale": 1.1}, 0.003],
               "cz": [{"expression": "-normal"}, {"expression": "0.05 * thin"}],
               "cl": {"expression": "0.01 * sin(alpha) * beta / (1 rad)", "offset": 0.0001}, "cm": [{"expression": "pitching"}, 0.004],
               "cn": {"expression": "0.5 * sin(beta) * (1 + 0.2 * sqrt(1 / mach))"}, "drag": {"expression": "0.02 * min(mach, 3)", "scale": 0.5},
               "damping": {"cl": [{"expression": "-0.3 / mach"}, 0, 0], "cm": [0, [{"expression": "damped"}, -0.1], 0], "cn": [0, 0, {"expression": "damped", "scale": 0.9}],
                           "cz": [0, -1.5, 0]}}
        return {"unlatch": 1, "name": "flight", "step": {"dt": STEP, "until": END},
                "environment": {"planet": self.planet_keys, "origin": self.origin, "atmosphere": atmosphere,
                                "wind": {"altitude": [0.0, 120e3], **dict(zip(("north", "east", "down"), self.winds))}},
                "start": {**self.at, "velocity": {"speed": self.speed, "flight_path_angle": self.climb, "azimuth": self.azimuth},
                          "relative_to": "inertial" if self.inertial else "planet", "attitude": dict(zip(("roll", "pitch", "yaw"), self.euler)),
                          "rate": self.rate, "rate_relative_to": self.rates_in, "body": "body"},
                "bodies": {"body": {"mass": self.mass, "inertia": self.inertia.tolist()}}, "tables": tables, "quantities": quantities,
                "elements": {"air": air}}

    # --- Motion ------------------------------------------------------------------------------------------------------

    def start(self):
        r, local = earth.place(*self.at.values()), earth.local_axes(self.at["latitude"], self.at["longitude"])
        over = self.speed * np.array([math.cos(self.climb) * math.cos(self.azimuth), math.cos(self.climb) * math.sin(self.azimuth), -math.sin(self.climb)])
        turning = np.cross(earth.OMEGA, r)
        v, R = local @ over + (0 if self.inertial else turning), local @ earth.euler_matrix(*self.euler)
        w = np.array(self.rate)
        if self.rates_in != "inertial":
            w = w + R.T @ earth.OMEGA
        if self.rates_in == "local":  # the axes north, east, down turn as the place moves over the ellipsoid
            north, east, _ = local.T @ (v - turning)
            s = math.sin(self.at["latitude"])
            across = earth.A / math.sqrt(1 - earth.E2 * s * s)
            along = across * (1 - earth.E2) / (1 - earth.E2 * s * s)
            longitude_rate = east / ((across + self.at["altitude"]) * math.cos(self.at["latitude"]))
            latitude_rate = north / (along + self.at["altitude"])
            w = w + R.T @ (np.array([0, 0, longitude_rate]) - latitude_rate * local[:, 1])
        return np.concatenate([r, v, earth.quaternion(R), w])

    def prepare(self):
        def spline(values):
            inner = make_interp_spline(MACHS, values, k=3)
            return lambda m, a: float(make_interp_spline(np.array(ATTACKS) * DEG, inner(m), k=3)(a))
        self.tables = [spline(values) for values in (self.axial, self.normal, self.pitching)]
        self.damp = make_interp_spline(DAMPED, self.damped, k=3)

    def meet(self, r, v):
        """Density, pressure, velocity through the air in planet's axes, altitude."""
        latitude, altitude = earth.geodetic(r)
        if self.earthly:
            density, pressure, _ = earth.air(altitude)
        else:
            density = self.thin * math.exp(-altitude / self.scale_height)
            pressure = 6e4 * density
        wind = [a + (b - a) * altitude / 120e3 for a, b in self.winds]
        local = earth.local_axes(latitude, math.atan2(r[1], r[0]))
        return density, pressure, v - np.cross(earth.OMEGA, r) - local @ wind, altitude

    def flow(self, _, y):
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:13]
        R = earth.matrix(q)
        density, pressure, through, altitude = self.meet(r, v)
        u = R.T @ through
        V = np.linalg.norm(u)
        mach, alpha, beta = V / math.sqrt(1.4 * pressure / density), math.atan2(u[2], u[0]), math.asin(u[1] / V)
        axial, normal, pitching = (s * t(mach, alpha) + o for s, t, o in zip(self.scales, self.tables, self.offsets))
        damped = float(self.damp(mach))
        p = (w - R.T @ earth.OMEGA) * self.lengths / (2 * V)
        c = np.array([-axial, -1.65 * math.sin(beta) * math.cos(beta) + 0.003, -normal + 0.05 * math.exp(-altitude / 50e3) - 1.5 * p[1]])
        m = np.array([0.01 * math.sin(alpha) * beta + 0.0001 - 0.3 / mach * p[0], pitching + 0.004 + (damped - 0.1) * p[1],
                      0.5 * math.sin(beta) * (1 + 0.2 * math.sqrt(1 / mach)) + 0.9 * damped * p[2]])
        pressing = 0.5 * density * V * V * self.area
        force = pressing * (c - 0.01 * min(mach, 3) * u / V)
        moment = pressing * m * self.lengths + np.cross(self.point, force)
        second = 0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia
        M = R.T @ earth.gradient(r) @ R @ second
        moment = moment + [M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]]
        turn = np.linalg.solve(self.inertia, moment - np.cross(w, self.inertia @ w))
        rate = 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])
        return np.concatenate([v, earth.gravity(r) + R @ force / self.mass, rate, turn])

    def fly(self):
        self.prepare()
        y = solve_ivp(self.flow, (0, END), self.start(), "DOP853", rtol=3e-14, atol=1e-13, max_step=0.2).y[:, -1]
        found = earth.describe(y, END)
        place, _ = self.to_w @ y[:3], found.pop("inertial_velocity")
        found.pop("inertial_position")
        u = earth.matrix(y[6:10]).T @ self.meet(y[:3], y[3:6])[2]
        found.update({f"place_{axis}": value for axis, value in zip("xyz", place)}, alpha=math.atan2(u[2], u[0]), beta=math.asin(u[1] / np.linalg.norm(u)))
        return {name: float(value) for name, value in found.items()}


def main():
    cases = {}
    for seed in SEEDS:
        case = Case(seed)
        cases[f"seed {seed}"] = {"scenario": case.write(), "end": case.fly()}
        print(seed, case.origin, {k: round(v, 4) for k, v in cases[f"seed {seed}"]["end"].items()}, flush=True)
    lines = [f"{json.dumps(name)}: {json.dumps(case)}" for name, case in cases.items()]
    FILE.write_text('{"about": "tests/references/coefficients_reference.py",\n' + ",\n".join(lines) + "}\n")


if __name__ == "__main__":
    main()
