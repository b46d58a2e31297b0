#!/usr/bin/env python3
"""Bodies near the Earth: against an independent integration, and against three simulations of NASA/TM-2015-218675. Run by ctest:

    checkcases_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

FOLDER = SCENARIOS / "checkcases"
FOOT, SLUG, POUND, DEGREE, KELVIN = 0.3048, 14.593902937206365, 4.4482216152605, math.pi / 180, 5 / 9
CASES = ("case01", "case02", "case03", "case04", "case05", "case06", "case07", "case08", "case09", "case10")

# Errors of the comparison with the integration, of the value's scale in a case.
RELATIVE = 1e-9
SCALES = {"altitude": 5000, "latitude": 1, "longitude": 1, "north": 300, "east": 300, "down": 300, "roll": 1, "pitch": 1, "yaw": 1, "p": 0.5, "q": 0.5,
          "r": 0.5}

# The report's numbers, in its units: least and greatest of three simulations (02, 04, 06) at 10, 20 and 30 s.
TIMES = (10, 20, 30)
UNITS = {"north": FOOT, "east": FOOT, "down": FOOT, "altitude": FOOT, "longitude": DEGREE, "gravity": FOOT, "yaw": DEGREE, "pitch": DEGREE,
         "roll": DEGREE, "p": DEGREE, "q": DEGREE, "r": DEGREE, "sound": FOOT, "density": SLUG / FOOT**3, "pressure": POUND / FOOT**2,
         "temperature": KELVIN, "mach": 1}
REPORT = {
    "case01": {
        "east": [(0.233093508, 0.233326824), (0.933018798, 0.933485487), (2.1003109, 2.10101109)],
        "down": [(319.967327, 319.967337), (640.032384, 640.032404), (960.293065, 960.293095)],
        "altitude": [(28400.204, 28400.2041), (23600.3275, 23600.3277), (15598.9039, 15598.9044)],
        "longitude": [(2.12e-06, 2.12654134e-06), (1.7e-05, 1.70166181e-05), (5.74e-05, 5.74552213e-05)],
        "gravity": [(32.1114378, 32.1114466), (32.1261682, 32.1261868), (32.1507529, 32.1507814)],
        "roll": [(-0.0417828679, -0.041782858), (-0.0835784993, -0.083578461), (-0.125399679, -0.125399593)],
        "sound": [(1001.69694, 1001.6974), (1021.97302, 1021.97405), (1054.92871, 1054.92938)],
        "density": [(0.000944239806, 0.000944521), (0.00111985787, 0.001120197), (0.00146718319, 0.001467602)],
        "pressure": [(676.755567, 676.949801), (835.447335, 835.689855), (1166.29231, 1166.61319)],
        "temperature": [(417.528059, 417.528593), (434.602325, 434.602587), (463.083387, 463.084194)],
        "mach": [(0.319425219, 0.319425368), (0.626271347, 0.626271998), (0.910293536, 0.910294082)],
    },
    "case02": {
        "east": [(0.233093508, 0.233326824), (0.933018798, 0.933485487), (2.1003109, 2.10101109)],
        "down": [(319.967327, 319.967337), (640.032384, 640.032404), (960.293065, 960.293095)],
        "altitude": [(28400.204, 28400.2041), (23600.3275, 23600.3277), (15598.9039, 15598.9044)],
        "longitude": [(2.12e-06, 2.12654134e-06), (1.7e-05, 1.70166181e-05), (5.74e-05, 5.74552213e-05)],
        "gravity": [(32.1114378, 32.1114466), (32.1261682, 32.1261868), (32.1507529, 32.1507814)],
        "yaw": [(-4.5377475, -4.32009439), (-6.5130583, -6.36969383), (-4.28935504, -4.146742)],
        "pitch": [(3.73904282, 3.90226914), (4.05961177, 4.11989939), (-3.82195527, -3.50581011)],
        "roll": [(-67.3370106, -66.0190032), (1.54891402, 4.138318), (-59.8566339, -56.1503043)],
        "p": [(-2.41890222, -2.41590001), (-5.42567957, -5.42273468), (12.6183908, 12.6208441)],
        "q": [(-23.553076, -23.5525695), (22.7147751, 22.7159306), (-17.3974748, -17.3945502)],
        "r": [(28.1282945, 28.1285926), (28.6082817, 28.6089268), (31.1195889, 31.1207383)],
        "sound": [(1001.69694, 1001.6974), (1021.97302, 1021.97405), (1054.92871, 1054.92938)],
        "density": [(0.000944239806, 0.000944521), (0.00111985787, 0.001120197), (0.00146718319, 0.001467602)],
        "pressure": [(676.755567, 676.949801), (835.447335, 835.689855), (1166.29231, 1166.61319)],
        "temperature": [(417.528059, 417.528593), (434.602325, 434.602587), (463.083387, 463.084194)],
        "mach": [(0.319425219, 0.319425368), (0.626271347, 0.626271998), (0.910293536, 0.910294082)],
    },
    "case06": {
        "east": [(0.230319175, 0.230548715), (0.885927774, 0.886366695), (1.84232074, 1.84293086)],
        "down": [(316.911229, 316.911995), (613.933897, 613.939334), (863.993887, 864.010906)],
        "altitude": [(28407.783, 28407.7845), (23727.1675, 23727.1943), (16284.4438, 16284.5778)],
        "longitude": [(2.11e-06, 2.11143931e-06), (1.65e-05, 1.65120812e-05), (5.33797622e-05, 5.34e-05)],
        "gravity": [(32.1114146, 32.1114233), (32.1257792, 32.1257971), (32.1486471, 32.1486731)],
        "roll": [(-0.0417828528, -0.041782843), (-0.0835779947, -0.083577958), (-0.125395604, -0.125395527)],
        "sound": [(1001.6646, 1001.66507), (1021.44208, 1021.44329), (1052.14462, 1052.14515)],
        "density": [(0.000943980407, 0.000944264), (0.00111491707, 0.00111527), (0.00143455025, 0.001434667)],
        "pressure": [(676.525973, 676.721709), (830.897622, 831.150305), (1134.34071, 1134.42021)],
        "temperature": [(417.501104, 417.501635), (434.150873, 434.151281), (460.642339, 460.642731)],
        "mach": [(0.316384533, 0.316385362), (0.601046839, 0.601051456), (0.821175793, 0.821191703)],
    },
    "case09": {
        "east": [(786.25548, 786.313764), (681.966713, 682.026632), (610.679671, 610.746582)],
        "down": [(-500.079061, -500.025444), (-134.990838, -134.940058), (181.748229, 181.793345)],
        "altitude": [(7306.16259, 7306.60595), (10422.9845, 10423.9542), (10159.5363, 10160.9898)],
        "longitude": [(0.024024355, 0.0240256289), (0.043987684, 0.0439905844), (0.061643207, 0.0616478507)],
        "gravity": [(32.1762999, 32.1763177), (32.1667031, 32.1667112), (32.1675124, 32.1675134)],
        "pitch": [(0.024025267, 0.024030213), (0.0439899475, 0.043996401), (0.0616469712, 0.061653874)],
        "q": [(-0.00417807413, -0.00417686233), (-0.00417807413, -0.00417686233), (-0.00417807413, -0.00417686233)],
        "sound": [(1088.05508, 1088.05573), (1075.71856, 1075.72186), (1076.76453, 1076.76949)],
        "density": [(0.00190887109, 0.001909374), (0.00173230552, 0.001732773), (0.00174669512, 0.001747061)],
        "pressure": [(1614.19054, 1614.60052), (1431.85239, 1432.23241), (1446.55523, 1446.85625)],
        "temperature": [(492.6226, 492.623889), (481.515082, 481.518717), (482.45193, 482.457059)],
        "mach": [(0.85637609, 0.856448248), (0.646253264, 0.646319052), (0.591737057, 0.591787389)],
    },
}
# What a simulation prints: digits of a number that are certain. The spread of the three is the tolerance, but not less than this.
PRINTED = 2e-7


class CheckcasesTest(ProcessTest):
    def get_samples(self, name, times, *options):
        found = self.run_json(UNLATCH, "run", FOLDER / f"{name}.yaml", "--sample", ",".join(map(str, times)), *options)
        return [{**sample["quantities"], **sample} for sample in found["samples"]]

    def test_they_move_as_an_independent_integration(self):
        for name in CASES:
            reference = json.loads((SOURCE / "tests/data/flight.json").read_text())["cases"][name]
            found = self.get_samples(name, [reference["t"]], "--set", "step.dt=5 ms")[-1]
            for key, scale in SCALES.items():
                with self.subTest(case=name, quantity=key):
                    self.assertAlmostEqual(found[key], reference[key], delta=RELATIVE * scale)

    def test_they_agree_with_the_report_within_the_spread_of_its_simulations(self):
        for name, table in REPORT.items():
            samples = self.get_samples(name, TIMES)
            for key, rows in table.items():
                for sample, (low, high) in zip(samples, rows):
                    value = sample[key] / UNITS[key]
                    spread = max(high - low, PRINTED * max(abs(low), abs(high)))
                    with self.subTest(case=name, quantity=key, t=sample["t"]):
                        self.assertTrue(low - spread <= value <= high + spread, f"{value} beside {low} … {high}")

    # Wherever W is, the motion is the same.
    def test_the_origin_of_w_does_not_matter(self):
        for name in ("case02", "case09"):
            centre = self.get_samples(name, [20])[-1]
            for origin in ("start", "falling"):
                moved = self.get_samples(name, [20], "--set", f"environment.origin={origin}")[-1]
                for key, scale in SCALES.items():
                    with self.subTest(case=name, origin=origin, quantity=key):
                        self.assertAlmostEqual(moved[key], centre[key], delta=1e-8 * scale)

    # Gravity over a body in orbit turns it: 600 s at 400 km, against the integration.
    def test_the_gradient_of_gravity_turns_a_body(self):
        text = """unlatch: 1
name: gradient
step: {dt: 0.1 s, until: 600 s}
environment: {planet: wgs84, atmosphere: us1976, origin: falling}
bodies: {body: {mass: 400 kg, inertia: [40, 90, 100]}}
start: {latitude: 0.4, longitude: -1.2, altitude: 400 km, velocity: [4000, 6500, -100], attitude: {roll: 0.3, pitch: -0.4, yaw: 1.1}, rate: [0.002, -0.001, 0.003]}
quantities:
  p: {rate: {body: body, component: x}}
  q: {rate: {body: body, component: y}}
  r: {rate: {body: body, component: z}}
  altitude: {altitude: body}
  latitude: {latitude: body}
  longitude: {longitude: body}
"""
        path = self.folder / "gradient.yaml"
        path.write_text(text)
        reference = json.loads((SOURCE / "tests/data/flight.json").read_text())["cases"]["gradient"]
        found = self.run_json(UNLATCH, "run", path, "--sample", "600")["samples"][-1]["quantities"]
        for key, scale in {"p": 0.01, "q": 0.01, "r": 0.01, "altitude": 6e6, "latitude": 1, "longitude": 1}.items():
            self.assertAlmostEqual(found[key], reference[key], delta=RELATIVE * scale, msg=key)


if __name__ == "__main__":
    main()
