#!/usr/bin/env python3
"""A rocket of two stages to orbit, by tables: against an independent integration, in both frames of its origin. Run by ctest:

    twostage_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

FILE = SCENARIOS / "checkcases/two-stage.yaml"
REFERENCE = json.loads((SOURCE / "tests/data/two_stage.json").read_text())
RELATIVE = 1e-9  # of the value's scale
SCALES = {"altitude": 210e3, "latitude": 1, "longitude": 1, "north": 7500, "east": 7500, "down": 7500, "roll": 1, "pitch": 1, "yaw": 1, "p": 0.1,
          "q": 0.1, "r": 0.1, "spent": 108e3, "spent2": 19.5e3}
LATE = 1e-9  # s, of an event: at 7.8 km/s and 1 g a cut-off that is late by 1e-9 s leaves places within 1e-5 m, velocities within 1e-8 m/s


class TwoStageTest(ProcessTest):
    def measure(self, *options):
        """The largest error at the times of the reference, of the value's scale, whose and when it is, and that of the events, s."""
        times = ",".join(str(at["t"]) for at in REFERENCE["at"])
        report = self.run_json(UNLATCH, "run", FILE, "--until", REFERENCE["at"][-1]["t"], "--sample", times, *options, code=None)
        self.assertEqual(report["status"], "ok")
        errors = [(abs(sample["quantities"][name] - at[name]) / scale, f"{name} at {at['t']} s")
                  for sample, at in zip(report["samples"], REFERENCE["at"], strict=True) for name, scale in SCALES.items()]
        found = {event["name"]: event["t"] for event in report["events"]}
        self.assertEqual(found.keys(), REFERENCE["events"].keys())
        return (*max(errors), max(abs(t - REFERENCE["events"][name]) for name, t in found.items()))

    # tests/references/two_stage_reference.py: one body with changing masses, about the Earth's centre.
    def test_it_reaches_its_orbit_as_an_independent_integration(self):
        error, whose, late = self.measure("--set", "step.dt=5 ms")
        print(f"{error:.1e} ({whose}), events {late:.1e} s", file=sys.stderr)
        self.assertLess(error, RELATIVE, whose)
        self.assertLess(late, LATE)

    def test_it_flies_the_same_with_w_at_the_centre(self):
        error, whose, late = self.measure("--set", "environment.origin=centre")
        self.assertLess(error, 10 * RELATIVE, whose)  # rounding of places of 6.4e6 m, and of rates that follow
        self.assertLess(late, 1e-8)

    def test_requirements_are_met_to_the_end(self):
        report = self.run_json(UNLATCH, "run", FILE)
        self.assertTrue(all(entry["met"] for entry in report["verdict"]))
        self.assertEqual([event["name"] for event in report["events"]], ["burnout", "ignition", "cutoff"])


if __name__ == "__main__":
    main()
