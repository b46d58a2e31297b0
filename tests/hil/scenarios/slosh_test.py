#!/usr/bin/env python3
"""Propellant swings in an upper stage: against Lagrange's equations, and the frequency of a pendulum. Run by ctest:

    slosh_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

SLOSH = SCENARIOS / "slosh/scenario.yaml"
PLACE, ANGLE = 1e-7, 1e-9  # m of 485 m, rad; both methods, at 1 ms: the jet's corner is at a tick


def run(*options):
    return json.loads(call(UNLATCH, "run", *options, "--json", "-").stdout)


def get_angle(body):
    w, _, _, z = body["q"]
    return 2 * math.atan2(z, w)


class SloshTest(ProcessTest):
    def test_it_moves_as_an_independent_integration(self):
        reference = json.loads((SOURCE / "tests/data/slosh.json").read_text())
        bodies = run(SLOSH, "--sample", "10")["samples"][-1]["bodies"]
        stage, pendulum, mass = bodies["stage"], bodies["slosh1"], bodies["slosh2"]
        for axis in (0, 1):
            self.assertAlmostEqual(stage["p"][axis], reference["place"][axis], delta=PLACE)
        self.assertAlmostEqual(get_angle(stage), reference["turn"], delta=ANGLE)
        self.assertAlmostEqual(stage["w"][2], reference["rate"], delta=ANGLE)
        self.assertAlmostEqual(get_angle(pendulum) - get_angle(stage), reference["swing"], delta=10 * ANGLE)
        a = get_angle(stage)
        path = -math.sin(a) * (mass["p"][0] - stage["p"][0]) + math.cos(a) * (mass["p"][1] - stage["p"][1])
        self.assertAlmostEqual(path, reference["path"], delta=PLACE)

    # In a stage so heavy that it does not answer, the time between two passes of the pendulum is half a period.
    def test_a_pendulum_in_a_heavy_stage_has_the_frequency_of_its_length(self):
        found = run(SLOSH, "--set", "constants.stage=1e9 kg", "--set", "constants.thrust=1e10 N", "--set", "constants.zeta=0", "--set",
                    "bodies.stage.inertia=[1e12, 1e12, 1e12]", "--set", "bodies.slosh1.rate=[0, 0, 0.01]", "--set", "bodies.slosh1.velocity=[0, -0.0065, 0]", "--set", "elements.jet.profile.scale=0",
                    "--set", "step.until=6", "--set",
                    "events=[{name: middle, when: {rate: {body: slosh1, component: z}, below: 0}, repeat: true}]")
        times = [event["t"] for event in found["events"] if event["name"] == "middle"]
        periods = [b - a for a, b in zip(times, times[1:])]
        self.assertGreater(len(periods), 2)
        # With the moving mass's own inertia: T^2 = 4 pi^2 (L^2 + k^2) / (L a); the amplitude adds its square / 16.
        expected = 2 * math.pi * math.sqrt((0.65**2 + 0.05**2) / (0.65 * 1e10 / (1e9 + 1600)))
        for period in periods:
            self.assertAlmostEqual(period, expected, delta=1e-4 * expected)


if __name__ == "__main__":
    main()
