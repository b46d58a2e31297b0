#!/usr/bin/env python3
"""Wake-up latency and step time of the cyclic executive beside cyclictest, on one CPU at the same time, with and without
load on the others: bench/jitter.py BIN_FOLDER [SECONDS]. Writes bench/results/jitter.csv and jitter.md.

Both threads are SCHED_FIFO 80, pinned to the last CPU, with absolute deadlines a period apart and phases of their own.
A third one, the yardstick, times some 5 us of arithmetic in registers each period: what it stretches to is the machine's doing, not the step's. The load is stress-ng on all other CPUs.
Needs rt-tests and stress-ng (tools/setup bench), and the right to SCHED_FIFO."""

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path

BIN = Path(sys.argv[1])
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 20
RESULTS = Path(__file__).parent / "results"
CPU = os.cpu_count() - 1
CASES = [  # scenario, period in us, spin in us
    ("boosters", 1000, 0),
    ("boosters", 1000, 100),
    ("boosters", 100, 0),
    ("boosters", 100, 30),
    ("array64", 1000, 0),
    ("array64", 1000, 300),
]
COLUMNS = ["scenario", "period_us", "spin_us", "load", "what", "count", "min", "p50", "p99", "p999", "p9999", "max", "overruns"]


def calc_percentiles(histogram):
    """Of cyclictest's {whole microseconds: count}, in ns, the middle of each."""
    total, seen, row = sum(histogram.values()), 0, {}
    wanted = [("p50", 0.5), ("p99", 0.99), ("p999", 0.999), ("p9999", 0.9999)]
    for us, count in sorted(histogram.items()):
        seen += count
        while wanted and seen >= wanted[0][1] * total:
            row[wanted.pop(0)[0]] = us * 1000 + 500
    return row


def run_cyclictest(period_us):
    loops = int(SECONDS * 1e6 / period_us)
    output = RESULTS / "cyclictest.json"
    process = subprocess.Popen(["cyclictest", "-m", "-p80", "-t1", f"-a{CPU}", f"-i{period_us}", f"-l{loops}", "-q", "-h50000",
                                f"--json={output}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def collect():
        process.wait()
        thread = json.loads(output.read_text())["thread"]["0"]
        output.unlink()
        histogram = {int(us): count for us, count in thread["histogram"].items()}
        row = calc_percentiles(histogram)
        # It skips the deadlines that it has missed; those are what it has fewer cycles than asked for in its time.
        late = sum(count for us, count in histogram.items() if us >= period_us) + max(0, int(thread["max"] >= 50000))
        return dict(row, count=thread["cycles"], min=thread["min"] * 1000, max=thread["max"] * 1000, overruns=late)

    return collect


def run_case(scenario, period_us, spin_us, load):
    stress = None
    if load:
        cpus = ",".join(str(cpu) for cpu in range(CPU)) or "0"
        stress = subprocess.Popen(["stress-ng", "--quiet", "--taskset", cpus, "--cpu", str(max(CPU, 1)), "--vm", "1", "--vm-bytes", "64M",
                                   "--io", "1"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(1)
    try:
        collect = run_cyclictest(period_us)
        ours = subprocess.run([BIN / "jitter_bench", "--scenario", scenario, "--period-us", str(period_us), "--seconds", str(SECONDS),
                               "--spin-us", str(spin_us), "--cpu", str(CPU)], capture_output=True, text=True)
        theirs = collect()
    finally:
        if stress:
            stress.terminate()
            stress.wait()
    if ours.stderr:
        print(ours.stderr, file=sys.stderr)
    report = json.loads(ours.stdout)
    common = {"scenario": scenario, "period_us": period_us, "spin_us": spin_us, "load": "stress-ng" if load else "none"}
    return [dict(common, what="unlatch wake-up", overruns=report["overruns"], **report["wakeup_ns"]),
            dict(common, what="cyclictest wake-up", **theirs),
            dict(common, what="unlatch step", overruns=report["overruns"], **report["step_ns"]),
            dict(common, what="yardstick", overruns=0, **report["yardstick_ns"]),
            dict(common, what="first reading", overruns=0, **report["first_reading_ns"]),
            dict(common, what="second reading", overruns=0, **report["second_reading_ns"])], report["causes"]


def describe_machine():
    lscpu = subprocess.run(["lscpu"], capture_output=True, text=True).stdout
    lines = [line for line in lscpu.splitlines() if line.startswith(("Model name", "CPU(s):", "Hypervisor"))]
    busy = Path("/proc/loadavg").read_text().split()[0]
    return [" ".join(line.split()) for line in lines] + [" ".join(os.uname()[0:4:2]) + " " + os.uname().version,
                                                          f"load average at the start {busy}", time.strftime("%Y-%m-%d %H:%M")]


def write(rows, notes, machine):
    with open(RESULTS / "jitter.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    lines = ["# Wake-up latency and step time, microseconds", "", "bench/jitter.py; ns in jitter.csv. " + "; ".join(machine) + ".", "",
             "| case | period | spin | load | | p50 | p99 | p99.9 | p99.99 | max | overruns |", "|---|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        numbers = " | ".join(f"{row[name] / 1000:.1f}" for name in ("p50", "p99", "p999", "p9999", "max"))
        lines.append(f"| {row['scenario']} | {row['period_us']} | {row['spin_us']} | {row['load']} | {row['what']} | {numbers} | {row['overruns']} |")
    lines += ["", "Load none is without stress-ng. With a load average well above 0 at the start others used the machine, and tails are theirs."]
    (RESULTS / "jitter.md").write_text("\n".join(lines + [""] + notes) + "\n")


def main():
    machine, rows, notes = describe_machine(), [], []
    for load in (False, True):
        for scenario, period_us, spin_us in CASES:
            found, causes = run_case(scenario, period_us, spin_us, load)
            rows += found
            ours, theirs, step, yardstick, first, second = found
            causes = ", ".join(f"{name} {count}" for name, count in causes.items() if count)
            notes.append(f"- {scenario}, {period_us} us, spin {spin_us}, {found[0]['load']}: median wake-up {ours['p50'] / max(theirs['p50'], 1):.2f} × "
                         f"cyclictest's; step p99.9 / median {step['p999'] / step['p50']:.2f}, "
                         f"yardstick's {yardstick['p999'] / yardstick['p50']:.2f}, readings' {first['p999'] / first['p50']:.2f} and "
                         f"{second['p999'] / second['p50']:.2f}; median step {step['p50'] / period_us / 10:.1f} % "
                         f"of the period; overruns: {causes or 'none'}")
            print(notes[-1], flush=True)
    write(rows, notes, machine)


main()
