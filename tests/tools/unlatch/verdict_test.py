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
# Blow of a ball on a wall with sqrt(k/m)·h 0.45 at one sub-step: not accurate, but the audit of energy explains the
# motion, which would otherwise make every body unresolved. The other body touches nothing.
BLOW = """unlatch: 1
name: blow
step: {dt: 1 ms, until: 0.2, contact_substeps: SUBSTEPS}
bodies:
  wall: {mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: [{name: face, box: {size: [2, 10, 10]}}]}
  ball: {mass: 2, inertia: [1, 1, 1], position: [1.8, 0, 0], velocity: [-3, 0, 0], shape: [{sphere: {radius: 0.5}}]}
  away: {mass: 1, inertia: [1, 1, 1], position: [0, 50, 0], velocity: [1, 0, 0]}
contacts:
  blow: {between: [wall.face, ball], stiffness: 0.4 MN/m}
requirements:
  - {id: speed, velocity: {body: ball}, at_most: 100}
  - {id: before, velocity: {body: ball}, to: early, at_most: 100}
  - {id: other, velocity: {body: away}, at_most: 100}
events: [{name: early, when: {time: 0.05}}]
"""
# A box between two holders, the left of which lets go first, in two steps; a lid that leaves the right one late.
LEAVERS = """unlatch: 1
name: leavers
step: {dt: 1 ms, until: 1}
bodies:
  left: {mass: 9, inertia: [9, 9, 9], position: [-1, 0, 0]}
  right: {mass: 9, inertia: [9, 9, 9], position: [1, 0, 0]}
  box: {mass: 1, inertia: [1, 1, 1]}
  lid: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}
joints:
  low: {between: [left, box], point: [1, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
  high: {between: [left, box], point: [1, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
  hold: {between: [right, box], point: [-1, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
  hook: {between: [right, lid], point: [1, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
events:
  - {name: first, when: {time: 0.1}, then: [{set_mode: {joint: low, mode: free}}]}
  - {name: second, when: {time: 0.3}, then: [{set_mode: {joint: high, mode: free}}]}
  - {name: third, when: {time: 0.6}, then: [{set_mode: {joint: hold, mode: free}}]}
  - {name: fourth, when: {time: 0.9}, then: [{set_mode: {joint: hook, mode: free}}]}
"""
# 4 N s between two ticks: the lid has 1 m/s after them.
PULSE = """unlatch: 1
name: pyro
step: {dt: 5 ms, until: 2 s}
bodies:
  lid: {mass: 4 kg, inertia: [1, 1, 1]}
elements:
  pyro: {type: force, body: lid, frame: world, direction: [1, 0, 0], profile: {table: {times: [0, 1.0011, 1.0016, 1.0021, 2], values: [0, 0, 8 kN, 0, 0]}}}
requirements:
  - {id: slow, velocity: {body: lid}, at_most: 0.1 m/s}
"""
# A pusher without a guide whose two points coincide.
COINCIDENT = """unlatch: 1
name: coincide
step: {dt: 1 ms, until: 1 s}
bodies:
  bus: {mass: 800 kg, inertia: [400, 500, 600]}
  sat: {mass: 100 kg, inertia: [10, 12, 14], position: [1, 0, 0]}
joints:
  clamp: {between: [bus, sat], point: [0.5, 0, 0], follower_point: [-0.5, 0, 0], modes: {held: {kind: weld}, free: {kind: free}}, mode: held}
elements:
  s1: {type: pusher, between: [bus, sat], point: [0.5, 0, 0], follower_point: [-0.5, 0, 0], stroke: 4 cm, preload: 900 N, stiffness: 8 kN/m}
events: [{name: go, when: {time: 0.5 s}, then: [{set_mode: {joint: clamp, mode: free}}]}]
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
        self.assertGreater(cases["run"].time, 0)  # wall time
        self.assertEqual(suites[0].time, cases["run"].time)
        again = self.folder / "again.xml"
        timeless = lambda file: re.sub(r'time="[0-9.]+"', "", file.read_text())
        self.run_ok(UNLATCH, "replay", log, "--junit", again, code=1)
        self.assertEqual(timeless(out), timeless(again))
        self.run_ok(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "fast", "--junit", again, code=1)
        self.assertEqual(timeless(out), timeless(again))

    def test_a_fault_is_an_error_in_junit(self):
        path, out = self.write(SCENARIO.replace("velocity: [2, 0, 0]", "velocity: [2, 0, 0], rate: [1e200, 1e200, 0]")), self.folder / "out.xml"
        self.run_ok(UNLATCH, "run", path, "--junit", out, code=1)
        case = next(iter(next(iter(JUnitXml.fromfile(str(out))))))
        self.assertIsInstance(case.result[0], Error)

    def test_what_depends_on_an_unresolved_contact_is_neither_met_nor_missed(self):
        path, out = self.write(BLOW.replace("SUBSTEPS", "1")), self.folder / "out.xml"
        report = self.run_json(UNLATCH, "run", path, "--junit", out, code=1)
        self.assertEqual(report["status"], "unresolved")
        self.assertEqual([(entry["id"], entry["met"], entry["resolved"]) for entry in report["verdict"]],
                         [("speed", False, False), ("before", True, True), ("other", True, True)])
        self.assertIn("contact blow", report["verdict"][0]["unresolved"])
        cases = {case.name: case for case in next(iter(JUnitXml.fromfile(str(out))))}
        self.assertIsInstance(cases["speed"].result[0], Error)
        self.assertEqual(cases["other"].result, [])
        text = self.run_ok(UNLATCH, "run", path, code=1).stdout
        self.assertIn("1 of 3 requirements is unresolved: neither met nor missed", text)
        in_loop = self.run_json(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "fast", code=1)
        self.assertEqual((in_loop["status"], in_loop["verdict"]), ("unresolved", report["verdict"]))

    def test_the_step_that_a_notice_proposes_suffices(self):
        path = self.write(BLOW.replace("SUBSTEPS", "1"))
        report = self.run_json(UNLATCH, "run", path, code=1)
        text = next(notice["text"] for notice in report["notices"] if notice["name"] == "accuracy.contact")
        step = float(re.search(r"a step of (\S+) s would do", text).group(1))
        nanoseconds = next(n for n in range(int(step * 1e9), 0, -1) if 200_000_000 % n == 0)
        self.run_ok(UNLATCH, "run", path, "--dt", str(nanoseconds * 1e-9))

    def test_a_pulse_between_two_ticks_is_unresolved(self):
        report = self.run_json(UNLATCH, "run", self.write(PULSE), code=1)
        self.assertEqual((report["status"], report["verdict"][0]["met"]), ("unresolved", False))
        self.assertIn("profile pyro", report["verdict"][0]["unresolved"])
        resolved = self.run_json(UNLATCH, "run", self.write(PULSE.replace("dt: 5 ms", "dt: 0.02 ms").replace("at_most: 0.1", "at_most: 1.1")))
        self.assertAlmostEqual(resolved["verdict"][0]["value"], 1, delta=1e-3)

    def test_a_pusher_without_a_direction_is_unresolved(self):
        report = self.run_json(UNLATCH, "run", self.write(COINCIDENT), code=1)
        self.assertEqual(report["status"], "unresolved")
        self.assertEqual([n["subject"] for n in report["notices"] if n["name"] == "accuracy.direction"], ["s1"])

    def test_unresolved_samples_of_a_campaign_are_counted_and_never_met(self):
        self.write(BLOW.replace("SUBSTEPS", "1"))
        campaign = self.folder / "blow.campaign.yaml"
        campaign.write_text("unlatch_campaign: 1\nname: blow\nscenario: pass.yaml\nsamples: 8\nsampling: random\n"
                            "parameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: -4, max: 4}}\n")
        out = self.folder / "out"
        text = self.run_ok(UNLATCH, "campaign", campaign, "--out", out, code=1).stdout
        summary = json.loads((out / "summary.json").read_text())
        unresolved = summary["unresolved"]
        self.assertEqual(summary["statuses"]["unresolved"], len(unresolved))
        self.assertTrue(0 < len(unresolved) < 8, unresolved)
        self.assertEqual(summary["requirements"][0]["unresolved"], len(unresolved))
        self.assertEqual(summary["any_requirement"]["failed"], 0)
        self.assertGreater(summary["any_requirement"]["probability"][1], len(unresolved) / 8)
        self.assertIn("unresolved: ", text)

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

    def test_rounding_is_printed_as_nothing(self):
        path = self.folder / "weld.yaml"
        path.write_text("""unlatch: 1
name: weld
step: {dt: 1 ms, until: 0.5}
gravity: {uniform: [0, 0, -9.81]}
bodies:
  a: {mass: 900, inertia: [90, 80, 70], attitude: {rotate: [[z, 33 deg]]}, position: [0.3, 0, 0]}
joints:
  hold: {between: [ground, a], point: [0, 0, 0], follower_point: [-0.3*cos(33 deg), 0.3*sin(33 deg), 0], modes: {held: {kind: weld}, open: {rows: []}}, mode: held}
events:
  - {name: open, when: {time: 0.2}, then: [{set_mode: {joint: hold, mode: open}}]}
""")
        said = self.run_ok(UNLATCH, "run", path).stdout
        self.assertNotIn("-0.0000", said)
        row = re.search(r"^  hold +(.*?)  open$", said, re.M)[1].split()
        for cell in row:
            self.assertTrue(cell == "0" or abs(float(cell)) > 1e-6, row)
        self.assertIn("8829", row)

    def test_a_body_is_late_only_beside_those_that_leave_the_same_one(self):
        path = self.folder / "leavers.yaml"
        path.write_text(LEAVERS)
        said = self.run_ok(UNLATCH, "run", path).stdout
        late = re.findall(r"(\w+) stayed on (\w+) ([\d.]+) s longer than (\w+)", said)
        self.assertEqual(late, [("lid", "right", "0.300", "box")])


if __name__ == "__main__":
    main()
