#!/usr/bin/env python3
"""A launcher with two stages: against an independent integration, in both frames of its origin. Run by ctest:

    launcher_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

FILE = SCENARIOS / "launcher/scenario.yaml"
REFERENCE = json.loads((SOURCE / "tests/data/launcher.json").read_text())
RELATIVE = 1e-9  # of the value's scale
SCALES = {"altitude": 84e3, "latitude": 1, "longitude": 1, "north": 2500, "east": 2500, "down": 2500, "roll": 1, "pitch": 1, "yaw": 1, "p": 0.1, "q": 0.1,
          "r": 0.1}
NAMES = {"p": "turn_p", "q": "turn_q", "r": "turn_r"}


class LauncherTest(ProcessTest):
    def measure(self, *options):
        """The largest error at the end of the reference, of the value's scale, whose it is, and the error of the burnout, s."""
        report = self.run_json(UNLATCH, "run", FILE, "--until", REFERENCE["t"], "--sample", REFERENCE["t"], *options, code=None)
        self.assertEqual(report["status"], "ok")
        found = report["samples"][-1]["quantities"]
        burnout = next(event["t"] for event in report["events"] if event["name"] == "burnout")
        return (*max((abs(found[NAMES.get(name, name)] - value) / SCALES[name], name) for name, value in REFERENCE["end"].items()),
                abs(burnout - REFERENCE["burnout"]))

    # tests/references/launcher_reference.py: one body with changing masses, about the Earth's centre.
    def test_it_flies_and_stages_as_an_independent_integration(self):
        error, whose, late = self.measure("--set", "step.dt=5 ms")
        print(f"{error:.1e} ({whose}), burnout {late:.1e} s", file=sys.stderr)
        self.assertLess(error, RELATIVE, whose)
        self.assertLess(late, 1e-9)

    def test_it_flies_the_same_with_w_at_the_centre(self):
        error, whose, late = self.measure("--set", "environment.origin=centre")
        self.assertLess(error, 10 * RELATIVE, whose)  # rounding of places of 6.4e6 m, and of rates that follow
        self.assertLess(late, 1e-8)

    def test_requirements_are_met_to_the_end(self):
        report = self.run_json(UNLATCH, "run", FILE)
        self.assertTrue(all(entry["met"] for entry in report["verdict"]))
        self.assertEqual([event["name"] for event in report["events"]], ["burnout", "ignition"])


if __name__ == "__main__":
    main()
