#!/usr/bin/env python3
"""A yo-yo stops a satellite's spin: against closed forms, and a planar integration that is independent of the kernel. Run by ctest:

    yoyo_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

YOYO, LATE = SCENARIOS / "yoyo/scenario.yaml", SCENARIOS / "yoyo/late.yaml"
PLANAR = ["--set", "constants.plane=0"]
FINE = ["--set", "step.dt=0.0001"]
# Errors: the cords oscillate at 25 Hz and decay; the method is of the fourth order, at a tenth of the scenario's step.
TIME, RATE, SPEED, FORCE = 2e-9, 2e-8, 2e-7, 1e-4  # s, rad/s, m/s of 40 m/s, N of 555 N
BALANCE = 1e-5  # of the energy, at 1 ms


def run(*options):
    return json.loads(call(UNLATCH, "run", *options, "--json", "-").stdout)


def get_times(found):
    return {event["name"] + (f":{event['subject']}" if event["subject"] else ""): event["t"] for event in found["events"]}


def get_verdicts(found):
    return {verdict["id"]: verdict for verdict in found["verdict"]}


class YoyoTest(ProcessTest):
    def compare(self, scenario, reference):
        found = run(scenario, *PLANAR, *FINE, "--sample", "1.5")
        times = get_times(found)
        for name, time in reference["events"].items():
            self.assertAlmostEqual(times[name], time, delta=TIME, msg=name)
        bodies = found["samples"][-1]["bodies"]
        self.assertAlmostEqual(bodies["satellite"]["w"][2], reference["rate"], delta=RATE)
        for axis in (0, 1):
            self.assertAlmostEqual(bodies["satellite"]["v"][axis], reference["satellite"][axis], delta=SPEED)
            for i in (0, 1):
                self.assertAlmostEqual(bodies[f"tip{i + 1}"]["v"][axis], reference["tips"][i][axis], delta=SPEED)

    def test_it_moves_as_an_independent_integration(self):
        self.compare(YOYO, json.loads((SOURCE / "tests/data/yoyo.json").read_text())["both"])

    def test_with_one_mass_late_it_does_too(self):
        self.compare(LATE, json.loads((SOURCE / "tests/data/yoyo.json").read_text())["late"])

    # Stiff cords remove any spin completely.
    def test_stiff_cords_leave_no_spin_whatever_it_was(self):
        for spin in ("60 rpm", "120 rpm"):
            rates = []
            for stiffness in (2e5, 8e5):
                found = run(YOYO, *FINE, "--set", f"constants.stiffness={stiffness} N/m", "--set", f"constants.spin={spin}",
                            "--set", "step.until=2", "--set", "constants.tension=1 mN", "--sample", "2")
                rates.append(abs(found["samples"][-1]["bodies"]["satellite"]["w"][2]))
            self.assertLess(rates[1], 0.002)
            self.assertLess(rates[1], 0.5 * rates[0])

    def test_all_requirements_are_met_and_nothing_is_slack(self):
        found = run(YOYO)
        self.assertEqual([name for name, verdict in get_verdicts(found).items() if not verdict["met"]], [])
        # Windings and forces of cords are compared where steps end alone.
        self.assertEqual({(notice["name"], notice["subject"], notice["unresolved"]) for notice in found["notices"]},
                         {("accuracy.search", name, False) for name in ("overload", "unwound", "release")})
        names = [event["name"] for event in found["events"]]
        for name in ("taut", "slack", "overload"):
            self.assertNotIn(name, names)
        times = get_times(found)
        for i in (1, 2):
            self.assertEqual(times[f"unwound:cord{i}"], times[f"release:cord{i}"])

    # The cords are above the centre of mass: a single one tilts the satellite.
    def test_a_late_mass_pulls_the_satellite_aside_and_makes_it_wobble(self):
        verdicts = get_verdicts(run(LATE))
        self.assertEqual(sorted(name for name, verdict in verdicts.items() if not verdict["met"]), ["drift", "pair", "wobble"])
        self.assertTrue(verdicts["spin"]["met"])

    def test_momentum_and_energy_balance(self):
        for scenario in (YOYO, LATE):
            found = run(scenario, "--sample", "1.5")
            self.assertLess(abs(found["energy"]["largest_unexplained"]), BALANCE * found["energy"]["scale"])
            bodies = found["samples"][-1]["bodies"]
            for axis in range(3):
                momentum = sum(mass * bodies[name]["v"][axis] for name, mass in (("satellite", 180), ("tip1", 0.8), ("tip2", 0.8)))
                self.assertLess(abs(momentum), 1e-9)

    # Released along the radius, the cords first swing about their hinges, and may be shorter by that radius.
    def test_released_along_the_radius_shorter_cords_stop_it(self):
        length = "sqrt(from_axis^2 + inertia / (2*tip)) - radius"
        found = run(YOYO, *FINE, "--set", f"constants.length={length}", "--set", "constants.stiffness=800 kN/m", "--set", "constants.tension=1 mN",
                    "--set", "elements.cord1.wraps.releases=radial", "--set", "elements.cord2.wraps.releases=radial", "--sample", "1.5")
        self.assertLess(abs(found["samples"][-1]["bodies"]["satellite"]["w"][2]), 0.005)
        times = get_times(found)
        self.assertGreater(times["release:cord1"], times["unwound:cord1"] + 0.005)

    # Angle and length on the drum are consistent; both are outputs.
    def test_outputs_give_what_is_left_on_the_drum(self):
        found = run(YOYO, "--sample", "0.1,0.5,1")
        names = [sample["elements"]["cord1"] for sample in found["samples"]]
        self.assertGreater(names[0]["wound"], 2 * math.pi)
        self.assertGreater(names[0]["wound"], names[1]["wound"])
        self.assertAlmostEqual(names[1]["on_drum"], 0.4 * names[1]["wound"], delta=1e-9)
        self.assertEqual(names[2]["force"], 0)

    def test_the_recording_replays(self):
        log = self.folder / "yoyo.log"
        call(UNLATCH, "run", LATE, "--log", log)
        self.assertIn("every bit agrees", call(UNLATCH, "replay", log).stdout)


if __name__ == "__main__":
    main()
