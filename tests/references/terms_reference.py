#!/usr/bin/python3
"""Forces by linear tables, by the air and by other bodies, and the central field's torque, integrated by SciPy (DOP853, rtol 3e-14 and 1e-13).

Writes tests/data/terms.json: scenarios (JSON is YAML) with what their quantities are at the end. An entry with linear tables over the Mach
number and rows of the wind; a stage that brakes by a thrust that tails off, stands aside and points aside, under a parachute that opens,
with a probe in its plume that feels the air by expressions alone; a body that the gradient of a central field turns. Independent of
unlatch: the planet of flight_reference.py, tables as lines and SciPy's splines between their knots, all formulas written out. No corner lies
inside of a step: a piece of a table, a row of the wind or a layer of the air goes on beyond its ends until the integration has found where these
are passed, and begins anew there. Knots of splines count: steps of DOP853 over them, where the third derivative jumps, left the probe's pitch
2.3e-9 rad off after 5 s, most of it (1.5e-9) by the plume's knots over the distance aside; steps over rows of the wind and borders of layers left
2e-11 of a value's scale. With all of them located, tolerances of 1e-12, 1e-13 and 3e-14 agree within 5e-11 of it.
"""
import json
import math
import pathlib

import flight_reference as earth
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

FILE = pathlib.Path(__file__).parent.parent / "data/terms.json"
DEG = math.pi / 180
MACHS, TRIMS, AXIALS = [0, 1, 2, 4, 8, 16, 30], [-10, -16, -20, -22, -21, -20, -19.5], [0.9, 1.2, 1.35, 1.4, 1.38, 1.36, 1.36]
BURN, THRUSTS = [0, 0.4, 2.2, 3.1, 4], [0, 900, 850, 200, 0]
OPENING, OPEN = [0, 0.31, 0.92, 1.4], [0.02, 0.3, 1.1, 0.8]
BEHIND, ASIDE = [0, 2, 4, 7, 11, 16, 25, 60], [0, 0.5, 1, 2, 4, 8]
PLUME = [[round(90 * math.exp(-x / 9 - (y / (0.6 + 0.25 * x))**2), 3) for y in ASIDE] for x in BEHIND]
WIND = {"altitude": [8e3, 10.2e3, 10.9e3, 11.3e3, 12e3], "north": [5, -20, 10, 30, -10], "east": [0, 15, -25, 20, 40]}
ENTRY_WIND = {"altitude": [0, 10e3, 30e3, 55e3, 80e3], "east": [0, 30, -10, 50, 0]}


class Pieces:
    """The piece between two of the knots that a value, read(t, y), is in: `index`, or -1 and the last knot's beyond the ends. `integrate` moves it."""

    def __init__(self, knots, read):
        self.knots, self.read, self.index = np.array(knots, float), read, -1
        spline = make_interp_spline(self.knots, np.eye(len(knots)), k=3) if len(knots) > 3 else None
        self.taylor = [spline(self.knots[:-1], n) / math.factorial(n) for n in range(4)] if spline else []

    def begin(self, t, y):
        self.index = int(np.searchsorted(self.knots, self.read(t, y), side="right")) - 1

    def list_exits(self):
        """Events of solve_ivp, each with its piece."""
        exits = []
        for border, way in ((self.index, -1), (self.index + 1, 1)):
            if 0 <= border < len(self.knots):
                def leave(t, y, knot=self.knots[border]):
                    return self.read(t, y) - knot
                leave.terminal, leave.direction, leave.pieces = True, way, self
                exits.append(leave)
        return exits

    def weigh(self, x):
        """Weights of the knots' values in the line through the piece's ends; beyond the last ones those hold."""
        weights, i = np.zeros(len(self.knots)), self.index
        if 0 <= i < len(self.knots) - 1:
            weights[i + 1] = (x - self.knots[i]) / (self.knots[i + 1] - self.knots[i])
            weights[i] = 1 - weights[i + 1]
        else:
            weights[min(max(i, 0), len(self.knots) - 1)] = 1
        return weights

    def weigh_cubic(self, x):
        """Likewise in the not-a-knot spline."""
        i = min(max(self.index, 0), len(self.knots) - 2)
        if self.index != i:
            return self.weigh(x)
        return sum(c[i] * (x - self.knots[i])**n for n, c in enumerate(self.taylor))


def integrate(flow, y, end, pieces=(), rtol=3e-14):
    """In the order of `pieces`, since what one reads may depend on those before it."""
    t = 0.0
    for each in pieces:
        each.begin(t, y)
    while t < end:
        exits = [leave for each in pieces for leave in each.list_exits()]
        run = solve_ivp(flow, (t, end), y, "DOP853", rtol=rtol, atol=10 * rtol, max_step=0.05, events=exits or None)
        t, y = run.t[-1], run.y[:, -1]
        for leave, times in zip(exits, run.t_events or []):
            if len(times):
                leave.pieces.index += leave.direction
    return y


def find_altitude(place):
    return lambda t, y: earth.geodetic(place(t, y))[1]


def find_geopotential_altitude(place):
    altitude = find_altitude(place)
    return lambda t, y: earth.R0 * altitude(t, y) / (earth.R0 + altitude(t, y))


class Surroundings:
    """The wind's rows and the air's layers where a body is, for earth.Body."""

    def __init__(self, wind, place):
        self.table, self.rows = wind, Pieces(wind["altitude"], find_altitude(place))
        self.layers = Pieces([base for base, _ in earth.LAYERS], find_geopotential_altitude(place))
        self.pieces = [self.rows, self.layers]

    def wind(self, z):
        weights = self.rows.weigh(z)
        return np.array([weights @ self.table[way] if way in self.table else 0 for way in ("north", "east", "down")])

    def air(self, z):
        return earth.air(z, self.layers.index)


def list_quantities(body, suffix=""):
    """As earth.describe() names them."""
    out = {name: {name: body} for name in ("altitude", "latitude", "longitude")}
    out.update({way: {"surface_velocity": {"body": body, "component": way}} for way in ("north", "east", "down")})
    out.update({angle: {"euler_angles": {"body": body, "component": angle}} for angle in ("roll", "pitch", "yaw")})
    out.update({rate: {"rate": {"body": body, "component": axis}} for rate, axis in zip("pqr", "xyz")})
    return {name + suffix: quantity for name, quantity in out.items()}


def find_end(y, end, suffix=""):
    return {name + suffix: float(value) for name, value in earth.describe(y, end).items() if not name.startswith("inertial")}


def write_start(body, latitude, longitude, altitude, velocity, euler, rate):
    return {"body": body, "latitude": latitude, "longitude": longitude, "altitude": altitude, "velocity": list(velocity),
            "attitude": dict(zip(("roll", "pitch", "yaw"), euler)), "rate": list(rate)}


# --- An entry ---------------------------------------------------------------------------------------------------------

def enter():
    end, start = 200.0, {"latitude": -20 * DEG, "longitude": 60 * DEG, "altitude": 80e3, "euler": (30 * DEG, -20 * DEG, 120 * DEG), "rate": (3 * DEG, 0, 0)}
    climb, azimuth = -3 * DEG, 120 * DEG
    start["velocity"] = tuple(7200 * x for x in (math.cos(climb) * math.cos(azimuth), math.cos(climb) * math.sin(azimuth), -math.sin(climb)))
    area, length, damping = 12, 3.9, np.array([-0.02, -0.3, -0.3])

    def find_mach(_, y):
        flow = body.flow(y[:3], y[3:6], earth.matrix(y[6:10]), y[10:13])
        return np.linalg.norm(flow["u"]) / flow["sound"]

    machs, around = Pieces(MACHS, find_mach), Surroundings(ENTRY_WIND, lambda _, y: y[:3])

    def push(flow):
        u, V = flow["u"], np.linalg.norm(flow["u"])
        mach, alpha, beta = V / flow["sound"], math.atan2(u[2], u[0]), math.asin(u[1] / V)
        q = 0.5 * flow["density"] * V * V * area
        trim = machs.weigh(mach) @ TRIMS * DEG
        moment = np.array([0, -0.12 * (alpha - trim), 0.12 * beta]) + damping * flow["w"] * length / (2 * V)
        return q * np.array([-machs.weigh(mach) @ AXIALS, -0.25 * beta, -0.25 * alpha]), q * length * moment

    scenario = {
        "unlatch": 1, "name": "entry", "step": {"dt": 0.0008, "until": end},
        "environment": {"planet": "wgs84", "origin": "start", "atmosphere": "us1976", "gradient_torque": False, "wind": ENTRY_WIND},
        "start": write_start("body", **start), "bodies": {"body": {"mass": 5500, "inertia": [5800, 4900, 4500]}},
        "tables": {"trim": {"axes": {"m": {"of": "mach", "at": MACHS}}, "values": TRIMS, "unit": "deg"},
                   "axial": {"axes": {"m": {"of": "mach", "at": MACHS}}, "values": AXIALS}},
        "quantities": {**list_quantities("body"), "mach": {"mach": "body"}, "alpha": {"angle_of_attack": "body"}, "beta": {"sideslip": "body"}},
        "elements": {"air": {"type": "aerodynamics", "body": "body", "area": area, "length": length, "cx": {"expression": "-axial"},
                             "cy": {"expression": "-0.25 * beta / (1 rad)"}, "cz": {"expression": "-0.25 * alpha / (1 rad)"},
                             "cm": {"expression": "-0.12 * (alpha - trim) / (1 rad)"}, "cn": {"expression": "0.12 * beta / (1 rad)"},
                             "damping": {"cl": [-0.02, 0, 0], "cm": [0, -0.3, 0], "cn": [0, 0, -0.3]}}}}
    body = earth.Body(5500, [5800, 4900, 4500], push, around.wind, torque=False, air=around.air)
    return scenario, find_end(integrate(body, earth.start(**start), end, [*around.pieces, machs]), end)


# --- A plume and a parachute ------------------------------------------------------------------------------------------

def brake():
    end, opens = 5.0, 1.5
    start = {"latitude": 40 * DEG, "longitude": 10 * DEG, "altitude": 12e3, "velocity": (120, 30, 150), "euler": (0.1, -0.6, 0.2), "rate": (0, 0, 0)}
    offset, turn, nozzle, rise, spot = [0, 1e-3, 0], [0, 2e-3, -1e-3], np.array([-1, 0, 0]), np.array([-1.5, 0, 0.1]), np.array([0.2, 0, 0.05])
    along = Rotation.from_rotvec(turn).apply([1, 0, 0])

    # Numbers of the state are relative to a point that goes on as the stage began, so that the tolerance is one of what happens.
    first = earth.start(**start)
    drift = np.concatenate([first[3:6], np.zeros(10)])

    def get_origin(t):
        return np.concatenate([first[:3] + t * first[3:6], first[3:6], np.zeros(7)])

    def find_probe(y):
        """Behind the stage, and aside."""
        x, y_, z = earth.matrix(y[6:10]).T @ (y[13:16] - y[:3])
        return -x, math.hypot(y_, z)

    burn, opening = Pieces(BURN, lambda t, _: t), Pieces(OPENING, lambda t, _: t - opens)
    behind, aside = Pieces(BEHIND, lambda _, y: find_probe(y)[0]), Pieces(ASIDE, lambda _, y: find_probe(y)[1])
    around_stage = Surroundings(WIND, lambda t, y: y[:3] + get_origin(t)[:3])
    around_probe = Surroundings(WIND, lambda t, y: y[13:16] + get_origin(t)[:3])
    stage = earth.Body(300, [40, 90, 95], None, around_stage.wind, air=around_stage.air)
    probe = earth.Body(25, [2, 3, 3.5], None, around_probe.wind, air=around_probe.air)

    def flow(t, y):
        a, b = y[:13] + get_origin(t), y[13:] + get_origin(t)
        thrust = burn.weigh(t) @ THRUSTS
        back, far = find_probe(y)
        blown = behind.weigh_cubic(back) @ PLUME @ aside.weigh_cubic(far) * thrust / 900

        def push_stage(air):
            V = np.linalg.norm(air["u"])
            drag = opening.weigh(t - opens) @ OPEN if opening.index >= 0 else 0
            pull = -0.5 * air["density"] * V * 1.5 * drag * air["u"]
            twist = -0.25 * air["density"] * V * 1.5 * 2**2 * np.array([0.05, 0.4, 0.4]) * air["w"] if opening.index >= 0 else 0
            return thrust * along + pull, np.cross(nozzle + offset, thrust * along) + np.cross(rise, pull) + twist

        def push_probe(air):
            force = -0.5 * air["density"] * np.linalg.norm(air["u"]) * 0.02 * air["u"]
            return force - [blown, 0, 0], np.cross(spot, [-blown, 0, 0])
        stage.forces, probe.forces = push_stage, push_probe
        return np.concatenate([stage(t, a) - drift, probe(t, b) - drift])

    place = [-6.0, 0.4, 0.2]
    begin = first - get_origin(0)
    second = np.concatenate([earth.matrix(first[6:10]) @ place, begin[3:]])
    y = integrate(flow, np.concatenate([begin, second]), end, [burn, opening, behind, aside, *around_stage.pieces, *around_probe.pieces], rtol=1e-13)
    y = y + np.concatenate([get_origin(end), get_origin(end)])
    scenario = {
        "unlatch": 1, "name": "braking", "step": {"dt": 0.0005, "until": end},
        "environment": {"planet": "wgs84", "origin": "start", "atmosphere": "us1976", "wind": WIND}, "start": write_start("stage", **start),
        "bodies": {"stage": {"mass": 300, "inertia": [40, 90, 95]}, "probe": {"mass": 25, "inertia": [2, 3, 3.5], "position": place}},
        "tables": {"burn": {"axes": {"t": {"of": {"on_time": "retro"}, "at": BURN}}, "values": THRUSTS, "unit": "N"},
                   "opening": {"axes": {"t": {"of": {"on_time": "parachute"}, "at": OPENING}}, "values": OPEN},
                   "plume": {"axes": {"behind": {"at": BEHIND, "unit": "m"}, "aside": {"at": ASIDE, "unit": "m"}},
                             "values": [value for row in PLUME for value in row], "unit": "N", "interpolation": "smooth"}},
        "quantities": {**list_quantities("stage"), **list_quantities("probe", "2"),
                       **{axis: {"position": {"body": "probe", "relative_to": "stage", "component": axis}} for axis in "xyz"},
                       **{axis: {"air_velocity": {"body": "probe", "component": part}} for axis, part in zip("uvw", "xyz")},
                       "density": {"density": "probe"}, "airspeed": {"airspeed": "probe"},
                       "braking": {"expression": "0.5 * density * airspeed * 0.02 m^2"}},
        "elements": {
            "retro": {"type": "thrust", "body": "stage", "point": [-1, 0, 0], "direction": [1, 0, 0], "offset": offset, "misalignment": turn,
                      "profile": {"expression": "burn"}},
            "parachute": {"type": "aerodynamics", "body": "stage", "area": 1.5, "length": 2, "point": [-1.5, 0, 0.1], "drag": {"expression": "opening"},
                          "damping": {"cl": [-0.05, 0, 0], "cm": [0, -0.4, 0], "cn": [0, 0, -0.4]}, "enabled": False},
            "plume": {"type": "force", "body": "probe", "point": [0.2, 0, 0.05], "direction": [-1, 0, 0],
                      "profile": {"expression": "plume(-x, sqrt(y^2 + z^2)) * burn / (900 N)"}},
            **{f"drag_{axis}": {"type": "force", "body": "probe", "direction": direction, "profile": {"expression": f"-braking * {axis}"}}
               for axis, direction in zip("uvw", ([1, 0, 0], [0, 1, 0], [0, 0, 1]))}},
        "events": [{"name": "open", "when": {"time": opens}, "then": [{"switch": {"element": "parachute", "to": True}}]}]}
    return scenario, {**find_end(y[:13], end), **find_end(y[13:], end, "2")}


# --- A central field --------------------------------------------------------------------------------------------------

def turn_by_a_central_field():
    end, radius = 600.0, 6371e3
    start = {"latitude": 0.4, "longitude": -1.2, "altitude": 400e3, "velocity": (4000, 6500, -100), "euler": (0.3, -0.4, 1.1), "rate": (0.002, -0.001, 0.003)}
    kept = earth.A, earth.B, earth.F, earth.E2, earth.J2
    earth.A, earth.B, earth.F, earth.E2, earth.J2 = radius, radius, 0, 0, 0
    y = integrate(earth.Body(400, [40, 90, 100]), earth.start(**start), end)
    scenario = {"unlatch": 1, "name": "central", "step": {"dt": 0.05, "until": end},
                "environment": {"planet": {"radius": radius, "flattening": 0, "mu": earth.MU, "j2": 0, "rate": earth.RATE}, "origin": "falling"},
                "start": write_start("body", **start), "bodies": {"body": {"mass": 400, "inertia": [40, 90, 100]}},
                "quantities": list_quantities("body")}
    found = find_end(y, end)
    earth.A, earth.B, earth.F, earth.E2, earth.J2 = kept
    return scenario, found


def main():
    cases = {}
    for make in (enter, brake, turn_by_a_central_field):
        scenario, end = make()
        cases[scenario["name"]] = {"scenario": scenario, "end": end}
        print(scenario["name"], {name: round(value, 5) for name, value in end.items()}, flush=True)
    lines = [f"{json.dumps(name)}: {json.dumps(case)}" for name, case in cases.items()]
    FILE.write_text('{"about": "tests/references/terms_reference.py",\n' + ",\n".join(lines) + "}\n")


if __name__ == "__main__":
    main()
