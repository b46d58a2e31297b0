#!/usr/bin/python3
"""Forces by linear tables, by the air and by other bodies, and the central field's torque, integrated by SciPy (DOP853, rtol 3e-14 and 1e-13).

Writes tests/data/terms.json: scenarios (JSON is YAML) with what their quantities are at the end. An entry with linear tables over the Mach
number and rows of the wind; a stage that brakes by a thrust that tails off, stands aside and points aside, under a parachute that opens,
with a probe in its plume that feels the air by expressions alone; a body that the gradient of a central field turns. Independent of
unlatch: the planet of flight_reference.py, tables by numpy and SciPy's splines, all formulas written out. No corner whose time is known lies
inside of an integration.
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


def blow(wind):
    return lambda z: np.array([np.interp(z, wind["altitude"], wind[way]) if way in wind else 0 for way in ("north", "east", "down")])


def integrate(flow, y, times, rtol=3e-14):
    for begin, end in zip(times[:-1], times[1:]):
        y = solve_ivp(flow, (begin, end), y, "DOP853", rtol=rtol, atol=10 * rtol, max_step=0.05).y[:, -1]
    return y


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

    def push(flow):
        u, V = flow["u"], np.linalg.norm(flow["u"])
        mach, alpha, beta = V / flow["sound"], math.atan2(u[2], u[0]), math.asin(u[1] / V)
        q = 0.5 * flow["density"] * V * V * area
        trim = np.interp(mach, MACHS, np.array(TRIMS) * DEG)
        moment = np.array([0, -0.12 * (alpha - trim), 0.12 * beta]) + damping * flow["w"] * length / (2 * V)
        return q * np.array([-np.interp(mach, MACHS, AXIALS), -0.25 * beta, -0.25 * alpha]), q * length * moment

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
    body = earth.Body(5500, [5800, 4900, 4500], push, blow(ENTRY_WIND), torque=False)
    return scenario, find_end(integrate(body, earth.start(**start), [0, end]), end)


# --- A plume and a parachute ------------------------------------------------------------------------------------------

def brake():
    end, opens = 3.0, 1.5
    start = {"latitude": 40 * DEG, "longitude": 10 * DEG, "altitude": 12e3, "velocity": (120, 30, 150), "euler": (0.1, -0.6, 0.2), "rate": (0, 0, 0)}
    offset, turn, nozzle, rise, spot = [0, 1e-3, 0], [0, 2e-3, -1e-3], np.array([-1, 0, 0]), np.array([-1.5, 0, 0.1]), np.array([0.2, 0, 0.05])
    along = Rotation.from_rotvec(turn).apply([1, 0, 0])
    over_aside = make_interp_spline(ASIDE, np.array(PLUME), k=3, axis=1)
    stage = earth.Body(300, [40, 90, 95], None, blow(WIND))
    probe = earth.Body(25, [2, 3, 3.5], None, blow(WIND))

    # Numbers of the state are relative to a point that goes on as the stage began, so that the tolerance is one of what happens.
    first = earth.start(**start)
    drift = np.concatenate([first[3:6], np.zeros(10)])

    def get_origin(t):
        return np.concatenate([first[:3] + t * first[3:6], first[3:6], np.zeros(7)])

    def flow(t, y):
        a, b = y[:13] + get_origin(t), y[13:] + get_origin(t)
        Ra, Rb = earth.matrix(a[6:10]), earth.matrix(b[6:10])
        thrust = np.interp(t, BURN, THRUSTS)
        x, y_, z = Ra.T @ (b[:3] - a[:3])
        aside, behind = min(math.sqrt(y_ * y_ + z * z), ASIDE[-1]), min(max(-x, 0), BEHIND[-1])
        blown = float(make_interp_spline(BEHIND, over_aside(aside), k=3)(behind)) * thrust / 900

        def push_stage(air):
            V = np.linalg.norm(air["u"])
            drag = np.interp(t - opens, OPENING, OPEN) if t > opens else 0
            pull = -0.5 * air["density"] * V * 1.5 * drag * air["u"]
            twist = -0.25 * air["density"] * V * 1.5 * 2**2 * np.array([0.05, 0.4, 0.4]) * air["w"] if t > opens else 0
            return thrust * along + pull, np.cross(nozzle + offset, thrust * along) + np.cross(rise, pull) + twist

        def push_probe(air):
            force = -0.5 * air["density"] * np.linalg.norm(air["u"]) * 0.02 * air["u"]
            return force - [blown, 0, 0], np.cross(spot, [-blown, 0, 0])
        stage.forces, probe.forces = push_stage, push_probe
        return np.concatenate([stage(t, a) - drift, probe(t, b) - drift])

    place = [-6.0, 0.4, 0.2]
    second = first.copy()
    second[:3] += earth.matrix(first[6:10]) @ place
    times = sorted(t for t in {0, end, *BURN, *(opens + t for t in OPENING)} if t <= end)
    y = integrate(flow, np.concatenate([first - get_origin(0), second - get_origin(0)]), times, rtol=1e-13)
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
    y = integrate(earth.Body(400, [40, 90, 100]), earth.start(**start), [0, end])
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
