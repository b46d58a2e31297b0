#!/usr/bin/env python3
"""Linear tables, rows of the wind, a thrust that tails off and points aside, a plume, a parachute, the torque of a central field: against
tests/references/terms_reference.py (DOP853, steps that end at every corner). Run by ctest:

    terms_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import sys

from processes import SOURCE, UNLATCH, ProcessTest, main

REFERENCE = json.loads((SOURCE / "tests/data/terms.json").read_text())
# Of the value's scale in a flight. The references have no corner within a step, nor a knot of a spline, and are good to 5e-11.
RELATIVE = 1e-9
# Errors of a step and of its half; 16 by the fourth order. Both are far above the reference's own.
RATIO = (14, 18)
SCALES = {"altitude": 25e3, "latitude": 1, "longitude": 1, "roll": 1, "pitch": 1, "yaw": 1}
SPEEDS = {"entry": 600, "braking": 150, "central": 7000}  # m/s
RATES = {"entry": 0.2, "braking": 2, "central": 0.01}     # rad/s, that it reaches


class TermsTest(ProcessTest):
    def find_error(self, name, dt=None):
        """The largest error at the end of a flight, of its value's scale, and whose it is."""
        scenario, end = REFERENCE[name]["scenario"], REFERENCE[name]["end"]
        if dt:
            scenario = {**scenario, "step": {**scenario["step"], "dt": dt}}
        file = self.folder / f"{name}.yaml"
        file.write_text(json.dumps(scenario))
        report = self.run_json(UNLATCH, "run", file, "--sample", scenario["step"]["until"])
        self.assertEqual(report["status"], "ok")
        self.assertEqual([notice for notice in report["notices"] if notice["unresolved"]], [])
        found = report["samples"][-1]["quantities"]

        def get_scale(quantity):
            quantity = quantity.rstrip("2")
            return SPEEDS[name] if quantity in ("north", "east", "down") else RATES[name] if quantity in "pqr" else SCALES[quantity]
        self.assertGreater(len(end), 11)
        error, whose = max((abs(found[key] - value) / get_scale(key), key) for key, value in end.items())
        print(f"{name}: {error:.1e} ({whose})", file=sys.stderr)
        return error, whose

    def measure(self, name):
        error, whose = self.find_error(name)
        self.assertLess(error, RELATIVE, whose)

    def test_an_entry_by_linear_tables_goes_as_its_reference_does(self):
        self.measure("entry")

    def test_a_stage_under_its_parachute_and_a_probe_in_its_plume_go_as_their_reference_does(self):
        self.measure("braking")

    def test_the_error_of_a_parachute_and_a_plume_falls_with_the_fourth_power_of_the_step(self):
        ratio = self.find_error("braking", 0.002)[0] / self.find_error("braking", 0.001)[0]
        self.assertGreater(ratio, RATIO[0])
        self.assertLess(ratio, RATIO[1])

    def test_a_central_field_turns_a_body_as_its_reference_does(self):
        self.measure("central")


if __name__ == "__main__":
    main()
