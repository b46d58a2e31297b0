#!/usr/bin/env python3
"""A pantograph boom of twenty units deploys and locks: against tests/references/mast_reference.py (four coordinates, DOP853 at 1e-12),
conservation laws, replay. Run by ctest:

    mast_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

MAST = SCENARIOS / "mast/scenario.yaml"
REFERENCE = json.loads((SOURCE / "tests/data/mast.json").read_text())
EVENT_TIME = 1e-10  # s
STATE = 1e-12       # m, rad
UNITS, HALF = 20, 0.5


def get_turn(body):
    return 2 * math.atan2(body["q"][3], body["q"][0])


class MastTest(ProcessTest):
    def test_it_deploys_as_an_independent_integration_of_four_coordinates(self):
        times = [sample["t"] for sample in REFERENCE["samples"]]
        report = self.run_json(UNLATCH, "run", MAST, "--sample", ",".join(map(str, times)))
        lock = next(event["t"] for event in report["events"] if event["name"] == "lock")
        self.assertAlmostEqual(lock, REFERENCE["lock"], delta=EVENT_TIME)
        for sample, wanted in zip(report["samples"], REFERENCE["samples"], strict=True):
            bus, first = sample["bodies"]["bus"], sample["bodies"]["a1"]
            for found, value in zip((*bus["p"][:2], get_turn(bus), get_turn(first) - get_turn(bus)), (*wanted["bus"], wanted["angle"]), strict=True):
                self.assertAlmostEqual(found, value, delta=STATE)
            # All bars have one angle to the boom's axis, and the loops stay closed.
            for i in range(1, UNITS + 1):
                for name, sign in ((f"a{i}", 1), (f"b{i}", -1)):
                    self.assertAlmostEqual(get_turn(sample["bodies"][name]) - get_turn(bus), sign * wanted["angle"], delta=1e-11)
        self.assertEqual(report["status"], "ok")
        self.assertTrue(all(entry["met"] for entry in report["verdict"]), report["verdict"])
        self.assertLess(abs(report["energy"]["unexplained"]), 1e-6)

    def test_each_loop_has_three_redundant_rows(self):
        report = self.run_json(UNLATCH, "run", MAST, "--until", "0.01", code=None)
        self.assertEqual([(entry["redundant"], entry["rows"]) for entry in report["redundant"]], [(60, 305)])
        self.assertIn("60 of 305 rows", self.run_ok(UNLATCH, "run", MAST, "--until", "0.01", code=1).stdout)

    def test_a_recording_replays_to_the_bit(self):
        log = self.folder / "mast.log"
        self.run_ok(UNLATCH, "run", MAST, "--until", "7.4", "--log", log)
        self.assertIn("every bit agrees", self.run_ok(UNLATCH, "replay", log).stdout)


if __name__ == "__main__":
    main()
