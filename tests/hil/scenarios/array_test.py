#!/usr/bin/env python3
"""Solar arrays as users run them, against tests/references/array_reference.py (planar, DOP853 at 1e-12). Run by ctest:

    array_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import sys

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

ARRAY = SCENARIOS / "array"
REFERENCE = json.loads((SOURCE / "tests/data/array_panels.json").read_text())
EVENT_TIME = 1e-6  # s, asked for at 1 ms
STATE = 1e-6       # m, rad: of motions of some metres and radians
RATE = 1e-6        # m/s, rad/s
MODES = [complex(*mode) for mode in REFERENCE["modes"]]  # 1/s: damping and frequency


def left_by_modes(signal, times, modes):
    """Returns the part of a signal, by its norm, that damped modes (complex eigenvalues) do not explain: Gram and Schmidt, applied twice."""
    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    def without(a, unit):
        along = dot(a, unit)
        return [x - along * y for x, y in zip(a, unit)]

    basis = []
    for mode in modes:
        for wave in (math.cos, math.sin):
            column = [math.exp(mode.real * (t - times[0])) * wave(mode.imag * (t - times[0])) for t in times]
            for unit in basis + basis:
                column = without(column, unit)
            norm = math.sqrt(dot(column, column))
            basis.append([x / norm for x in column])
    rest = signal
    for unit in basis:
        rest = without(rest, unit)
    return math.sqrt(dot(rest, rest) / dot(signal, signal))


class ArrayTest(ProcessTest):
    def compare(self, name, scenario, until=math.inf):
        reference = REFERENCE[name]
        states = {float(t): state for t, state in reference["samples"].items() if float(t) <= until}
        report = self.run_json(UNLATCH, "run", scenario, "--until", max(states), "--sample",
                               ",".join(map(str, sorted(states))))
        self.assertEqual(report["status"], "ok")
        latches = sorted((event["subject"], event["t"]) for event in report["events"] if event["name"] == "latch")
        expected = sorted((f"panel{k}", t) for t, k in reference["events"] if t <= until)
        self.assertEqual([subject for subject, _ in latches], [subject for subject, _ in expected])
        worst_time = max((abs(a[1] - b[1]) for a, b in zip(latches, expected)), default=0)
        self.assertLess(worst_time, EVENT_TIME)
        worst = worst_rate = 0
        for sample in report["samples"]:
            state = states[round(sample["t"], 9)]
            count = len(state) // 2
            for i, body in enumerate(sample["bodies"].values()):
                turn = 2 * math.atan2(body["q"][3], body["q"][0])
                found = [*body["p"][:2], turn, *body["v"][:2], body["w"][2]]
                wanted = state[3 * i:3 * i + 3] + state[count + 3 * i:count + 3 * i + 3]
                gap = [abs(a - b) for a, b in zip(found, wanted)]
                gap[2] = abs(math.remainder(gap[2], 2 * math.pi))
                worst, worst_rate = max(worst, *gap[:3]), max(worst_rate, *gap[3:])
        self.assertLess(worst, STATE)
        self.assertLess(worst_rate, RATE)
        print(f"{name}: latches {worst_time:.1e} s, places {worst:.1e}, rates {worst_rate:.1e}", file=sys.stderr)

    def hinge_angles(self, times):
        """Angles of elastic.yaml, rad, a list for each hinge."""
        report = self.run_json(UNLATCH, "run", ARRAY / "elastic.yaml", "--sample", ",".join(map(str, times)))
        self.assertLess(max(event["t"] for event in report["events"]), times[0])
        turns = [[2 * math.atan2(body["q"][3], body["q"][0]) for body in sample["bodies"].values()] for sample in report["samples"]]
        return [[math.remainder(turn[k + 1] - turn[k], 2 * math.pi) for turn in turns] for k in range(4)]

    def test_the_shock_of_the_last_latch_rings_in_every_mode_of_a_linear_array(self):
        times = [round(6.59 + i / 1000, 3) for i in range(1001)]
        angles = self.hinge_angles(times)
        for angle in angles:
            self.assertLess(left_by_modes(angle, times, MODES), 3e-3)  # angles reach 0.08 rad: the remainder is not linear
        for mode in MODES:
            self.assertGreater(left_by_modes(angles[1], times, [other for other in MODES if other != mode]), 5e-2)

    def test_ten_seconds_of_ringing_resolve_a_hundredth_of_a_frequency(self):
        times = [10 + i / 100 for i in range(1001)]
        for angle in self.hinge_angles(times):
            self.assertLess(left_by_modes(angle, times, MODES), 3e-3)
            self.assertGreater(left_by_modes(angle, times, [complex(mode.real, 1.01 * mode.imag) for mode in MODES]), 5e-2)

    def generate(self, panels):
        path = self.folder / "array.yaml"
        path.write_text(self.run_ok(ARRAY / "make-array", panels).stdout)
        return path

    def test_four_panels_with_cables_latch_as_the_reference_does(self):
        self.compare("scenario", ARRAY / "scenario.yaml")

    def test_elastic_latches_swing_as_the_reference_does(self):
        self.compare("elastic", ARRAY / "elastic.yaml")

    def test_elastic_cables_swing_as_the_reference_does(self):
        self.compare("elastic-cables", ARRAY / "elastic-cables.yaml")

    def test_two_eight_and_sixteen_panels_unfold_as_the_reference_does(self):
        self.compare("two", self.generate(2))
        self.compare("eight", self.generate(8))
        self.compare("sixteen", self.generate(16))

    def test_thirty_two_and_sixty_four_panels_begin_as_the_reference_does(self):
        """Compares the first seconds: a run until all have latched takes minutes; hil/scenarios/array/README.md has those figures."""
        self.compare("thirty-two", self.generate(32), until=2)
        self.compare("sixty-four", self.generate(64), until=2)

    def test_panels_tied_by_cables_latch_together(self):
        report = self.run_json(UNLATCH, "run", self.generate(8), "--until", "13")
        times = {event["subject"]: event["t"] for event in report["events"]}
        self.assertEqual(len({times[f"panel{k}"] for k in range(2, 9)}), 1)
        for audit in report["audit"]:  # momenta across the plastic impulse
            for jump in (*audit["momentum_jump"], *audit["angular_momentum_jump"]):
                self.assertLess(abs(jump), 1e-10)
            self.assertLessEqual(audit["energy_jump"], 1e-12)

    def test_sixty_four_panels_are_a_valid_scenario(self):
        self.assertIn("panel64", self.run_ok(UNLATCH, "check", self.generate(64)).stdout)

    def test_shipped_files_are_what_their_generator_writes(self):
        self.run_ok(ARRAY / "make-array", "--check")
        self.assertEqual(call(ARRAY / "make-array").returncode, 2)


if __name__ == "__main__":
    main()
