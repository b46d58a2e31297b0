#!/usr/bin/env python3
"""Antennas open and lock: against tests/references/antenna_reference.py (one degree of freedom each, DOP853 at 1e-12), symmetries and
conservation laws. Run by ctest:

    antenna_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import re
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

ANTENNA = SCENARIOS / "antenna"
REFERENCE = json.loads((SOURCE / "tests/data/antenna.json").read_text())
EVENT_TIME = 1e-11  # s
STATE = 2e-9        # m, rad, of motions of a metre and a radian; latches ring at 4 Hz, a thousandth of 1/dt
FORCE = 1e-5        # relative, of the largest reaction: it is interpolated between ticks
CONSERVED = 1e-9    # kg m/s, kg m2/s, of parts of some ten
RIBS, CELLS = 12, 6


def rotate(q, v):
    w, x, y, z = q
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def calc_momenta(bodies, properties):
    """Returns momentum and angular momentum about W's origin; `properties` are mass and principal inertias of each body."""
    linear, angular = [0.0] * 3, [0.0] * 3
    for name, (mass, inertia) in properties.items():
        body = bodies[name]
        momentum = [mass * v for v in body["v"]]
        spin = rotate(body["q"], [j * w for j, w in zip(inertia, body["w"])])
        linear = [a + b for a, b in zip(linear, momentum)]
        angular = [a + b + c for a, b, c in zip(angular, spin, cross(body["p"], momentum))]
    return linear, angular


def list_rib_bodies():
    rod = 1.5 * 2.4**2 / 12
    return {"hub": (400, (120, 120, 90)), **{f"rib{i}": (1.5, (1e-3, rod, rod)) for i in range(1, RIBS + 1)}}


def list_ring_bodies():
    post, bar = 0.8 * 1.7**2 / 12, 0.6 * 0.8**2 / 3
    found = {"spacecraft": (250, (60, 70, 60))}
    for i in range(1, CELLS + 1):
        found |= {f"post{i}": (0.8, (post, post, 5e-4)), f"slider{i}": (0.3, (2e-4,) * 3),
                  f"a{i}": (0.6, (1e-4, bar, bar)), f"b{i}": (0.6, (1e-4, bar, bar))}
    return found


def get_times(report, name):
    return {event["subject"]: event["t"] for event in report["events"] if event["name"] == name}


def get_verdicts(report):
    return {verdict["id"]: verdict for verdict in report["verdict"]}


class AntennaTest(ProcessTest):
    def fly(self, scenario, times, *options, code=0):
        report = self.run_json(UNLATCH, "run", ANTENNA / scenario, "--sample", ",".join(map(str, times)), *options, code=code)
        self.assertEqual(report["status"], "ok")
        self.assertEqual(report["notices"], [])
        return report

    def compare(self, scenario, name, times_of, states_of):
        """Compares events and states with those of the reference of this name; returns the report."""
        reference = REFERENCE[name]
        report = self.fly(scenario, sorted(map(float, reference["samples"])))
        worst_time = 0
        for event, time in reference["events"].items():
            found = get_times(report, event)
            self.assertEqual(len(found), times_of[event])
            worst_time = max(worst_time, *(abs(t - time) for t in found.values()))
        self.assertLess(worst_time, EVENT_TIME)
        worst = 0
        for sample in report["samples"]:
            for found, wanted in states_of(sample, reference["samples"][str(round(sample["t"], 9))]):
                worst = max(worst, abs(found - wanted))
        self.assertLess(worst, STATE)
        print(f"{name}: events {worst_time:.1e} s, states {worst:.1e}", file=sys.stderr)
        return report

    def compare_shock(self, report, requirement, reference):
        verdict = get_verdicts(report)[requirement]
        self.assertAlmostEqual(verdict["value"], reference["value"], delta=FORCE * reference["value"])
        self.assertAlmostEqual(verdict["t"], reference["t"], delta=1e-3)
        self.assertTrue(verdict["met"])

    # --- Ribs ---

    def test_twelve_ribs_open_and_latch_as_one_equation_says(self):
        def list_states(sample, wanted):
            for i in range(1, RIBS + 1):
                yield sample["sensors"][f"angle{i}"][0], wanted[0]
            yield sample["bodies"]["hub"]["p"][2], wanted[2]

        report = self.compare("scenario.yaml", "ribs", {"taut": RIBS, "latch": RIBS}, list_states)
        for i in range(1, RIBS + 1):
            self.compare_shock(report, f"hinge{i}", REFERENCE["ribs"]["shock"])

    # The latches bear no load where springs and cables balance.
    def test_the_open_antenna_rests_in_its_shape(self):
        report = self.fly("scenario.yaml", [12], "--until", "12")
        self.assertTrue(all(verdict["met"] for verdict in report["verdict"]))
        for i in range(1, RIBS + 1):
            self.assertLess(abs(get_verdicts(report)[f"shape{i}"]["value"]), 1e-6)
            self.assertLess(abs(report["samples"][0]["elements"][f"latch{i}"]["moment"]), 1e-3)

    # The antenna is its mirror image across the plane of rib 1 and rib 7.
    def test_a_weak_spring_comes_late_and_the_rest_is_symmetric_about_it(self):
        report = self.fly("weak-spring.yaml", [3], "--until", "3", code=1)
        latches = get_times(report, "latch")
        self.assertEqual(max(latches, key=latches.get), "rib1")
        for i in range(2, 7):
            self.assertAlmostEqual(latches[f"rib{i}"], latches[f"rib{14 - i}"], delta=1e-9)
        self.assertGreater(latches["rib1"] - get_times(report, "latch")["rib7"], 0.1)
        self.assertFalse(get_verdicts(report)["together"]["met"])

    def test_cables_pull_a_weak_rib_along(self):
        last = []
        for cables in ([], ["--set", "constants.cable=1e-6 N/m", "--set", "constants.cable_damping=0"]):
            latches = get_times(self.fly("weak-spring.yaml", [3], "--until", "3", *cables, code=1), "latch")
            last.append(latches["rib1"] - min(latches.values()))
        self.assertLess(2 * last[0], last[1])

    def test_momenta_of_a_lopsided_opening_stay_zero(self):
        report = self.fly("weak-spring.yaml", [0.5, 1.6, 1.8, 1.9, 4], code=1)
        for sample in report["samples"]:
            for vector in calc_momenta(sample["bodies"], list_rib_bodies()):
                self.assertLess(math.hypot(*vector), CONSERVED)
        self.assertLess(abs(report["energy"]["largest_unexplained"]), 1e-5 * report["energy"]["scale"])

    # --- The ring ---

    def ring_states(self, sample, wanted):
        spacecraft = sample["bodies"]["spacecraft"]
        yield sample["sensors"]["travel"][0], wanted[0]
        yield 2 * math.atan2(spacecraft["q"][2], spacecraft["q"][0]), wanted[2]
        place = [1.5 + 1.6 * math.sin(math.radians(8)), 0, -0.85]
        for found, start, change in zip(spacecraft["p"], place, (wanted[3], 0, wanted[4])):
            yield found - start, change

    def test_a_ring_of_scissors_opens_and_locks_as_one_equation_says(self):
        report = self.compare("ring.yaml", "ring", {"lock": CELLS}, self.ring_states)
        lost = sum(audit["energy_jump"] for audit in report["audit"])
        self.assertAlmostEqual(lost, -REFERENCE["ring"]["energy at the lock"], delta=1e-9)
        self.assertTrue(all(verdict["met"] for verdict in report["verdict"]))

    def test_elastic_locks_ring_as_one_equation_says(self):
        report = self.compare("ring-elastic.yaml", "ring-elastic", {"lock": CELLS}, self.ring_states)
        self.compare_shock(report, "shock", REFERENCE["ring-elastic"]["shock"])

    def test_the_ring_keeps_its_momenta_across_the_locks(self):
        report = self.fly("ring.yaml", [1, 2.2, 2.3, 4])
        for sample in report["samples"]:
            for vector in calc_momenta(sample["bodies"], list_ring_bodies()):
                self.assertLess(math.hypot(*vector), CONSERVED)
        self.assertEqual(len({event["t"] for event in report["events"] if event["name"] == "lock"}), 1)

    # Six times the spring in one cell has the effect of a spring in each: loops transmit it.
    def test_one_spring_opens_the_ring_like_six(self):
        one = [text for name, value in (("effort", 18), ("stiffness", 6), ("damping", 10.8)) for text in ("--set", f"elements.drive3.{name}={value}")]
        one += [text for i in (1, 2, 4, 5, 6) for text in ("--set", f"elements.drive{i}.enabled=false")]
        six, alone = (self.fly("ring.yaml", [1, 2], "--until", "3", *options) for options in ((), one))
        self.assertAlmostEqual(get_times(six, "lock")["post1"], get_times(alone, "lock")["post1"], delta=1e-9)
        for a, b in zip(six["samples"], alone["samples"]):
            for name in list_ring_bodies():
                for x, y in zip(a["bodies"][name]["p"], b["bodies"][name]["p"]):
                    self.assertAlmostEqual(x, y, delta=1e-9)
        loads = [max(abs(sample["reactions"]["a-upper3"]["lambda"][0]) for sample in report["samples"]) for report in (six, alone)]
        self.assertGreater(loads[1], 2 * loads[0])  # but the bars bear the load

    # 25 bodies have 150 degrees of freedom; the whole moves in six, and the shape in one until it is locked.
    def test_redundant_rows_are_counted_and_reported(self):
        hinges, slides, boom = 5 * CELLS * 5, CELLS * 5, 6
        moving = hinges + slides + boom - (6 * 25 - 7)
        locked = hinges + slides + CELLS + boom - (6 * 25 - 6)
        self.assertEqual((moving, locked), (43, 48))
        report = self.fly("ring.yaml", [3], "--until", "3")
        self.assertEqual([printed["redundant"] for printed in report["redundant"]], [moving, moving, locked])  # held by one lock, free, locked by six
        printed = self.run_ok(UNLATCH, "check", ANTENNA / "ring.yaml").stdout
        self.assertRegex(printed, re.escape(f"{moving} of {hinges + slides + 1} rows of slide1"))
        self.assertEqual(self.fly("scenario.yaml", [3], "--until", "3")["redundant"], [])  # a tree

    def test_recordings_replay(self):
        for name in ("weak-spring", "ring"):
            log = self.folder / f"{name}.log"
            self.run_ok(UNLATCH, "run", ANTENNA / f"{name}.yaml", "--until", "2.5", "--log", log, code=None)
            self.assertIn("every bit agrees", self.run_ok(UNLATCH, "replay", log, code=None).stdout)


if __name__ == "__main__":
    main()
