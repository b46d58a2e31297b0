#!/usr/bin/env python3
"""Verdicts on requirements as users see them: text, JSON, exit codes, JUnit XML read by junitparser. Run by ctest:

    verdict_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import json
import re

from junitparser import Error, Failure, JUnitXml
from processes import UNLATCH, ProcessTest, main

# Scenario of two balls that pass each other: 0.25 m apart at 0.6172839 s.
SCENARIO = """unlatch: 1
name: pass
step: {dt: 1 ms, until: 1}
bodies:
  still: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.25}}]}
  moving: {mass: 1, inertia: [1, 1, 1], position: [-1.2345678, 1, 0], velocity: [2, 0, 0], shape: [{sphere: {radius: 0.5}}]}
events:
  - {name: late, when: {time: 0.4}}
  - {name: never, when: {time: 9}}
requirements:
  - {id: near, text: 'They keep "clear" & <safe>', clearance: [still, moving], at_least: 0.2}
"""
MISSED = """  - {id: nearer, clearance: [still, moving], at_least: 0.3}
  - {id: waits, time: {event: never}, at_most: 10}
"""


class VerdictTest(ProcessTest):
    def write(self, text):
        path = self.folder / "pass.yaml"
        path.write_text(text)
        return path

    def test_requirements_that_are_met_end_in_zero(self):
        report = self.run_json(UNLATCH, "run", self.write(SCENARIO))
        verdict = report["verdict"]
        self.assertEqual([entry["id"] for entry in verdict], ["near"])
        self.assertTrue(verdict[0]["met"])
        self.assertAlmostEqual(verdict[0]["value"], 0.25, delta=1e-9)
        self.assertAlmostEqual(verdict[0]["margin"], 0.05, delta=1e-9)
        self.assertAlmostEqual(verdict[0]["t"], 0.6172839, delta=1e-6)
        self.assertEqual((verdict[0]["limit"], verdict[0]["unit"]), (0.2, "m"))

    def test_one_that_is_not_met_ends_in_one_in_run_hil_and_replay(self):
        path, log = self.write(SCENARIO + MISSED), self.folder / "run.log"
        ran = self.run_json(UNLATCH, "run", path, "--log", log, code=1)
        self.assertEqual(ran["status"], "ok")
        self.assertEqual([entry["met"] for entry in ran["verdict"]], [True, False, False])
        self.assertEqual(ran["verdict"][2]["why"], "event 'never' did not occur")
        replayed = self.run_json(UNLATCH, "replay", log, code=1)
        in_loop = self.run_json(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "fast", code=1)
        self.assertEqual(replayed["verdict"], ran["verdict"])
        self.assertEqual(in_loop["verdict"], ran["verdict"])
        text = self.run_ok(UNLATCH, "run", path, code=1).stdout
        self.assertIn("2 of 3 requirements are not met", text)

    def test_overrides_reach_a_requirement_by_its_id(self):
        path = self.write(SCENARIO + MISSED)
        report = self.run_json(UNLATCH, "run", path, "--set", "requirements.near.at_least=1", code=1)
        self.assertEqual(report["verdict"][0]["limit"], 1)

    def test_junit_is_read_by_another_parser(self):
        path, out, log = self.write(SCENARIO + MISSED), self.folder / "out.xml", self.folder / "run.log"
        self.run_ok(UNLATCH, "run", path, "--junit", out, "--log", log, code=1)
        suites = list(JUnitXml.fromfile(str(out)))
        self.assertEqual(len(suites), 1)
        self.assertEqual((suites[0].name, suites[0].tests, suites[0].failures, suites[0].errors), ("pass", 4, 2, 0))
        cases = {case.name: case for case in suites[0]}
        self.assertEqual(list(cases), ["run", "near", "nearer", "waits"])
        self.assertEqual(cases["near"].result, [])
        self.assertIn('They keep "clear" & <safe>', cases["near"].system_out)
        self.assertIsInstance(cases["nearer"].result[0], Failure)
        self.assertIn("margin -0.05 m", cases["nearer"].result[0].message)
        self.assertEqual(cases["waits"].result[0].type, "not evaluated")
        again = self.folder / "again.xml"
        self.run_ok(UNLATCH, "replay", log, "--junit", again, code=1)
        self.assertEqual(out.read_text(), again.read_text())
        self.run_ok(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "fast", "--junit", again, code=1)
        self.assertEqual(out.read_text(), again.read_text())

    def test_a_fault_is_an_error_in_junit(self):
        path, out = self.write(SCENARIO.replace("velocity: [2, 0, 0]", "velocity: [2, 0, 0], rate: [1e200, 1e200, 0]")), self.folder / "out.xml"
        self.run_ok(UNLATCH, "run", path, "--junit", out, code=1)
        case = next(iter(next(iter(JUnitXml.fromfile(str(out))))))
        self.assertIsInstance(case.result[0], Error)

    def test_check_tells_which_cannot_be_evaluated(self):
        path = self.write(SCENARIO + MISSED)
        checked = self.run_json(UNLATCH, "check", path)
        problems = {entry["id"]: [problem["what"] for problem in entry["problems"]] for entry in checked["requirements"]}
        self.assertEqual(problems, {"near": [], "nearer": [],
                                    "waits": ["event 'never' cannot come before 9 s; the run ends at 1 s"]})
        self.assertIn("cannot be evaluated", self.run_ok(UNLATCH, "check", path).stdout)

    def test_check_tells_which_hold_in_every_run(self):
        more = ("requirements:\n"
                "  - {id: size, rate: {body: BODY}, at_least: 0}\n"
                "  - {id: axes, axes: {body: BODY, axis: [1, 0, 0], other: [0, 1, 0]}, range: [0, 180 deg]}\n"
                "  - {id: sound, rate: {body: BODY}, at_most: 1 deg/s}\n"
                "  - {id: part, velocity: {body: BODY, along: [1, 0, 0]}, at_least: 0}\n")
        text = SCENARIO[:SCENARIO.index("requirements:")]
        body = re.search(r"^bodies:\n  (\w+):", text, re.M).group(1)
        checked = self.run_json(UNLATCH, "check", self.write(text + more.replace("BODY", body)))
        self.assertEqual([w["where"] for w in checked["warnings"] if w["name"] == "trivial"],
                         ["requirement 'size'", "requirement 'axes'"])

    def test_scenarios_without_requirements_have_none(self):
        text = SCENARIO[:SCENARIO.index("requirements:")]
        path, out = self.write(text), self.folder / "out.xml"
        report = self.run_json(UNLATCH, "run", path, "--junit", out)
        self.assertEqual(report["verdict"], [])
        self.assertEqual(json.loads(json.dumps(report["separations"])), [])
        self.assertEqual(next(iter(JUnitXml.fromfile(str(out)))).tests, 1)


if __name__ == "__main__":
    main()
