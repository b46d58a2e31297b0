#!/usr/bin/env python3
"""Sensors with the errors of data sheets, as flight software received them: Allan deviations, steps, limits, losses, the same bits. Run by ctest:

    sensors_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import sys

from processes import SCENARIOS, UNLATCH, ProcessTest, call, main

sys.dont_write_bytecode = True
sys.path.insert(0, str(SCENARIOS / "sensors"))
import judge  # noqa: E402

FILE = SCENARIOS / "sensors/scenario.yaml"
DEGREE, HOUR, G0 = math.pi / 180, 3600.0, 9.80665
ARW, RRW, DRIFT, DRIFT_TIME, LSB = 0.05 * DEGREE / 60, 0.1 * DEGREE / HOUR / 60, DEGREE / HOUR, 300.0, 0.2 * DEGREE / HOUR  # of gyro_tactical
PERIOD, SAMPLES = 0.1, 100000  # s, of the long runs for Allan deviations: at rest, as on a bench; else scale and misalignment turn the nutation into an error
LONG = ["--set", "constants.spin=0 deg/s", "--set", "constants.fire=1e9 s", "--dt", PERIOD, "--until", PERIOD * SAMPLES, "--set", f"constants.fast={PERIOD}", "--set", "clearance=[]", "--set", "outputs=[{select: ['*.gyro1']}]"]
HALF_WALK = 0.01  # of a walk's deviation: that of samples exceeds the closed form by the root of 1 + 1/(2 m^2), m from 10 on


def get_three_sigma(m, axes=3, samples=SAMPLES):
    """Of an Allan deviation over m of n samples the relative standard deviation is 1 / sqrt(2 (n/m - 1)), for each of independent axes (IEEE Std 952)."""
    return 3 / math.sqrt(2 * axes * (samples / m - 1))


def pool(rows, name, m):
    """Allan deviation of received less true values, the mean of the squares of three axes."""
    squares = [judge.calc_allan([row[f"received.{name}.{axis}"] - row[f"sensor.{name}.{axis}"] for row in rows], m) ** 2 for axis in "xyz"]
    return math.sqrt(sum(squares) / 3)


class SensorsTest(ProcessTest):
    def fly(self, *options, outputs="*.gyro1", every=10, scenario=FILE, log="flight.log"):
        return judge.fly(UNLATCH, self.folder / log, *options, scenario=scenario, outputs=outputs, every=every)[0]

    def fly_long(self, **errors):
        changes = [part for key, value in errors.items() for part in ("--set", f"sensors.gyro1.errors.{key}={value}")]
        return self.fly(*LONG, *changes, every=1)

    def check_slope(self, found, slope):
        """`found`: {m: deviation}. The slope on logarithmic axes between the first and the last one."""
        first, last = min(found), max(found)
        tolerance = (get_three_sigma(first) + get_three_sigma(last)) / math.log(last / first)
        self.assertAlmostEqual(math.log(found[last] / found[first]) / math.log(last / first), slope, delta=tolerance)

    def test_white_noise_of_the_received_gyro_is_the_angle_random_walk_with_slope_minus_one_half(self):
        rows = self.fly_long(drift=0, walk=0)
        found = {m: pool(rows, "gyro1", m) for m in (1, 10, 100, 1000)}
        for m, deviation in found.items():
            self.assertAlmostEqual(deviation * math.sqrt(m * PERIOD) / ARW, 1, delta=get_three_sigma(m), msg=m)
        self.check_slope(found, -0.5)

    def test_the_walk_of_the_received_gyro_is_the_rate_random_walk_with_slope_plus_one_half(self):
        rows = self.fly_long(noise_density=0, drift=0, quantum=0)
        found = {m: pool(rows, "gyro1", m) for m in (10, 100, 1000)}
        for m, deviation in found.items():
            self.assertAlmostEqual(deviation / (RRW * math.sqrt(m * PERIOD / 3)), 1, delta=get_three_sigma(m) + HALF_WALK, msg=m)
        self.check_slope(found, 0.5)

    # The squares add: white noise, walk, and the first-order process, whose closed form is IEEE Std 952's.
    def test_the_whole_gyro_has_the_allan_deviation_of_its_data_sheet(self):
        rows = self.fly_long()
        for m in (1, 10, 100, 1000, 3000):
            tau = m * PERIOD
            r = tau / DRIFT_TIME
            drift = 2 * DRIFT**2 / r * (1 - (3 - 4 * math.exp(-r) + math.exp(-2 * r)) / (2 * r))
            expected = math.sqrt(ARW**2 / tau + RRW**2 * tau / 3 + drift)
            self.assertAlmostEqual(pool(rows, "gyro1", m) / expected, 1, delta=get_three_sigma(m) + HALF_WALK, msg=m)

    def test_each_grade_has_the_noise_of_its_data_sheet(self):
        gyros = {"navigation": 0.002, "tactical": 0.05, "mems": 0.2}         # deg/√h
        accelerometers = {"navigation": 5, "tactical": 50, "mems": 150}      # µg/√Hz
        trackers = {"fine": 1, "standard": 5, "nano": 20}                    # seconds of arc, of a sample
        instances = [f"  - {{template: {kind}_{grade}, for: [{{i: _{grade}, body: craft{', dropout: 0, latency: 0' if kind == 'star_tracker' else ''}}}]}}"
                     for kind, grades in (("gyro", gyros), ("accelerometer", accelerometers), ("star_tracker", trackers)) for grade in grades]
        (self.folder / "parts").mkdir()
        (self.folder / "parts/sensors.yaml").write_text((SCENARIOS / "sensors/parts/sensors.yaml").read_text())
        names = [f"{kind}_{grade}" for kind, grades in (("gyro", gyros), ("accelerometer", accelerometers), ("star_tracker", trackers)) for grade in grades]
        quiet = "\n".join(f"  sensors.{name}.errors.{key}: 0" for name in names for key in ("drift", "turn_on"))
        path = self.folder / "grades.yaml"
        path.write_text("unlatch: 1\ninclude: parts/sensors.yaml\nname: grades\nstep: {dt: 10 ms, until: 100 s}\nbodies:\n  craft: {mass: 1, inertia: [1, 1, 1]}\n"
                        "instances:\n" + "\n".join(instances) + f"\nset:\n{quiet}\n" f"timing: {{groups: {{all: {{every: 1, sensors: [{', '.join(names)}]}}}}}}\n")
        rows = self.fly(scenario=path, outputs="sensor.*,received.*", every=1)
        count = len(rows)
        self.assertEqual(count, 10001)
        for m in (1, 10):  # at 0.01 and 0.1 s the walk is small; one bit adds its square / 12 to that of a sample
            tau = 0.01 * m
            for grade, arw in gyros.items():
                bit = {"navigation": 0.02 / HOUR, "tactical": 0.2 / HOUR, "mems": 0.0125}[grade] * DEGREE
                expected = math.sqrt(((arw * DEGREE / 60) ** 2 + bit**2 / 12 * 0.01) / tau)
                self.assertAlmostEqual(pool(rows, f"gyro_{grade}", m) / expected, 1, delta=get_three_sigma(m, samples=count), msg=grade)
            for grade, density in accelerometers.items():
                bit = {"navigation": 1, "tactical": 10, "mems": 250}[grade] * 1e-6 * G0
                expected = math.sqrt(((density * 1e-6 * G0) ** 2 + bit**2 / 12 * 0.01) / tau)
                self.assertAlmostEqual(pool(rows, f"accelerometer_{grade}", m) / expected, 1, delta=get_three_sigma(m, samples=count), msg=grade)
        for grade, noise in trackers.items():
            errors = [e for row in rows for e in judge.between(judge.read(row, f"sensor.star_tracker_{grade}"), judge.read(row, f"received.star_tracker_{grade}"))]
            found = math.sqrt(sum(e * e for e in errors) / len(errors)) / (DEGREE / HOUR)
            self.assertAlmostEqual(found / noise, 1, delta=3 / math.sqrt(2 * len(errors)), msg=grade)

    def test_received_values_replay_to_the_bit_and_follow_the_seed(self):
        first, again, other = self.fly(log="a.log", outputs="*.*1"), self.fly(log="b.log", outputs="*.*1"), self.fly("--set", "sensor_seed=2", outputs="*.*1")
        self.run_ok(UNLATCH, "replay", self.folder / "a.log")
        self.assertEqual(call(UNLATCH, "diff", self.folder / "a.log", self.folder / "b.log").returncode, 0)
        self.assertEqual(first, again)
        truth = [[value for key, value in row.items() if key.startswith("sensor")] for row in first]
        self.assertEqual(truth, [[value for key, value in row.items() if key.startswith("sensor")] for row in other])
        equal = sum(a["received.gyro1.x"] == b["received.gyro1.x"] for a, b in zip(first, other))
        self.assertLess(equal, 0.05 * len(first))  # by chance: the noise is some hundred bits wide

    def test_neither_the_order_of_groups_nor_a_sensor_before_the_others_changes_what_is_received(self):
        text = FILE.read_text().replace("include: parts/sensors.yaml", "include: sensors.yaml")
        (self.folder / "sensors.yaml").write_text((SCENARIOS / "sensors/parts/sensors.yaml").read_text())
        lines = text.split("\n")
        at = next(i for i, line in enumerate(lines) if line.startswith("    inertial:"))
        lines[at], lines[at + 1] = lines[at + 1].replace("star_tracker1", "gyro2, star_tracker1"), lines[at].replace("gyro1, accelerometer1, wire1", "wire1, accelerometer1, gyro1")
        at = next(i for i, line in enumerate(lines) if "template: gyro_tactical" in line)
        lines.insert(at, "  - {template: gyro_mems, for: [{i: 2, body: stage}]}")
        path = self.folder / "other.yaml"
        path.write_text("\n".join(lines))
        outputs = "*.gyro1,*.accelerometer1,*.star_tracker1,*.wire1,*.switch1"
        self.assertEqual(self.fly(outputs=outputs), self.fly(scenario=path, outputs=outputs))

    def test_received_rates_are_whole_bits(self):
        for row in self.fly():
            for axis in "xyz":
                bits = row[f"received.gyro1.{axis}"] / LSB
                self.assertAlmostEqual(bits, round(bits), delta=1e-6)

    def test_beyond_its_range_the_gyro_saturates_and_says_so_in_one_axis_alone(self):
        limit = 0.4  # rad/s; the spin is 0.524
        rows = self.fly("--set", f"sensors.gyro1.errors.range={limit}")
        self.assertTrue(all(-1e-12 * limit <= limit - row["received.gyro1.x"] < LSB for row in rows))  # its largest code within the range
        self.assertTrue(all(abs(row["received.gyro1.y"] - row["sensor.gyro1.y"]) < 0.01 for row in rows))

    def test_lost_samples_are_held_and_as_many_as_said(self):
        part = 0.05
        rows = self.fly("--set", f"sensors.gyro1.errors.dropout={part}")
        held = sum(all(a[f"received.gyro1.{axis}"] == b[f"received.gyro1.{axis}"] for axis in "xyz") for a, b in zip(rows, rows[1:]))
        self.assertAlmostEqual(held, part * (len(rows) - 1), delta=4 * math.sqrt(part * (1 - part) * len(rows)))

    def test_the_wires_signal_comes_with_the_sample_after_its_break_and_its_delay(self):
        rows, result = judge.fly(UNLATCH, self.folder / "wire.log", "--set", "sensors.wire1.errors.dropout=0", outputs="*.wire1,*.switch1", every=1)
        happened = {event["name"]: event["t"] for event in result["events"]}
        for sensor, event, late in (("wire1", "broken", 0.02), ("switch1", "opens", 0.0)):
            came = next(row["t"] for row in rows if row[f"received.{sensor}"] > 0.5)
            self.assertAlmostEqual(came, math.ceil(happened[event] / 0.01) * 0.01 + late, delta=1e-9)

    def test_requirements_on_received_values_follow_the_seed_and_those_on_true_values_do_not(self):
        def judge_seed(seed):
            result = json.loads(self.run_ok(UNLATCH, "run", FILE, "--until", 11, "--set", f"sensor_seed={seed}", "--json", "-", code=None).stdout)
            return {one["id"]: one["value"] for one in result["verdict"]}
        first, other = judge_seed(1), judge_seed(2)
        self.assertNotEqual(first["gyro"], other["gyro"])
        self.assertEqual({key: value for key, value in first.items() if key != "gyro"}, {key: value for key, value in other.items() if key != "gyro"})
        rows = self.fly("--until", 11)  # a session judges what it received: the spin's largest value, from its own recording
        spins = [row["received.gyro1.x"] for row in rows if row["t"] <= 10]
        self.assertIn(first["gyro"], (max(spins), min(spins)))

    def test_the_observer_of_each_sample_of_the_campaign_keeps_its_limit(self):
        folder = self.folder / "campaign"
        self.run_ok(UNLATCH, "campaign", SCENARIOS / "sensors/campaign.yaml", "--samples", "0:6", "--out", folder, code=None)
        judged = self.run_ok(SCENARIOS / "sensors/judge.py", folder, "--unlatch", UNLATCH)
        rows = [line.split(",") for line in judged.stdout.splitlines()[1:]]
        self.assertEqual(len(rows), 6)
        self.assertEqual(len({row[4] for row in rows}), 6)  # the seeds and the parameters reach the sensors
        for row in rows:
            self.assertTrue(20 <= float(row[6]) <= 50, row)  # two samples late, and what dropouts hold


if __name__ == "__main__":
    main()
