#!/usr/bin/env python3
"""Two stages separate by bolts, pushers and an umbilical: against trajectories that are independent of the kernel, and energy. Run by ctest:

    interstage_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import shutil

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

SCENARIO = SCENARIOS / "interstage/scenario.yaml"
TOGETHER = [word for i in range(1, 9) for word in ("--set", f"events.break:bolt{i}.delay=0")]
# Errors of a step of 0.25 ms. Friction grows within 1 mm/s, a twentieth of the first millisecond's motion: the other errors are
# smaller.
SINGLE = 2e-7  # m: the duct's coordinates are kept in single precision
TIME, SPEED, RATE, PLACE = 5e-7, 1e-7, 1e-7, 2e-7  # s, m/s, rad/s, m


def run(*options):
    return json.loads(call(UNLATCH, "run", *options, "--json", "-").stdout)


def turn(q, v, back=False):
    w, x, y, z = q
    x, y, z = (-x, -y, -z) if back else (x, y, z)
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]]


def read_corners(path):
    return [tuple(map(float, line.split()[1:])) for line in path.read_text().splitlines() if line.startswith("v ")]


def calc_axis(q):
    w, x, y, z = q
    return 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)


class InterstageTest(ProcessTest):
    def test_events_and_motion_are_those_of_an_independent_integration(self):
        reference = json.loads((SOURCE / "tests/data/interstage.json").read_text())
        found = run(SCENARIO, *TOGETHER, "--set", "step.dt=0.00025", "--sample", "3")
        times = {f"{event['name']}:{event['subject']}": event["t"] for event in found["events"]}
        for name, time in reference["events"].items():
            self.assertAlmostEqual(times[name], time, delta=TIME, msg=name)
        for name, body in reference["bodies"].items():
            state = found["samples"][-1]["bodies"][name]
            for what, mine, theirs, allowed in (("p", state["p"], body["p"], PLACE), ("v", state["v"], body["v"], SPEED),
                                                ("w", state["w"], body["w_body"], RATE),
                                                ("axis", calc_axis(state["q"]), body["axis"], RATE)):
                for a, b in zip(mine, theirs):
                    self.assertAlmostEqual(a, b, delta=allowed, msg=f"{name} {what}")

    # Work of six pushers without their friction, over the reduced mass; no other force acts, and the bolts break at once.
    def test_equal_pushers_give_their_work_and_no_rotation(self):
        off = ["--set", "elements.umbilical.enabled=false", "--set", "elements.tail_off.enabled=false"]
        found = run(SCENARIO, *TOGETHER, *off, "--set", "constants.weak=1", "--sample", "3")
        lower, upper = (found["samples"][-1]["bodies"][name] for name in ("lower", "upper"))
        work, reduced = 6 * ((9000 + 5000) / 2 - 150) * 0.08, 4500 * 6000 / 10500
        self.assertAlmostEqual(upper["v"][0] - lower["v"][0], math.sqrt(2 * work / reduced), delta=1e-5)
        self.assertLess(max(map(abs, upper["w"] + lower["w"])), 1e-12)
        self.assertLess(abs(4500 * lower["v"][0] + 6000 * upper["v"][0]), 1e-9)

    def test_with_two_pushers_dead_the_nozzle_strikes_the_skirt(self):
        found = run(SCENARIOS / "interstage/two-dead.yaml")
        names = [f"{event['name']}:{event['subject']}" for event in found["events"]]
        self.assertLess(names.index("part:umbilical"), names.index("touch:strike"))
        verdicts = {verdict["id"]: verdict for verdict in found["verdict"]}
        self.assertLess(verdicts["R1"]["value"], 0)
        self.assertFalse(verdicts["R1"]["met"])

    def test_the_recording_of_a_strike_replays(self):
        log = self.folder / "strike.log"
        call(UNLATCH, "run", SCENARIOS / "interstage/two-dead.yaml", "--log", log)
        printed = call(UNLATCH, "replay", log).stdout
        self.assertIn("every bit agrees", printed)

    # Within the skirt a facet is nearest to the wall at a corner: the gap is the radius minus the farthest corner's distance from
    # the axis.
    def test_the_ducts_gap_to_the_skirt_is_that_of_its_corners(self):
        found = run(SCENARIOS / "interstage/duct.yaml", "--sample", "0,0.7,0.8")
        pair = next(pair for pair in found["clearance"] if pair["pair"] == ["lower.skirt", "upper.duct"])
        self.assertEqual(pair["method"], "mesh (triangles)")
        self.assertEqual({pair["method"] for pair in found["clearance"] if pair["pair"][1] != "upper.duct"}, {"exact"})
        angle = math.radians(30)
        for sample in found["samples"]:
            lower, upper = sample["bodies"]["lower"], sample["bodies"]["upper"]
            farthest = 0
            for x, y, z in read_corners(SCENARIOS / "interstage/duct.obj"):
                own = (x / 1000 - 3.2, (y * math.cos(angle) - z * math.sin(angle)) / 1000, (y * math.sin(angle) + z * math.cos(angle)) / 1000)
                seen = turn(lower["q"], [a + b - c for a, b, c in zip(upper["p"], turn(upper["q"], own), lower["p"])], back=True)
                self.assertTrue(1.6 < seen[0] < 4, "a corner outside the skirt")
                farthest = max(farthest, math.hypot(seen[1], seen[2]))
            self.assertAlmostEqual(sample["clearance"][1], 1.32 - farthest, delta=SINGLE)
        verdict = next(verdict for verdict in found["verdict"] if verdict["id"] == "R6")
        self.assertTrue(verdict["met"])
        self.assertAlmostEqual(verdict["value"], pair["min"], delta=1e-12)

    def test_a_recording_holds_the_duct(self):
        shutil.copytree(SCENARIOS / "interstage", self.folder / "interstage")
        scenario, log = self.folder / "interstage/duct.yaml", self.folder / "duct.log"
        first = json.loads(call(UNLATCH, "run", scenario, "--until", "1", "--log", log, "--json", "-").stdout)
        shutil.rmtree(self.folder / "interstage")
        again = json.loads(call(UNLATCH, "replay", log, "--json", "-").stdout)
        self.assertEqual(again["clearance"], first["clearance"])
        self.assertEqual(again["hash"], first["hash"])
        lines = [json.loads(line) for line in call(UNLATCH, "export", log, "--format", "json", "--out", "-").stdout.splitlines()]
        duct = next(shape for shape in lines[0]["bodies"][1]["shapes"] if shape.get("name") == "duct")
        self.assertEqual((duct["kind"], duct["file"], len(duct["triangles"])), ("mesh", "duct.obj", 416))
        self.assertEqual(lines[0]["clearance_methods"], ["exact", "mesh (triangles)"])

    def test_an_fmu_of_the_duct_is_refused(self):
        printed = call(UNLATCH, "export", SCENARIOS / "interstage/duct.yaml", "--fmu", self.folder / "duct.fmu")
        self.assertEqual(printed.returncode, 2)
        self.assertIn("which needs a library that an FMU does not carry", printed.stderr)


if __name__ == "__main__":
    main()
