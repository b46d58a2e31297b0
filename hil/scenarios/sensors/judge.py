#!/usr/bin/python3
"""Flies each sample of a campaign's folder as a session and judges what flight software received: judge.py DIR [--unlatch PROGRAM] [--samples N]

    unlatch campaign campaign.yaml --out DIR
    judge.py DIR

Of each flight: the error of an attitude that an observer of fixed gains has from star tracker and gyro until the release, and afterwards from the gyro alone,
the error of the separation velocity from the accelerometer, and when the break-wire's signal came. The values are those of `received.*`; the campaign's own
requirements are on true values. Exit code 1 if an attitude is beyond its limit. Also used by tools/figures and by the test. SI and radians.
"""
import argparse
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SCENARIO = pathlib.Path(__file__).resolve().parent / "scenario.yaml"
GAIN, BIAS_GAIN = 0.3, 0.04  # of a correction by the star tracker: of the attitude; of the gyro's bias, for each interval
LATENCY = 0.2     # s, by which its values are late: one sample, of the data sheet
LIMIT = math.radians(0.1)  # of the attitude's error at the end
OUTPUTS = "*.gyro1,*.accelerometer1,*.star_tracker1,*.wire1"


def fly(program, log, *options, scenario=SCENARIO, outputs=OUTPUTS, every=10):
    """The rows of a session without flight software, each `every` ticks, as numbers, and its result; a State a thousand ticks is enough."""
    def call(*arguments, codes=(0,)):
        done = subprocess.run([str(a) for a in (program, *arguments)], capture_output=True, text=True)
        if done.returncode not in codes:
            raise RuntimeError(done.stderr)
        return done.stdout
    result = json.loads(call("hil", scenario, "--transport", "inproc", "--pace", "fast", "--log", log, "--json", "-", "--set", "timing.states.every=1000",
                             *options, codes=(0, 1)))  # 1: a requirement is not met
    text = call("export", log, "--format", "csv", "--every", every, "--outputs", outputs, "--out", "-")
    rows = [{key.split(" [")[0]: float(value) for key, value in row.items() if key != "events" and value} for row in csv.DictReader(text.splitlines())]
    return rows, result


def calc_allan(values, m):
    """Overlapping Allan deviation over m samples (IEEE Std 952-2020, annex C)."""
    sums = [0.0]
    for value in values:
        sums.append(sums[-1] + value)
    count = len(values) - 2 * m
    return math.sqrt(sum((sums[k + 2 * m] - 2 * sums[k + m] + sums[k]) ** 2 for k in range(count)) / (2 * m * m * count))


# --- Quaternions w, x, y, z, body to W ------------------------------------------------------------------------------

def multiply(p, q):
    a, b, c, d = p
    w, x, y, z = q
    return [a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w]


def normalize(q):
    size = math.hypot(*q)
    return [x / size for x in q]


def turn(q, vector):
    """q after a turn by a rotation vector in body axes."""
    angle = math.hypot(*vector)
    k = 0.5 if angle < 1e-12 else math.sin(angle / 2) / angle
    return normalize(multiply(q, [math.cos(angle / 2), *(k * v for v in vector)]))


def between(p, q):
    """The rotation vector that turns p into q, body axes."""
    w, *v = multiply([p[0], -p[1], -p[2], -p[3]], q)
    if w < 0:
        w, v = -w, [-x for x in v]
    size = math.hypot(*v)
    return [2 * math.atan2(size, w) / size * x for x in v] if size > 0 else [0.0, 0.0, 0.0]


def read(row, name):
    return [row[f"{name}.{key}"] for key in "wxyz" if f"{name}.{key}" in row]


def observe(rows, release):
    """Errors of the attitude at each row, rad. Before the release each new value of the star tracker corrects the estimate of its own time, LATENCY earlier,
    and the gyro's bias, which at a constant spin holds scale and misalignment too; the gyro carries it on."""
    step = rows[1]["t"] - rows[0]["t"]
    late = round(LATENCY / step)
    first = read(rows[0], "received.star_tracker1")
    path, errors, last, bias = [first], [], first, [0.0, 0.0, 0.0]
    for k, row in enumerate(rows):
        if k > 0:
            rate = [(a + b) / 2 for a, b in zip(read(rows[k - 1], "received.gyro1"), read(row, "received.gyro1"))]
            path.append(turn(path[-1], [step * (w - b) for w, b in zip(rate, bias)]))
        fix = read(row, "received.star_tracker1")
        if k > late and fix != last and row["t"] <= release:
            then = path[k - late]
            error = between(then, fix)
            mended = turn(then, [GAIN * e for e in error])
            bias = [b - BIAS_GAIN * e / LATENCY for b, e in zip(bias, error)]
            path[k] = normalize(multiply(mended, multiply([then[0], -then[1], -then[2], -then[3]], path[k])))
        last = fix
        errors.append((row["t"], math.hypot(*between(path[k], read(row, "true")))))
    return errors


def judge(program, log, *options):
    """Errors of attitude (rad), separation velocity (m/s), time of the wire (s)."""
    rows, result = fly(program, log, *options, outputs=OUTPUTS + ",body.satellite.attitude")
    happened = {event["name"]: event["t"] for event in result["events"]}
    for row in rows:
        for key in "wxyz":
            row["true." + key] = row["satellite.q" + key]
    step = rows[1]["t"] - rows[0]["t"]
    after = [row for row in rows if happened["release"] < row["t"] <= happened["stroke_end"]]
    speed = sum(row["received.accelerometer1.x"] - row["sensor.accelerometer1.x"] for row in after) * step
    wire = next((row["t"] for row in rows if row["received.wire1"] > 0.5), math.nan) - happened["broken"]
    return observe(rows, happened["release"])[-1][1], speed, wire


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--unlatch", default="unlatch")
    parser.add_argument("--samples", type=int, help="only the first ones")
    options = parser.parse_args()
    overrides = {"seed": "sensor_seed", "random_walk [rad/√s]": "sensors.gyro1.errors.noise_density", "mounting [rad]": "sensors.star_tracker1.errors.turn_on",
                 "stiffness [N/m]": "constants.stiffness"}
    print("sample,seed,random_walk [rad/√s],mounting [rad],attitude error [deg],velocity error [mm/s],wire late [ms]")
    failed = 0
    with open(options.folder / "samples.csv", encoding="utf-8") as file, tempfile.TemporaryDirectory(prefix="unlatch_judge_") as work:
        for row in list(csv.DictReader(file))[:options.samples]:
            changes = [part for key, path in overrides.items() for part in ("--set", f"{path}={row[key]}")]
            attitude, speed, wire = judge(options.unlatch, f"{work}/flight.log", "--until", "20", *changes)
            failed += not attitude <= LIMIT
            print(f"{row['sample']},{row['seed']},{float(row['random_walk [rad/√s]']):.3g},{float(row['mounting [rad]']):.3g},{math.degrees(attitude):.4f},"
                  f"{1e3 * speed:.3f},{1e3 * wire:.1f}", flush=True)
    print(f"{failed} beyond {math.degrees(LIMIT):g} deg", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
