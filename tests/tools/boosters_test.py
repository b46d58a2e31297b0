#!/usr/bin/env python3
"""The boosters' cyclogram and its failures as users run them, against tests/support/boosters_reference.py (dense KKT, DOP853 at
1e-12) and against the sum of the forces. Run by ctest:

    boosters_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

BOOSTERS = SCENARIOS / "boosters"
REFERENCE = json.loads((SOURCE / "tests/data/boosters_cyclogram.json").read_text())
EVENT_TIME = 1e-6                                     # s, asked for at 1 ms
STATE = {"p": 1e-5, "q": 1e-6, "v": 1e-5, "w": 1e-7}  # 1e-6 of 10 m, 1, 10 m/s, 0.1 rad/s
ROUND_OFF = 1e-9                                      # m/s, rad/s
FULL, TILT, MASS = 300000 / 0.84, 0.087, 98500 + 4 * 4380


class BoostersTest(ProcessTest):
    def run_at(self, file, times, *overrides, code=0):
        return self.run_json(UNLATCH, "run", BOOSTERS / file, "--sample", ",".join(map(str, times)), *overrides, code=code)

    def compare(self, name, file, *overrides, missed=()):
        """`missed`: requirements that this flight does not meet."""
        reference = REFERENCE[name]
        states = {float(t): bodies for t, bodies in reference["samples"].items()}
        report = self.run_at(file, sorted(states), *overrides, code=1 if missed else 0)
        self.assertEqual([entry["id"] for entry in report["verdict"] if not entry["met"]], list(missed))
        self.assertEqual(report["status"], "ok")
        found = {(e["name"], e["subject"]): e["t"] for e in report["events"]
                 if e["name"] in ("release", "contact", "liftoff")}
        wanted = {(event, f"booster{k}"): t for t, event, k in reference["events"]}
        self.assertEqual(sorted(found), sorted(wanted))  # and nothing else let go
        worst_time = max(abs(found[key] - wanted[key]) for key in wanted)
        self.assertLess(worst_time, EVENT_TIME)
        worst = dict.fromkeys(STATE, 0)
        for sample in report["samples"]:
            for body, state in zip(sample["bodies"].values(), states[round(sample["t"], 9)], strict=True):
                sign = math.copysign(1, sum(a * b for a, b in zip(body["q"], state[3:7])))
                for key, part, factor in (("p", state[:3], 1), ("q", state[3:7], sign), ("v", state[7:10], 1),
                                          ("w", state[10:], 1)):
                    worst[key] = max([worst[key], *(abs(factor * a - b) for a, b in zip(body[key], part, strict=True))])
        for key, tolerance in STATE.items():
            self.assertLess(worst[key], tolerance, key)
        print(f"{name}: events {worst_time:.1e} s, {worst['p']:.1e} m, {worst['q']:.1e}, {worst['w']:.1e} rad/s",
              file=sys.stderr)
        return report

    def test_the_cyclogram_goes_as_the_reference_does(self):
        self.compare("cyclogram", "cyclogram.yaml")

    def test_a_late_valve_lets_its_nose_go_late(self):
        report = self.compare("late-valve", "late-valve.yaml")
        times = {e["subject"]: e["t"] for e in report["events"] if e["name"] == "liftoff"}
        self.assertGreater(times["booster1"], times["booster2"] + 0.3)

    def test_a_booster_whose_ties_hold_stays_and_turns_the_core(self):
        report = self.compare("uncut-tie", "uncut-tie.yaml", missed=["leaves2"])
        self.assertEqual(report["joints"]["nose2"], "tied")
        self.assertGreater(math.hypot(*report["samples"][-1]["bodies"]["core"]["w"]), 1e-4)

    def test_unequal_engines_let_go_at_unequal_times(self):
        self.compare("imbalance", "imbalance.yaml")

    def test_a_dead_nozzle_keeps_its_nose_as_long_as_the_reference_says(self):
        self.compare("dead-nozzle", "cyclogram.yaml", "--set", "events.nozzle:booster1.enabled=false", missed=["distance1"])

    # Beside the same flight without contact: what the strike changed, whose size the law's own sum tells.
    def test_a_strike_gives_booster_and_core_opposite_momenta_and_the_impulse_told(self):
        dead = ("--set", "events.contact:booster1.enabled=false")
        without = self.run_at("cyclogram.yaml", [2.58], *dead, "--until", "3", code=1)["samples"][0]["bodies"]
        struck = self.run_at("recontact.yaml", [2.58], code=1)
        bodies, (strike,) = struck["samples"][0]["bodies"], struck["contacts"]
        core, booster = ([mass * (a - b) for a, b in zip(bodies[name]["v"], without[name]["v"])]
                         for name, mass in (("core", 98500), ("booster1", 4380)))
        for a, b in zip(core, booster):
            self.assertAlmostEqual(a, -b, delta=0.05)  # N s; the loads of the two flights differ by the way since
        normal, slip = strike["impulse"], 0.3 * strike["impulse"]  # it slips all the while
        self.assertAlmostEqual(math.hypot(*booster), math.hypot(normal, slip), delta=0.005 * normal)
        self.assertEqual([entry["id"] for entry in struck["verdict"] if not entry["met"]], ["distance1"])

    def test_dispersed_tail_offs_let_each_go_at_its_own_time(self):
        report = self.compare("dispersed", "dispersed.yaml")
        times = sorted(e["t"] for e in report["events"] if e["name"] == "liftoff")
        self.assertGreater(min(b - a for a, b in zip(times, times[1:])), 0.001)

    def test_before_the_ties_are_cut_the_rocket_is_one_body(self):
        report = self.run_at("cyclogram.yaml", (0.09, 0.449))
        early, late = (sample["bodies"]["core"]["v"][0] for sample in report["samples"])
        # Main thrust points along the core; verniers lean with their booster.
        thrust = 990000 + 4 * (FULL + 70000 * math.cos(TILT))
        self.assertAlmostEqual(early, (thrust / MASS - 6.2) * 0.09, delta=ROUND_OFF)
        # Thrust falls to 84 % over 0.1 … 0.2 s, the verniers' to nothing over 0.25 … 0.29 s.
        impulse = (990000 * 0.449 + 4 * FULL * (0.1 + 0.92 * 0.1 + 0.84 * 0.249)
                   + 4 * 70000 * math.cos(TILT) * (0.25 + 0.5 * 0.04))
        self.assertAlmostEqual(late, impulse / MASS - 6.2 * 0.449, delta=ROUND_OFF)
        for body in report["samples"][1]["bodies"].values():
            self.assertAlmostEqual(body["v"][1], -7.4 * 0.449, delta=ROUND_OFF)
            self.assertLess(math.hypot(*body["w"]), ROUND_OFF)

    def test_failures_are_what_their_generator_writes(self):
        self.run_ok(BOOSTERS / "make-cyclogram", "--check")


if __name__ == "__main__":
    main()
