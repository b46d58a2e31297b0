#!/usr/bin/env python3
"""Verdicts on requirements as users see them: text, JSON, exit codes, JUnit XML read by junitparser. Run by ctest:

    verdict_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import json
import re

from browser import Browser
from junitparser import Error, Failure, JUnitXml
from processes import UNLATCH, ProcessTest, call, main

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
# 4 N s between two ticks, by more points than a step is split at: the lid has 1 m/s after them.
PULSE = """unlatch: 1
name: pyro
step: {dt: 5 ms, until: 2 s}
bodies:
  lid: {mass: 4 kg, inertia: [1, 1, 1]}
elements:
  pyro: {type: force, body: lid, frame: world, direction: [1, 0, 0], profile: {table: {times: [0, 1.0011, 1.0012, 1.0013, 1.0014, 1.0015, 1.0016, 1.0017, 1.0018, 1.0019, 1.002, 1.0021, 2], values: [0, 0, 1.6 kN, 3.2 kN, 4.8 kN, 6.4 kN, 8 kN, 6.4 kN, 4.8 kN, 3.2 kN, 1.6 kN, 0, 0]}}}
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
        # A requirement has no time of its own: all of the suite's is that of the run which all of them judge.
        self.assertEqual([case.time for case in suites[0] if case.name != "run"], [None] * 3)
        again = self.folder / "again.xml"
        timeless = lambda file: re.sub(r'time="[0-9.]+"', "", file.read_text())
        self.run_ok(UNLATCH, "replay", log, "--junit", again, code=1)
        self.assertEqual(timeless(out), timeless(again))
        self.run_ok(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "fast", "--junit", again, code=1)
        self.assertEqual(timeless(out), timeless(again))

    # Half a second of simulated time takes half a second on the wall at the pace of real time, and a replay does not.
    def test_the_time_in_junit_is_that_of_the_wall(self):
        path, out, log = self.write(SCENARIO + MISSED), self.folder / "out.xml", self.folder / "run.log"
        self.run_ok(UNLATCH, "hil", path, "--transport", "inproc", "--pace", "realtime", "--until", "0.5", "--junit", out, "--log", log, code=None)
        suite = next(iter(JUnitXml.fromfile(str(out))))
        self.assertGreaterEqual(suite.time, 0.5)
        self.assertEqual([case.time for case in suite], [suite.time] + [None] * (suite.tests - 1))
        self.run_ok(UNLATCH, "replay", log, "--junit", out, code=None)
        again = next(iter(JUnitXml.fromfile(str(out))))
        self.assertGreater(again.time, 0)
        self.assertEqual([case.time for case in again], [again.time] + [None] * (again.tests - 1))

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

    def test_page_and_exports_of_an_unresolved_run_are_not_called_ok(self):
        log, lines, page = (self.folder / name for name in ("run.log", "run.json", "run.html"))
        self.run_ok(UNLATCH, "run", self.write(BLOW.replace("SUBSTEPS", "1")), "--log", log, code=1)
        for form in "csv", "json":
            exported = self.run_ok(UNLATCH, "export", log, "--format", form, "--out", lines, code=1).stderr
        self.assertIn("unresolved\n  contact blow", exported)
        end = json.loads(lines.read_text().splitlines()[-1])
        self.assertEqual(end["status"], "unresolved")
        self.assertIn("contact blow", end["message"])
        self.run_ok(UNLATCH, "report", log, "--out", page)
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        self.assertIn("unresolved", browser.evaluate("document.querySelector('.status').textContent"))
        rows = browser.evaluate("[...document.querySelectorAll('#verdict tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")
        self.assertEqual([row[:2] for row in rows], [["speed", "unresolved"], ["before", "met"], ["other", "met"]])
        self.assertIn("1 of 3 unresolved", browser.evaluate("document.querySelector('#verdict small').textContent"))

    # The blow is over at 0.1 s.
    def test_a_run_that_goes_on_from_a_checkpoint_of_an_unresolved_one_is_unresolved(self):
        scenario = self.write(BLOW.replace("SUBSTEPS", "1"))
        early, late, log = (self.folder / name for name in ("early", "late", "resumed.log"))
        self.run_ok(UNLATCH, "run", scenario, "--checkpoint", "0.01", early, "--checkpoint", "0.19", late, code=1)
        report = self.run_json(UNLATCH, "run", scenario, "--resume", late, "--log", log, code=1)
        self.assertEqual(report["status"], "unresolved")
        self.assertIn("accuracy.start", [notice["name"] for notice in report["notices"]])
        self.assertEqual(self.run_json(UNLATCH, "replay", log, code=1)["status"], "unresolved")
        self.assertEqual(self.run_json(UNLATCH, "run", scenario, "--resume", early, "--until", "0.02", code=None)["status"], "ok")

    # The arm swings at 1 rad/s and locks at 0.1 rad; the base is held by a weld, through which the blow passes.
    def test_a_verdict_on_a_reaction_names_the_blow_of_a_lock_whose_impulse_it_leaves_out(self):
        scenario = self.write("""unlatch: 1
name: arm
step: {dt: 1 ms, until: 0.2}
bodies:
  base: {mass: 1, inertia: [1, 1, 1]}
  arm: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [0, 1, 0], rate: [0, 0, 1]}
joints:
  root: {between: [ground, base], modes: {held: {kind: weld}}}
  hinge: {between: [base, arm], follower_point: [-1, 0, 0], modes: {open: {kind: revolute, axis: z}, locked: {kind: weld}}, mode: open}
events: [{name: lock, when: {angle: {joint: hinge, axis: z}, above: 0.1}, then: [{latch: {joint: hinge, mode: locked}}]}]
requirements:
  - {id: root, reaction: {joint: root, row: moment}, at_most: 10 N m}
  - {id: quantity, reaction_force: root, at_most: 10 N}
  - {id: before, reaction: {joint: root, row: force}, to: lock, at_most: 10 N}
  - {id: behind, reaction: {joint: root, row: force}, from: lock, at_most: 10 N}
""")
        report = self.run_json(UNLATCH, "run", scenario)
        blows = {entry["id"]: entry.get("without_blow") for entry in report["verdict"]}
        self.assertEqual((blows["before"], blows["behind"]), (None, None))
        for name in "root", "quantity":
            self.assertAlmostEqual(blows[name], 0.1, delta=1e-6)
        text = self.run_ok(UNLATCH, "run", scenario).stdout
        self.assertEqual(text.count("; without the impulse of the blow at 0.1 s"), 2)

    # The balls are 0.3 m apart for a twentieth of a step; the limit is so far away that the verdict is sure.
    # A table bends at 0.0576 s and 0.1225 s, and the sum has its minimum in the piece of a step after the second bend, or where a
    # step is 0.9 rad of what it reads: few knots tell it, and it is the acceleration, whose own extreme was right there.
    def test_the_extreme_of_an_expression_beside_a_corner_is_that_of_what_it_is_made_of(self):
        frequency, amplitude, phase = 21.706647017657275, 2.8543448406847665, 1.7158573784972122
        text = f"""unlatch: 1
name: bend
step: {{dt: 20 ms, until: 0.2}}
bodies:
  m: {{mass: 1 kg, inertia: [1, 1, 1]}}
elements:
  f: {{type: force, body: m, direction: [1, 0, 0], profile: {{harmonic: [{{amplitude: {amplitude} N, frequency: {frequency}, phase: {phase}}}]}}}}
  g: {{type: force, body: m, direction: [1, 0, 0], profile: {{table: {{times: [57.6 ms, 122.5 ms], values: [2.5 N, 3.788928876398775 N]}}}}}}
quantities:
  fa: {{force: {{element: f}}}}
  fg: {{force: {{element: g}}}}
requirements:
  - {{id: sum, expression: "fa + fg", at_least: 0.936 N}}
  - {{id: same, acceleration: {{body: m, component: x}}, at_least: 0.936 m/s2}}
"""
        # Its least value: the amplitude is reached at 0.138 s, behind the last bend.
        least = 3.788928876398775 - amplitude
        for dt, near in (("20 ms", 1e-5), ("40 ms", 1e-3)):
            found = self.run_json(UNLATCH, "run", self.write(text.replace("20 ms", dt)), code=1)["verdict"]
            for one in found:
                self.assertFalse(one["met"], one)
                self.assertAlmostEqual(one["value"], least, delta=near + one.get("uncertainty", 0), msg=str(one))

    def test_an_extreme_that_is_not_known_to_a_thousandth_says_how_far_it_may_be_off(self):
        path = self.write("""unlatch: 1
name: pass
step: {dt: 10 ms, until: 1}
constants: {v: 20 km/s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [-8120, 0.5, 0], velocity: [v, 0, 0], shape: [{sphere: {radius: 0.1}}]}
requirements:
  - {id: near, quantity: {clearance: {between: [a, b]}}, at_least: -1000}
  - {id: far, quantity: {clearance: {between: [a, b]}}, at_most: 30000}
""")
        near, far = self.run_json(UNLATCH, "run", path)["verdict"]
        self.assertTrue(near["met"])
        self.assertGreater(near["uncertainty"], max(1e-3 * near["value"], abs(near["value"] - 0.3)))
        self.assertNotIn("uncertainty", far)
        junit = self.folder / "out.xml"
        text = self.run_ok(UNLATCH, "run", path, "--junit", junit).stdout
        said = re.search(r"near +met +(\S+ ± \S+) m at", text)[1]
        self.assertIn(said, {case.name: case for case in next(iter(JUnitXml.fromfile(str(junit))))}["near"].system_out)
        self.assertEqual(text.count("±"), 1)
        campaign = self.folder / "pass.campaign.yaml"
        campaign.write_text("unlatch_campaign: 1\nname: pass\nscenario: pass.yaml\nsamples: 4\nsampling: random\n"
                            "parameters:\n  v: {path: constants.v, uniform: {min: 19.9 km/s, max: 20.1 km/s}}\n")
        out = self.folder / "out"
        said = self.run_ok(UNLATCH, "campaign", campaign, "--out", out).stdout
        by_id = {one["id"]: one for one in json.loads((out / "summary.json").read_text())["requirements"]}
        self.assertEqual(by_id["near"]["uncertain"]["samples"], 4)
        self.assertNotIn("uncertain", by_id["far"])
        self.assertIn("note: near: 4 samples known to ± ", said)

    # Small spheres that pass at 10 m/s, 10 cm a step, one to six centimetres from each other.
    def test_smallest_distances_as_quantities_and_in_expressions_are_within_what_they_say(self):
        for shift in range(2):
            bodies = quantities = requirements = ""
            exact = {}
            for i in range(12):
                passes, begins = 0.012 + 0.004 * i, -1.2 - 0.0137 * i - 0.31 * (i % 5) - 0.017 * shift
                sphere = "mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 1 mm}}]"
                bodies += f"  a{i}: {{{sphere}, position: [0, {10 * i}, 0]}}\n"
                bodies += f"  b{i}: {{{sphere}, position: [{begins:.4f}, {10 * i + passes:.4f}, 0], velocity: [10, 0, 0]}}\n"
                quantities += f"  c{i}: {{clearance: {{between: [a{i}, b{i}]}}}}\n"
                requirements += f"  - {{id: own{i}, quantity: c{i}, at_least: 1 mm}}\n  - {{id: twice{i}, expression: 2*c{i}, at_least: 1 mm}}\n"
                exact |= {f"own{i}": passes - 0.002, f"twice{i}": 2 * (passes - 0.002)}
            path = self.write(f"unlatch: 1\nname: passes\nstep: {{dt: 20 ms, until: 400 ms}}\nbodies:\n{bodies}quantities:\n{quantities}requirements:\n{requirements}")
            for one in json.loads(call(UNLATCH, "run", path, "--json", "-").stdout)["verdict"]:
                self.assertLessEqual(abs(one["value"] - exact[one["id"]]), (one.get("uncertainty") or 0) + 1e-3 * exact[one["id"]], (shift, one))
                if one["id"].startswith("own"):  # a quantity: at interpolated poses between the knots
                    self.assertTrue(one["resolved"], one)
                    self.assertAlmostEqual(one["value"], exact[one["id"]], delta=1e-3 * exact[one["id"]])

    # A spring carries what a contact does not resolve to a body that touches nothing.
    def test_what_a_spring_connects_to_an_unresolved_body_is_unresolved_too(self):
        spring = "elements:\n  link: {type: spring, between: [ball, away], stiffness: 1, free_length: 1}\n"
        report = self.run_json(UNLATCH, "run", self.write(BLOW.replace("SUBSTEPS", "1").replace("contacts:", spring + "contacts:")), code=1)
        self.assertEqual([(entry["id"], entry["resolved"]) for entry in report["verdict"]],
                         [("speed", False), ("before", True), ("other", False)])
        self.assertEqual([entry.get("uncertainty", 0) for entry in report["verdict"]], [None, 0, None])  # not known
        switched_off = spring.replace("free_length: 1", "free_length: 1, enabled: false")
        report = self.run_json(UNLATCH, "run", self.write(BLOW.replace("SUBSTEPS", "1").replace("contacts:", switched_off + "contacts:")), code=1)
        self.assertEqual([entry["resolved"] for entry in report["verdict"]], [False, True, True])

    # Two feet of a body strike a floor one after the other, bounce and strike again.
    def test_touches_name_their_shapes_and_have_their_own_peaks_and_impulses(self):
        path = self.write("""unlatch: 1
name: feet
step: {dt: 1 ms, until: 2}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, box: {centre: [0, 0, -0.5], size: [9, 9, 1]}}]}
bodies:
  sat: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5], attitude: {rotate: [[y, 2 deg]]}, shape: [{name: left, sphere: {centre: [-0.3, 0, 0], radius: 0.1}}, {name: right, sphere: {centre: [0.3, 0, 0], radius: 0.1}}]}
contacts:
  feet: {between: [sat, ground.floor], stiffness: 0.2 MN/m, damping: 0.3}
requirements:
  - {id: high, position: {body: sat, along: [0, 0, 1]}, at_least: 0.05}
clearance: [[sat.left, ground]]
""")
        log = self.folder / "feet.log"
        report = self.run_json(UNLATCH, "run", path, "--log", log)
        contact = report["contacts"][0]
        self.assertEqual(len(contact["each"]), contact["touches"])
        self.assertEqual(contact["each"][0]["shapes"][0], "sat.right – ground.floor")  # the lower one: x turned down
        self.assertTrue({"sat.left – ground.floor"} <= {name for touch in contact["each"] for name in touch["shapes"]})
        self.assertAlmostEqual(sum(touch["impulse"] for touch in contact["each"]), contact["impulse"], delta=1e-9 * contact["impulse"])
        self.assertAlmostEqual(sum(touch["duration"] for touch in contact["each"]), contact["duration"], delta=1e-9)
        self.assertEqual(max(touch["peak_force"] for touch in contact["each"]), contact["peak_force"])
        self.assertEqual(max(touch["depth"] for touch in contact["each"]), contact["depth"])
        self.assertEqual(contact["each"][0]["t"], contact["touch"])
        touched = [event for event in report["events"] if event["name"] == "touch"]
        self.assertEqual(touched[0]["shapes"], "sat.right – ground.floor")
        self.assertLess(report["clearance"][0]["min"], 0)  # the depth of the left foot in the floor
        out = self.folder / "feet.json"
        self.run_ok(UNLATCH, "export", log, "--format", "json", "--every", "500", "--out", out)
        lines = [json.loads(line) for line in out.read_text().splitlines()]
        self.assertEqual([line["impulse"] for line in lines if line["kind"] == "touch"], [touch["impulse"] for touch in contact["each"]])
        self.assertEqual([line.get("shapes") for line in lines if line["kind"] == "event" and line["name"] == "touch"],
                         [event["shapes"] for event in touched])
        self.assertEqual([shape["name"] for shape in lines[0]["ground"]], ["floor"])
        # The tables have the touches in a table of their own, with the numbers of the report to the bit.
        self.run_ok(UNLATCH, "export", log, "--format", "csv", "--every", "500", "--out", self.folder / "feet.csv")
        with open(self.folder / "feet.touches.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        columns = {"t [s]": "t", "duration [s]": "duration", "peak_force [N]": "peak_force", "peak_t [s]": "peak_t", "depth [m]": "depth", "impulse [N s]": "impulse"}
        self.assertEqual([{key: float(row[column]) for column, key in columns.items()} for row in rows],
                         [{key: touch[key] for key in columns.values()} for touch in contact["each"]])
        self.assertEqual([row["lift [s]"] for row in rows if row["lift [s]"] == ""], ["" for touch in contact["each"] if touch["lift"] is None])
        self.assertEqual([row["shapes"].split("; ") for row in rows], [touch["shapes"] for touch in contact["each"]])
        self.assertEqual({row["contact"] for row in rows}, {"feet"})
        said = self.run_ok(UNLATCH, "export", log, "--format", "csv", "--every", "500", "--out", "-").stderr
        self.assertIn("second table", said)

    # The same flight beside a dummy body welded to the ground.
    def test_shapes_of_the_ground_are_those_of_a_welded_body(self):
        fixed = """unlatch: 1
name: fixed
step: {dt: 1 ms, until: 1}
gravity: {uniform: [0, 0, -9.81]}
GROUND
bodies:
DUMMY
  ball: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1], velocity: [1, 0, 0], shape: [{name: skin, sphere: {radius: 0.1}}]}
contacts:
  blow: {between: [ball.skin, FLOOR], stiffness: 0.2 MN/m, damping: 0.3, friction: 0.2}
clearance: [[ball, FLOOR]]
"""
        shape = "[{name: floor, box: {centre: [0, 0, -0.5], size: [9, 9, 1]}}]"
        ground = fixed.replace("GROUND", f"ground: {{shape: {shape}}}").replace("DUMMY\n", "").replace("FLOOR", "ground.floor")
        weld = (fixed.replace("GROUND", "joints: {bed: {between: [ground, pad], modes: {held: {kind: weld}}}}").replace("FLOOR", "pad.floor")
                .replace("DUMMY", f"  pad: {{mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: {shape}}}"))
        a, b = (self.run_json(UNLATCH, "run", self.write(text)) for text in (ground, weld))
        for k in range(3):
            self.assertAlmostEqual(a["samples"][-1]["bodies"]["ball"]["p"][k], b["samples"][-1]["bodies"]["ball"]["p"][k], delta=1e-9)
        self.assertAlmostEqual(a["clearance"][0]["min"], b["clearance"][0]["min"], delta=1e-12)
        self.assertAlmostEqual(a["contacts"][0]["impulse"], b["contacts"][0]["impulse"], delta=1e-9)
        mistake = self.run_ok(UNLATCH, "check", self.write(ground.replace("ground.floor]]", "ground.wall]]")), code=2).stderr
        self.assertIn("unknown shape 'wall' of the ground", mistake)

    # A body whose centre of mass is moved flies as one whose points have all been written anew.
    def test_a_shifted_centre_of_mass_is_that_of_points_written_anew(self):
        body = """unlatch: 1
name: shift
step: {dt: 1 ms, until: 1}
bodies:
  stage: {mass: 100, inertia: [10, 10, 10]}
  sat: {mass: 10, inertia: [1, 2, 3], KEY}
joints:
  band: {between: [stage, sat], point: [1, 0, 0], follower_point: FOOT, modes: {held: {kind: weld}, open: {kind: free}}, mode: held}
elements:
  push: {type: pusher, between: [stage, sat], point: [1, 0.1, 0], follower_point: PUSHED, guide: [1, 0, 0], stroke: 50 mm, preload: 100, stiffness: 1000}
events:
  - {name: go, when: {time: 0.1}, then: [{set_mode: {joint: band, mode: open}}]}
requirements:
  - {id: rate, rate: {body: sat}, at_most: 100}
"""
        shifted = (body.replace("KEY", "position: [1.5, 0, 0], centre_of_mass: [0, 5 mm, -3 mm]").replace("FOOT", "[-0.5, 0, 0]")
                   .replace("PUSHED", "[-0.5, 0.1, 0]"))
        written = (body.replace("KEY", "position: [1.5, 0.005, -0.003]").replace("FOOT", "[-0.5, -0.005, 0.003]")
                   .replace("PUSHED", "[-0.5, 0.095, 0.003]"))
        a, b = (self.run_json(UNLATCH, "run", self.write(text)) for text in (shifted, written))
        self.assertAlmostEqual(a["verdict"][0]["value"], b["verdict"][0]["value"], delta=1e-12)
        self.assertGreater(b["verdict"][0]["value"], 0.01)
        for side in ("along", "across"):
            self.assertAlmostEqual(a["separations"][0]["velocity"][side], b["separations"][0]["velocity"][side], delta=1e-12)
        self.assertAlmostEqual(a["separations"][0]["end_of_push"], b["separations"][0]["end_of_push"], delta=1e-12)
        none = self.run_json(UNLATCH, "run", self.write(shifted.replace("centre_of_mass: [0, 5 mm, -3 mm]", "centre_of_mass: [0, 0, 0]")))
        plain = self.run_json(UNLATCH, "run", self.write(shifted.replace(", centre_of_mass: [0, 5 mm, -3 mm]", "")))
        self.assertEqual(none["hash"], plain["hash"])

    def test_a_plain_number_for_a_constant_keeps_the_constants_unit(self):
        path = self.write("""unlatch: 1
name: unit
step: {dt: 1 ms, until: 10 ms}
constants: {side: 5 mm, twice: 2 * side}
bodies: {box: {mass: 1, inertia: [1, 1, 1], position: [side, twice + 1 mm, 0]}}
""")
        for value, x, y in (("0.002", 0.002, 0.005), ("2 mm", 0.002, 0.005), ("0.5 + 0.5", 1, 2.001), ("0", 0, 0.001)):
            place = self.run_json(UNLATCH, "run", path, "--set", f"constants.side={value}")["samples"][-1]["bodies"]["box"]["p"]
            self.assertAlmostEqual(place[0], x, delta=1e-15)
            self.assertAlmostEqual(place[1], y, delta=1e-15)

    def test_a_run_reports_what_check_warns_of(self):
        path = self.write(COINCIDENT)
        warned = self.run_json(UNLATCH, "check", path)["warnings"]
        self.assertTrue(warned)
        self.assertEqual(self.run_json(UNLATCH, "run", path, code=1)["warnings"], warned)
        self.assertIn(warned[0]["text"], self.run_ok(UNLATCH, "run", path, code=1).stdout)

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
        # The resolved ones are no chance choice: nothing is said of all runs but the bounds of the probability.
        self.assertEqual(summary["requirements"][0]["intervals"], {})
        self.assertEqual(summary["requirements"][0]["tolerance"]["without_value"], len(unresolved))
        self.assertRegex(text, rf"none: {len(unresolved)} samples? without a value\n")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", out, "--out", page, "--flights", "0")
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        rows = browser.evaluate("[...document.querySelectorAll('#verdict tr')].map((row) => [...row.children].slice(2, 4).map((cell) => [cell.textContent, cell.firstElementChild?.className]))")
        self.assertEqual([cell[0] for cell in rows[0]], ["failed", "unresolved"])
        self.assertEqual(rows[1], [["0", ""], [str(len(unresolved)), "bad"]])  # no failure, and not good either

    # A speed above 3.5 m/s has the probability 4.65e-4 by the normal distribution. Blows that the step does not resolve are
    # taken for failures by the levels, so that there is a bound and no estimate.
    def test_unresolved_samples_of_subset_sampling_leave_a_bound_and_no_estimate(self):
        self.write(BLOW.replace("SUBSTEPS", "1").replace("at_most: 100}\n  - {id: before", "at_most: 3.5}\n  - {id: before"))
        campaign = self.folder / "rare.campaign.yaml"
        campaign.write_text("unlatch_campaign: 1\nname: rare\nscenario: pass.yaml\nsamples: 200\nsampling: subset\n"
                            "subset: {of: speed, above: 3.5, at_most: 0.5}\n"
                            "parameters:\n  v: {path: 'bodies.ball.velocity[0]', normal: {mean: 0, sigma: 1}}\n")
        out = self.folder / "rare"
        said = self.run_ok(UNLATCH, "campaign", campaign, "--out", out, code=1).stdout
        rare = json.loads((out / "summary.json").read_text())["rare"]
        self.assertGreater(rare["unresolved_samples"], 0)
        self.assertEqual((rare["finished"], rare["met"], rare["probability"], rare["deviation"], rare["interval"][0]), (True, False, None, None, 0))
        self.assertGreater(rare["interval"][1], 4.65e-4)
        self.assertIn("unresolved samples are taken for a failure", said)
        self.assertNotRegex(said, r"probability [\d.]+, 95")

    # The blow of a contact that is open at the start: sqrt(k/m) h is 0.07, but its friction would stop the slip, which also
    # turns the ball (1/m + r^2/I = 0.75 1/kg), in 6 us: 0.5 * 3.16 m/s * sqrt(k m) / (1 mm/s) * 0.75 1/kg = 1.68e5 1/s.
    def test_check_forecasts_the_friction_of_contacts_that_are_open_at_the_start(self):
        rough = BLOW.replace("SUBSTEPS", "1").replace("velocity: [-3, 0, 0]", "velocity: [-3, 1, 0]").replace(
            "stiffness: 0.4 MN/m", "stiffness: 10 kN/m, friction: 0.5, slip_speed: 1 mm/s")
        (warning,) = self.run_json(UNLATCH, "check", self.write(rough))["warnings"]
        self.assertEqual((warning["name"], warning["where"]), ("contact", "contact 'blow'"))
        self.assertRegex(warning["text"], r"rate at which friction stops the slip 168: beyond what is stable.*for a blow of 3.16 m/s")
        self.assertEqual(self.run_json(UNLATCH, "run", self.write(rough), code=1)["status"], "unresolved")
        step = float(re.search(r"a step of (\S+) s would do", warning["text"]).group(1))
        fine = self.run_json(UNLATCH, "run", self.write(rough), "--dt", str(int(step * 0.8e6) * 1e-6))
        self.assertEqual(fine["status"], "ok")
        smooth = self.write(rough.replace(", friction: 0.5, slip_speed: 1 mm/s", ""))
        self.assertEqual(self.run_json(UNLATCH, "check", smooth)["warnings"], [])
        self.assertEqual(self.run_json(UNLATCH, "run", smooth)["status"], "ok")

    # A mass that the start does not have: the warnings of `check` for a problem are also those at the ends of its bounds.
    def test_check_of_a_problem_warns_at_the_corners_of_its_bounds(self):
        self.write(BLOW.replace("SUBSTEPS", "4").replace("mass: 2, inertia: [1, 1, 1], position: [1.8", "mass: 200, inertia: [1, 1, 1], position: [1.8"))
        problem = self.folder / "problem.yaml"
        text = ("unlatch_optimize: 1\nname: p\nscenario: pass.yaml\nvariables:\n  weight: {path: bodies.ball.mass, between: [0.001, 200], start: 200}\n"
                "objectives: [{minimise: speed}]\n")
        problem.write_text(text)
        checked = self.run_json(UNLATCH, "check", problem)
        (warning,) = [one for one in checked["warnings"] if "blow" in one["where"]]
        self.assertEqual((warning["name"], warning["corners"]), ("contact", 4))
        self.assertIn("(at 4 of 8 corners of the bounds)", self.run_ok(UNLATCH, "check", problem).stdout)
        problem.write_text(text.replace("0.001", "150"))
        self.assertEqual(self.run_json(UNLATCH, "check", problem)["warnings"], [])

    # What a body does under a profile whose corner the step misses is unresolved, and with it what springs carry on.
    def test_a_missed_corner_of_a_law_leaves_what_depends_on_it_unresolved(self):
        more = ("bodies:\n  away: {mass: 4 kg, inertia: [1, 1, 1], position: [9, 0, 0], velocity: [0.01, 0, 0]}\n  held: {mass: 4 kg, inertia: [1, 1, 1], position: [-1, 0, 0]}\n")
        text = (PULSE.replace("bodies:\n", more).replace("elements:\n", "elements:\n  link: {type: spring, between: [lid, held], stiffness: 10, free_length: 1}\n") +
                "  - {id: linked, velocity: {body: held}, at_most: 10}\n  - {id: alone, velocity: {body: away}, at_most: 10}\n"
                "  - {id: early, velocity: {body: lid}, to: half, at_most: 10}\nevents: [{name: half, when: {time: 0.5}}]\n")
        report = self.run_json(UNLATCH, "run", self.write(text), code=1)
        self.assertEqual([(v["id"], v["met"], v["resolved"]) for v in report["verdict"]],
                         [("slow", False, False), ("linked", False, False), ("alone", True, True), ("early", True, True)])

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
        table = self.run_ok(UNLATCH, "run", path, "--accuracy").stdout.split("value      error  order\n")[1].split("\n\n")[0]
        values = {line[2:60].strip(): float(line[60:79]) for line in table.split("\n")}
        self.assertAlmostEqual(values["peak reaction hold z"], 8829, delta=1e-6)
        self.assertEqual([name for name, value in values.items() if 0 < abs(value) < 1e-9], [])

    def test_a_body_is_late_only_beside_those_that_leave_the_same_one(self):
        path = self.folder / "leavers.yaml"
        path.write_text(LEAVERS)
        said = self.run_ok(UNLATCH, "run", path).stdout
        late = re.findall(r"(\w+) stayed on (\w+) ([\d.]+) s longer than (\w+)", said)
        self.assertEqual(late, [("lid", "right", "0.300", "box")])


if __name__ == "__main__":
    main()
