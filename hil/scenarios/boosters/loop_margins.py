#!/usr/bin/python3
"""Margins of the attitude loop of attitude-loop.yaml, for the core alone and with its boosters tied: loop_margins.py

The plant of each axis is a double integrator, angle'' = c u, with u held between samples of the period T. Commands act d samples
late. In z = exp(i w T) the open loop is exactly

    L = z^-d c (K T^2/2 (z + 1)/(z - 1)^2 + D T/(z - 1))

with K the attitude gain, D the rate gain. Left out: products of rates, the hinges between the cutting of the ties and the last
liftoff, elasticity, liquids in tanks; the lag of the drives is part of the delay. SI and radians.
"""
import cmath
import math
import pathlib

import yaml

FOLDER = pathlib.Path(__file__).parent
UNITS = {"kN": 1e3, "t": 1e3, "m": 1, "kg": 1, "ms": 1e-3, "mrad": 1e-3}
LEAN = 0.087  # rad, of the boosters towards the core


def read(value):
    """A number, or one with a unit."""
    if not isinstance(value, str):
        return float(value)
    number, _, unit = value.partition(" ")
    return float(number) * (UNITS[unit] if unit else 1)


class Loop:
    """One axis. `acceleration`: c, rad/s2 for a rad of u; `attitude`, `rate`: K, D in s; `period`: T; `late`: d."""

    def __init__(self, name, acceleration, attitude, rate, period, late):
        self.name, self.acceleration, self.attitude, self.rate, self.period, self.late = name, acceleration, attitude, rate, period, late

    def calc_open_loop(self, frequency):
        """L at a frequency in rad/s."""
        z, t = cmath.exp(1j * frequency * self.period), self.period
        return z**-self.late * self.acceleration * (self.attitude * t * t / 2 * (z + 1) / (z - 1)**2 + self.rate * t / (z - 1))

    def find(self, function, low, high):
        """Where a falling function is 0."""
        for _ in range(100):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if function(middle) > 0 else (low, middle)
        return low

    def calc_margins(self):
        """Gain margin (a factor) and its frequency, phase margin (rad) and its frequency, delay margin (s)."""
        nyquist = 0.999 * math.pi / self.period
        crossing = self.find(lambda w: abs(self.calc_open_loop(w)) - 1, 1e-3, nyquist)
        phase = math.pi + cmath.phase(self.calc_open_loop(crossing))
        # The phase above -180 degrees, positive at the crossing and negative at the end.
        turning = self.find(lambda w: cmath.phase(-self.calc_open_loop(w)), crossing, nyquist)
        return {"gain": 1 / abs(self.calc_open_loop(turning)), "gain_at": turning, "phase": phase, "phase_at": crossing,
                "delay": phase / crossing}


def read_vehicle():
    """Inertias about y (or z) and x, and the distance from the centre of mass to the chambers: of the core, and with boosters."""
    scenario = yaml.safe_load((FOLDER / "scenario.yaml").read_text())
    constants, core = scenario["constants"], scenario["bodies"]["core"]
    booster = scenario["templates"]["booster"]["bodies"]["booster<i>"]
    mass, added = read(core["mass"]), read(booster["mass"])
    x, radius = read(constants["centre_x"]), read(constants["centre_radius"])
    along, across, outwards = booster["inertia"][0], booster["inertia"][2], booster["inertia"][1]
    centre = 4 * added * x / (mass + 4 * added)
    s2, c2 = math.sin(LEAN)**2, math.cos(LEAN)**2
    lateral = core["inertia"][1] + mass * centre**2 + 4 * added * (x - centre)**2 + 2 * added * radius**2
    lateral += 2 * (along * s2 + outwards * c2) + 2 * across
    roll = core["inertia"][0] + 4 * (added * radius**2 + along * c2 + outwards * s2)
    return {"core alone": (core["inertia"][1], core["inertia"][0], 0.0), "boosters tied": (lateral, roll, centre)}


def list_loops():
    """The axes of both vehicles: y (z is the same), and roll."""
    scenario = yaml.safe_load((FOLDER / "attitude-loop.yaml").read_text())
    constants, channels = scenario["constants"], scenario["channels"]
    gain = {name: read(channels[name]["initial"]) for name in channels if name.endswith("_gain")}
    period = read(scenario["timing"]["groups"]["navigation"]["period"])
    late = round(scenario["flight_software"]["delay"] * 1e-3 / period)
    thrust, x, radius = (read(constants[f"vernier_{name}"]) for name in ("thrust", "x", "radius"))
    loops = []
    for vehicle, (lateral, roll, centre) in read_vehicle().items():
        loops.append(Loop(f"y and z, {vehicle}", 2 * thrust * (centre - x) / lateral, gain["attitude_gain"], gain["rate_gain"], period, late))
        loops.append(Loop(f"x, {vehicle}", 4 * thrust * radius / roll, gain["roll_attitude_gain"], gain["roll_rate_gain"], period, late))
    return loops


if __name__ == "__main__":
    print("axis                       c 1/s2   gain margin        phase margin      delay margin")
    for loop in list_loops():
        m = loop.calc_margins()
        print(f"{loop.name:<25} {loop.acceleration:8.4f}   {m['gain']:5.1f} ({20 * math.log10(m['gain']):.1f} dB) at {m['gain_at']:.1f}/s   "
              f"{math.degrees(m['phase']):.1f} deg at {m['phase_at']:.2f}/s   {1000 * m['delay']:.0f} ms")
