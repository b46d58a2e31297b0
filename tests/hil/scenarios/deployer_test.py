#!/usr/bin/env python3
"""A cubesat leaves its deployer: against closed forms, and a planar integration that is independent of the kernel. Run by ctest:

    deployer_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import re

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

ALIGNED, MISALIGNED = SCENARIOS / "deployer/scenario.yaml", SCENARIOS / "deployer/misaligned.yaml"
RIGID = SCENARIOS / "deployer/rigid.yaml"
CONTACTS = [f"{kind}{i}" for kind in ("fore", "aft", "lip") for i in range(1, 5)]
# The door stays shut, and the latch opens at 0.1 s: two bodies, as in the reference.
TWO_BODIES = ["--set", "events.open.enabled=false", "--set", "events.release.when={time: 0.1}", "--set", "events.release.delay=0"]
# Friction of the spring grows within 5 mm/s, in the first millisecond: of the second order in the step, at an eighth of one.
TIME, SPEED, RATE = 5e-9, 1e-10, 1e-10  # s, m/s, rad/s
CLOSED_FORM = 1e-5  # m/s: friction of the spring is less than 2 N for its first 5 mm/s, over some 5e-6 m
FINE = ["--set", "step.dt=0.000125", "--set", "step.contact_substeps=16"]
FORCE = 1e-4  # relative; it was 3e-3 where parts did not end where the point of contact gets to another feature
BALANCE = 1e-4  # of 6.6 J, at 1 ms: most of it from the door on its bracket


def run(*options):
    return json.loads(call(UNLATCH, "run", *options, "--json", "-").stdout)


def get_times(found):
    return {event["name"] + (f":{event['subject']}" if event["subject"] else ""): event["t"] for event in found["events"]}


def get_verdicts(found):
    return {verdict["id"]: verdict for verdict in found["verdict"]}


class DeployerTest(ProcessTest):
    # Work of the spring without its friction, over the reduced mass of cubesat and the rest; there is no contact.
    def test_aligned_it_leaves_with_the_work_of_the_spring(self):
        found = run(ALIGNED)
        work, stage, cubesat = (26 - 40 * 0.345 / 2 - 2) * 0.345, 850.2, 4.0
        reduced = stage * cubesat / (stage + cubesat)
        verdicts = get_verdicts(found)
        self.assertAlmostEqual(verdicts["speed"]["value"], math.sqrt(2 * work / reduced), delta=CLOSED_FORM)
        self.assertLess(verdicts["tipoff"]["value"], math.radians(0.05))
        self.assertTrue(all(verdict["met"] for verdict in verdicts.values()))
        self.assertFalse([event for event in found["events"] if event["subject"] in CONTACTS])

    # Rigid rails are what stiff ones tend to, with 1/√k; and their motion does not depend on the step.
    def test_rigid_rails_are_the_limit_of_stiff_ones(self):
        def get_tipoff(scenario, *options):
            return get_verdicts(run(scenario, *options))["tipoff"]["value"]

        def harden(stiffness):
            return [word for name in CONTACTS if not name.startswith("lip") for word in ("--set", f"contacts.{name}.stiffness={stiffness}")]

        rigid = run(RIGID)
        self.assertEqual(rigid["status"], "ok")
        tipoff = get_verdicts(rigid)["tipoff"]["value"]
        self.assertAlmostEqual(get_tipoff(RIGID, "--set", "step.dt=0.0005"), tipoff, delta=1e-5)
        soft, hard = (abs(get_tipoff(MISALIGNED, *harden(k)) - tipoff) for k in ("1 MN/m", "100 MN/m"))
        self.assertLess(hard, 2e-4)
        self.assertAlmostEqual(soft / hard, 10, delta=1.5)

    def test_misaligned_it_moves_as_an_independent_integration(self):
        reference = json.loads((SOURCE / "tests/data/deployer.json").read_text())
        found = run(MISALIGNED, *TWO_BODIES, "--set", "step.dt=0.000125", "--until", "0.6", "--sample", "0.6")
        times = get_times(found)
        for name, time in reference["events"].items():
            self.assertAlmostEqual(times[name], time, delta=TIME, msg=name)
        bodies = found["samples"][-1]["bodies"]
        for axis in (0, 1):
            self.assertAlmostEqual(bodies["cubesat"]["v"][axis], reference["cubesat"]["v"][axis], delta=SPEED)
        w, _, _, z = bodies["cubesat"]["q"]
        self.assertAlmostEqual(2 * math.atan2(z, w), reference["cubesat"]["angle"], delta=RATE)
        for name in ("cubesat", "stage"):
            self.assertAlmostEqual(bodies[name]["w"][2], reference[name]["rate"], delta=RATE, msg=name)
            self.assertLess(max(map(abs, bodies[name]["w"][:2])), RATE, msg=name)  # it stays in the plane

    def test_misaligned_it_slides_on_its_rails_and_tips_off(self):
        aligned, found = run(ALIGNED), run(MISALIGNED)
        verdicts = get_verdicts(found)
        self.assertEqual([name for name, verdict in verdicts.items() if not verdict["met"]], ["tipoff"])
        self.assertGreater(verdicts["tipoff"]["value"], 100 * get_verdicts(aligned)["tipoff"]["value"])
        self.assertLess(verdicts["speed"]["value"], get_verdicts(aligned)["speed"]["value"])  # because of friction on the rails
        touched = {event["subject"] for event in found["events"] if event["name"] == "touch"} & set(CONTACTS)
        self.assertEqual(touched, {"aft1", "aft4", "fore2", "fore3", "lip2", "lip3"})  # across, and the spring's side behind
        exit_time = get_times(found)["exit"]
        self.assertFalse([event for event in found["events"] if event["subject"] in CONTACTS and event["t"] > exit_time])

    # Half and a quarter of the step give the same, and no motion is reported as unresolved.
    def test_the_step_resolves_the_contacts(self):
        rates = []
        for step in ("0.001", "0.0005", "0.00025"):
            found = run(MISALIGNED, "--set", f"step.dt={step}")
            self.assertEqual(found["notices"], [])
            rates.append(get_verdicts(found)["tipoff"]["value"])
        self.assertLess(max(rates) - min(rates), 1e-6)

    # The edge of the cubesat gets onto the round lips from its end, and its corners roll off the rails' edges.
    def test_the_forces_of_corners_and_lips_are_those_of_parts_of_eight_microseconds(self):
        found, fine = (get_verdicts(run(MISALIGNED, "--until", "0.57", *options)) for options in ((), FINE))
        for name in ("aft1", "fore2", "lip2"):
            self.assertAlmostEqual(found[name]["value"] / fine[name]["value"], 1, delta=FORCE, msg=name)

    # Diagonal misalignment: the spring presses the cubesat into one rail; roll couples the contacts.
    def test_momentum_and_energy_balance(self):
        for options in ((ALIGNED,), (MISALIGNED,), (MISALIGNED, "--set", "constants.offset_y=0.006", "--set", "constants.offset_z=0.006")):
            found = run(*options, "--sample", "2")
            self.assertLess(abs(found["energy"]["largest_unexplained"]), BALANCE * found["energy"]["scale"])
            bodies = found["samples"][-1]["bodies"]
            for axis in range(3):
                momentum = sum(mass * bodies[name]["v"][axis] for name, mass in (("stage", 850), ("cubesat", 4), ("door", 0.2)))
                self.assertLess(abs(momentum), 1e-9)

    # Events are within 1e-9 s of each other here: the search for the smallest clearance between them ends.
    def test_a_slight_misalignment_ends_too(self):
        found = run(MISALIGNED, "--set", "constants.offset_y=0.001")
        self.assertIn("exit", {event["name"] for event in found["events"]})
        # A graze of micrometres may be lost within a step: the run says so, and it is no fault.
        self.assertIn(found["status"], ("ok", "unresolved"))

    # Micrometres are not rounded to "-0.0000 m".
    def test_the_report_shows_depths_of_micrometres(self):
        printed = call(UNLATCH, "run", MISALIGNED).stdout
        for line in ("  stage – cubesat ", "    smallest clearance "):
            self.assertRegex(printed, re.escape(line) + r" *-\d\.\d+e-0\d m ")

    def test_the_recording_replays(self):
        log = self.folder / "deployer.log"
        call(UNLATCH, "run", MISALIGNED, "--log", log)
        self.assertIn("every bit agrees", call(UNLATCH, "replay", log).stdout)


if __name__ == "__main__":
    main()
