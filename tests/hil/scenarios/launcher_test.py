#!/usr/bin/env python3
"""Rockets of two stages, the launcher and that of the check cases: against independent integrations, in both frames of their origin. Run by
ctest:

    launcher_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

RELATIVE = 1e-9  # of the value's scale
LATE = 1e-9      # s, of an event: at 7.8 km/s and 1 g a cut-off that is late by 1e-9 s leaves places within 1e-5 m, velocities within 1e-8 m/s
SCALES = {"latitude": 1, "longitude": 1, "roll": 1, "pitch": 1, "yaw": 1, "p": 0.1, "q": 0.1, "r": 0.1}


class Flight:
    """A scenario, its reference's values and events, the scales of its altitude and speeds, other names of its quantities."""

    def __init__(self, file, reference, altitude, speed, scales, names):
        self.file, self.names = SCENARIOS / file, names
        self.reference = json.loads((SOURCE / "tests/data" / reference).read_text())
        self.scales = {**SCALES, "altitude": altitude, "north": speed, "east": speed, "down": speed, **scales}


FLIGHTS = [  # tests/references/launcher_reference.py, two_stage_reference.py: one body with changing masses, about the Earth's centre
    Flight("launcher/scenario.yaml", "launcher.json", 84e3, 2500, {}, {"p": "turn_p", "q": "turn_q", "r": "turn_r"}),
    Flight("checkcases/two-stage.yaml", "two_stage.json", 210e3, 7500, {"spent": 108e3, "spent2": 19.5e3}, {}),
]


class LauncherTest(ProcessTest):
    def compare(self, relative, late, *options):
        for flight in FLIGHTS:
            times = [at["t"] for at in flight.reference["at"]]
            report = self.run_json(UNLATCH, "run", flight.file, "--until", times[-1], "--sample", ",".join(map(str, times)), *options, code=None)
            self.assertEqual(report["status"], "ok")
            error, whose = max((abs(sample["quantities"][flight.names.get(name, name)] - at[name]) / scale, f"{name} at {at['t']} s")
                               for sample, at in zip(report["samples"], flight.reference["at"], strict=True) for name, scale in flight.scales.items())
            found = {event["name"]: event["t"] for event in report["events"]}
            self.assertEqual(found.keys(), flight.reference["events"].keys())
            delay = max(abs(found[name] - t) for name, t in flight.reference["events"].items())
            print(f"{flight.file.name}: {error:.1e} ({whose}), events {delay:.1e} s", file=sys.stderr)
            with self.subTest(flight.file):
                self.assertLess(error, relative, whose)
                self.assertLess(delay, late)

    def test_they_fly_and_stage_as_independent_integrations(self):
        self.compare(RELATIVE, LATE, "--set", "step.dt=5 ms")

    def test_they_fly_the_same_with_w_at_the_centre(self):
        # Rounding of places of 6.4e6 m, and of rates that follow.
        self.compare(10 * RELATIVE, 10 * LATE, "--set", "environment.origin=centre")

    def test_requirements_are_met_to_the_end(self):
        for flight, events in zip(FLIGHTS, (["burnout", "ignition"], ["burnout", "ignition", "cutoff"]), strict=True):
            report = self.run_json(UNLATCH, "run", flight.file)
            self.assertTrue(all(entry["met"] for entry in report["verdict"]))
            self.assertEqual([event["name"] for event in report["events"]], events)


if __name__ == "__main__":
    main()
