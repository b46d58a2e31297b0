#!/usr/bin/env python3
"""Two stages part by bolts, pushers and an umbilical: against trajectories that share nothing with the kernel, and energy. Run by ctest:

    interstage_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

SCENARIO = SCENARIOS / "interstage/scenario.yaml"
TOGETHER = [word for i in range(1, 9) for word in ("--set", f"events.break:bolt{i}.delay=0")]
# Of a step of 0.25 ms. Friction comes up within 1 mm/s, a twentieth of the first millisecond's motion: the rest is smaller.
TIME, SPEED, RATE, PLACE = 5e-7, 1e-7, 1e-7, 2e-7  # s, m/s, rad/s, m


def run(*options):
    return json.loads(call(UNLATCH, "run", *options, "--json", "-").stdout)


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

    # Work of six pushers less their friction, over the reduced mass; nothing else acts, and the bolts break at once.
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
        told = call(UNLATCH, "replay", log).stdout
        self.assertIn("every bit agrees", told)


if __name__ == "__main__":
    main()
