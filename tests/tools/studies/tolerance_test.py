#!/usr/bin/env python3
"""Facts about studies with a tolerance: the step that is found keeps it, by closed forms; samples beyond it fly again finer;
each flies again to the bit.

    tolerance_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import json
import math

from processes import UNLATCH, ProcessTest, call, main

TOLERANCE = 1e-6
DT = 0.001  # s
# A ball on a spring: x = v / w sin(w t), with w = sqrt(k / m).
BALL = f"""unlatch: 1
name: ball
step: {{dt: {DT}, until: 1.8}}
bodies:
  ball: {{mass: 2, inertia: [1, 1, 1], velocity: [1, 0, 0]}}
joints:
  slide: {{between: [ground, ball], modes: {{slide: {{kind: prismatic, axis: x}}}}}}
elements:
  spring: {{type: joint_spring, joint: slide, axis: x, stiffness: 200, implicit: false}}
requirements:
  - {{id: place, text: it is far away, displacement: {{joint: slide, axis: x}}, take: final, at_most: 0.1}}
"""
SPREAD = """parameters:
  m: {path: bodies.ball.mass, uniform: {min: 1.8, max: 2.2}}
  k: {path: elements.spring.stiffness, uniform: {min: 150, max: 250}}
"""


def place(row, time=1.8):
    k, m = (float(next(row[key] for key in row if key.split(" ")[0] == name)) for name in ("k", "m"))
    w = math.sqrt(k / m)
    return math.sin(time * w) / w


class ToleranceTest(ProcessTest):
    def write(self, rest, name="c.yaml"):
        (self.folder / "ball.yaml").write_text(BALL)
        path = self.folder / name
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\n" + rest)
        return path

    def run_campaign(self, path, out, *options, code=(0, 1)):
        done = call(UNLATCH, "campaign", path, "--out", self.folder / out, "--json", "-", *options)
        self.assertIn(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def read_table(self, out):
        with open(self.folder / out / "samples.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def check_sample(self, path, row, *options):
        number = row["sample"]
        alone = json.loads(call(UNLATCH, "run", path, "--sample", number, "--json", "-", *options).stdout)
        self.assertEqual(alone["hash"], row["hash"], f"sample {number}, {options}")

    def calc_error(self, row):
        return abs(float(row["place [m]"]) - place(row)) / max(abs(place(row)), 0.1)

    def test_every_sample_keeps_the_tolerance_at_a_larger_step_than_the_scenarios(self):
        path = self.write(f"samples: 120\nsampling: latin-hypercube\ntolerance: {TOLERANCE}\n" + SPREAD)
        step = self.run_campaign(path, "out")["step"]
        self.assertGreaterEqual(step["step"], 3 * DT)
        self.assertEqual((step["scenario_step"], step["flights"], step["checked"], step["flown_again"]), (DT, 16, 2, []))
        table = self.read_table("out")
        for row in table:
            self.assertEqual(float(row["step [s]"]), step["step"])
            self.assertEqual(int(row["ticks"]), round(1.8 / step["step"]))
            self.assertLess(self.calc_error(row), TOLERANCE, row["sample"])
            self.assertEqual(row["step.error"] != "", row["sample"] in ("0", "100"))
        self.assertGreater(max(self.calc_error(row) for row in table), 1e-3 * TOLERANCE)  # not finer than needed
        for row in (table[0], table[100]):  # an estimate that bounds the error
            self.assertGreater(float(row["step.error"]), self.calc_error(row))
        # The next larger step that was tried is too large: of some flight.
        worse = [trial for trial in step["trials"] if trial["step"] > step["step"]]
        self.assertTrue(worse)
        self.assertTrue(all(trial["error"] > TOLERANCE / 2 for trial in worse), worse)

    def test_a_sample_flies_again_to_the_bit_with_the_results_and_without_them(self):
        path = self.write(f"samples: 8\ntolerance: {TOLERANCE}\n" + SPREAD)
        self.run_campaign(path, "out")
        for row in self.read_table("out")[:4:3]:
            self.check_sample(path, row)
            self.check_sample(path, row, "--results", self.folder / "out")

    def test_jobs_parts_and_interruptions_give_the_same_table(self):
        path = self.write(f"samples: 110\ntolerance: {TOLERANCE}\n" + SPREAD)
        whole = self.run_campaign(path, "whole", "--jobs", "3")
        self.run_campaign(path, "early", "--samples", "0:60", "--jobs", "1")
        self.run_campaign(path, "late", "--samples", "60:110", "--jobs", "2")
        merged = json.loads(call(UNLATCH, "campaign", "merge", self.folder / "late", self.folder / "early", "--out",
                                 self.folder / "merged", "--json", "-").stdout)
        resumed = self.run_campaign(path, "early", "--resume")
        self.assertEqual({whole["hash"]}, {merged["hash"], resumed["hash"]})
        tables = {(self.folder / name / "samples.csv").read_bytes() for name in ("whole", "merged", "early")}
        self.assertEqual(len(tables), 1)

    def test_a_sample_beyond_the_tolerance_flies_again_finer_until_it_keeps_it(self):
        rows = ["m,k"] + [f"2,{20000 if i == 100 else 200 + i}" for i in range(104)]  # no flight of the search is row 100
        (self.folder / "t.csv").write_text("\n".join(rows) + "\n")
        path = self.write(f"sampling: csv\ntable: t.csv\ntolerance: {TOLERANCE}\n" + SPREAD)
        step = self.run_campaign(path, "out")["step"]
        self.assertEqual(step["flown_again"], [100])
        table = self.read_table("out")
        for row in table:
            self.assertLess(self.calc_error(row), TOLERANCE, row["sample"])
        finer = table[100]
        self.assertLess(float(finer["step [s]"]), step["step"])
        self.assertLess(float(finer["step.error"]), TOLERANCE)
        self.assertIn("flown again finer", finer["message"])
        self.check_sample(path, finer)
        self.check_sample(path, finer, "--results", self.folder / "out")

    def test_the_points_of_curves_stay_on_ticks(self):
        path = self.write("samples: 4\ntolerance: 1e-3\ncurves: [{of: ball.x, every: 3 ms}]\n" + SPREAD)
        step = self.run_campaign(path, "out")["step"]
        self.assertAlmostEqual(step["step"], 0.003, delta=1e-12)
        row = self.read_table("out")[2]
        self.assertAlmostEqual(float(row["curve.ball.x@0.9 [m]"]), place(row, 0.9), delta=1e-4)

    def test_a_tolerance_that_no_step_meets_flies_nothing(self):
        path = self.write("samples: 4\ntolerance: 1e-15\n" + SPREAD)
        done = call(UNLATCH, "campaign", path, "--out", self.folder / "out")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"tolerance 1e-15: down to a step of \S+ s none meets it: there place of (corner|sample) \d+ is off by")
        self.assertFalse((self.folder / "out").exists())

    def test_mistakes_have_their_places(self):
        path = self.write("samples: 4\ntolerance: 2\n" + SPREAD)
        self.assertRegex(call(UNLATCH, "check", path).stderr, r"c.yaml:5:12: .*0\.1")
        path = self.write("samples: 4\ntolerance: 1e-6\nparameters:\n  h: {path: step.dt, discrete: {values: [1 ms, 2 ms]}}\n")
        self.assertRegex(call(UNLATCH, "check", path).stderr, "the step varies, and the campaign has a tolerance")

    def write_problem(self, rest=""):
        (self.folder / "ball.yaml").write_text(BALL.replace("at_most: 0.1", "at_most: 0.03"))
        path = self.folder / "p.yaml"
        path.write_text("unlatch_optimize: 1\nname: p\nscenario: ball.yaml\nvariables:\n"
                        "  k: {path: elements.spring.stiffness, between: [150 N/m, 250 N/m], start: 240 N/m}\n"
                        "objectives: [{minimise: k}]\nbudget: {runs: 60}\n" + rest)
        return path

    def test_a_search_flies_at_a_larger_step_and_its_result_keeps_the_tolerance(self):
        path = self.write_problem(f"tolerance: {TOLERANCE}\n")
        done = call(UNLATCH, "optimize", path, "--out", self.folder / "out", "--json", "-")
        result = json.loads(done.stdout)
        self.assertIn(result["status"], ("optimal", "budget"), done.stderr)
        self.assertGreater(result["step"]["step"], DT)
        self.assertLess(result["verification"]["step_error"], TOLERANCE)
        self.assertTrue(result["verification"]["same_bits"])
        w = math.sqrt(result["variables"]["k"]["value"] / 2)
        found = next(c["value"] for c in result["constraints"] if c["id"] == "place")
        self.assertAlmostEqual(found, math.sin(1.8 * w) / w, delta=TOLERANCE * 0.05)
        resumed = json.loads(call(UNLATCH, "optimize", path, "--out", self.folder / "out", "--resume", "--json", "-").stdout)
        self.assertEqual(resumed["verification"]["hash"], result["verification"]["hash"])

    def test_a_search_whose_tolerance_no_step_meets_flies_nothing(self):
        done = call(UNLATCH, "optimize", self.write_problem("tolerance: 1e-15\n"), "--out", self.folder / "out")
        self.assertEqual(done.returncode, 1)
        self.assertIn("none meets it", done.stderr)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    main()
