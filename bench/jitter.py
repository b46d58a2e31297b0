#!/usr/bin/env python3
"""Wake-up latency and step time of the cyclic executive beside cyclictest on one CPU, with and without load on the
others: bench/jitter.py BIN_FOLDER [SECONDS]. Writes bench/results/jitter.csv and jitter.md.

Both threads are SCHED_FIFO 80, pinned to the last CPU, with absolute deadlines a period apart and phases of their own.
"together": at the same time. "in turn": in slices, one after the other, since two threads of 10 kHz would wait for each
other. Yardsticks (hil/session/realtime/yardsticks.h) run beside the executive: work that is the same each time, so that what stretches
it is the machine. steadiness_bench does the same back to back. The load is stress-ng on all other CPUs.
Needs rt-tests and stress-ng (tools/setup bench), and the right to SCHED_FIFO."""

import csv
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

BIN = Path(sys.argv[1])
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 20
RESULTS = Path(__file__).parent / "results"
CPU = os.cpu_count() - 1
SLICES = 8  # number of slices of a case in turn
LONGEST_US = 50_000  # longest latency in cyclictest's histogram
CASES = [  # scenario, period in us, spin in us, "together" or "in turn"
    ("boosters", 1000, 0, "together"),
    ("boosters", 1000, 100, "together"),
    ("array64", 1000, 0, "together"),
    ("array64", 1000, 300, "together"),
    ("boosters", 100, 0, "together"),
    ("boosters", 100, 0, "in turn"),
    ("boosters", 100, 60, "in turn"),
]
YARDSTICKS = ["multiplications", "sums", "first_reading", "second_reading"]
NUMBERS = ["count", "min", "p50", "p99", "p999", "p9999", "max"]
COLUMNS = ["scenario", "period_us", "spin_us", "how", "load", "what", *NUMBERS, "stalls", "late"]


def start_cyclictest(period_us, seconds):
    output = RESULTS / "cyclictest.json"
    process = subprocess.Popen(["cyclictest", "-m", "-p80", "-t1", f"-a{CPU}", f"-i{period_us}", f"-l{int(seconds * 1e6 / period_us)}", "-q",
                                f"-h{LONGEST_US}", f"--json={output}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def collect():
        process.wait()
        thread = json.loads(output.read_text())["thread"]["0"]
        output.unlink()
        histogram = {int(us): count for us, count in thread["histogram"].items()}
        beyond = thread["cycles"] - sum(histogram.values())
        if beyond > 0:
            histogram[LONGEST_US] = histogram.get(LONGEST_US, 0) + beyond
        return summarize_cyclictest(histogram, thread, period_us)

    return collect


def summarize_cyclictest(histogram, thread, period_us):
    """Percentiles in ns, the middle of each microsecond. `stalls`: wake-ups later than the next deadline. cyclictest skips the
    deadlines that have passed by then, the executive skips none; with them they are `late`."""
    row, seen, wanted = {}, 0, [("p50", 0.5), ("p99", 0.99), ("p999", 0.999), ("p9999", 0.9999)]
    for us, count in sorted(histogram.items()):
        seen += count
        while wanted and seen >= wanted[0][1] * sum(histogram.values()):
            row[wanted.pop(0)[0]] = us * 1000 + 500
    return dict(row, count=thread["cycles"], min=thread["min"] * 1000, max=thread["max"] * 1000,
                stalls=sum(count for us, count in histogram.items() if us >= period_us),
                late=sum(count * (us // period_us) for us, count in histogram.items()))


def run_ours(scenario, period_us, spin_us, seconds):
    done = subprocess.run([BIN / "jitter_bench", "--scenario", scenario, "--period-us", str(period_us), "--seconds", str(seconds),
                           "--spin-us", str(spin_us), "--cpu", str(CPU)], capture_output=True, text=True)
    if done.stderr or done.returncode != 0:
        print(f"exit code {done.returncode}: {done.stderr}", file=sys.stderr)
    report = json.loads(done.stdout)
    ticks = {"late": report["overruns"], "stalls": report["overruns"] - report["causes"]["backlog"]}
    found = {"unlatch wake-up": report["wakeup_ns"] | ticks, "unlatch step": report["step_ns"] | ticks}
    return found | {name: report[name + "_ns"] | {"late": 0, "stalls": 0} for name in YARDSTICKS}, report["causes"]


def merge(rows):
    """Merges slices: counts are added; a percentile is the median of the slices' percentiles, not one of all their samples."""
    merged = {name: statistics.median(row[name] for row in rows) for name in ("p50", "p99", "p999", "p9999")}
    merged |= {name: sum(row[name] for row in rows) for name in ("count", "stalls", "late")}
    return merged | {"min": min(row["min"] for row in rows), "max": max(row["max"] for row in rows)}


def run_case(scenario, period_us, spin_us, how):
    slices = []
    for _ in range(1 if how == "together" else SLICES):
        seconds = SECONDS if how == "together" else SECONDS / SLICES
        collect = start_cyclictest(period_us, seconds)
        theirs = collect() if how == "in turn" else None
        ours, causes = run_ours(scenario, period_us, spin_us, seconds)
        slices.append((ours | {"cyclictest wake-up": theirs or collect()}, causes))
    found = {what: merge([slice[0][what] for slice in slices]) for what in slices[0][0]}
    return found, {cause: sum(slice[1][cause] for slice in slices) for cause in slices[0][1]}


def start_load():
    cpus = ",".join(str(cpu) for cpu in range(CPU)) or "0"
    process = subprocess.Popen(["stress-ng", "--quiet", "--taskset", cpus, "--cpu", str(max(CPU, 1)), "--vm", "1", "--vm-bytes", "64M",
                                "--io", "1"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(1)
    return process


def describe_case(case, load, found, causes):
    scenario, period_us, spin_us, how = case
    tail = {what: row["p999"] / row["p50"] for what, row in found.items()}
    ours, theirs, step, sums = (found[what] for what in ("unlatch wake-up", "cyclictest wake-up", "unlatch step", "sums"))
    causes = ", ".join(f"{name} {count}" for name, count in causes.items() if count)
    return (f"- {scenario}, {period_us} us, spin {spin_us}, {how}, {load}: median wake-up {ours['p50'] / max(theirs['p50'], 1):.2f} × cyclictest's; "
            f"median step {step['p50'] / period_us / 10:.1f} % of the period, {step['p50'] / step['min']:.2f} × its least, the sums' {sums['p50'] / sums['min']:.2f}; "
            f"p99.9 / median: step {tail['unlatch step']:.2f}, " + ", ".join(f"{name} {tail[name]:.2f}" for name in YARDSTICKS) +
            f"; stalls {ours['stalls']}, cyclictest's {theirs['stalls']}; ticks late {ours['late']}, {theirs['late']} ({causes or 'none'})")


def describe_steadiness(load, spin_us):
    done = subprocess.run([BIN / "steadiness_bench", "--seconds", str(SECONDS), "--cpu", str(CPU), "--spin-us", str(spin_us)],
                          capture_output=True, text=True, check=True)
    report = json.loads(done.stdout)
    how, lines = (f"1 kHz, spin {spin_us}" if spin_us else "back to back"), []
    for name, text in (("step", "step"), ("sums", "sums as long"), ("quiet_step", "step, where the sums around it are at their least"),
                       ("quiet_sums", "sums as long, there")):
        row = report[name]
        numbers = [f"{row[key] / 1000:.2f}" for key in ("min", "p50", "p99", "p999")] + [f"{100 * row['longer']:.2f} %"] if row["count"] else [""] * 5
        lines.append(f"| {load} | {how} | {text} | {row['count']} | " + " | ".join(numbers) + " |")
    return lines


def describe_machine():
    lscpu = subprocess.run(["lscpu"], capture_output=True, text=True).stdout
    lines = [line for line in lscpu.splitlines() if line.startswith(("Model name", "CPU(s):", "Hypervisor"))]
    busy = Path("/proc/loadavg").read_text().split()[0]
    return [" ".join(line.split()) for line in lines] + [" ".join(os.uname()[0:4:2]) + " " + os.uname().version,
                                                          f"load average at the start {busy}", time.strftime("%Y-%m-%d %H:%M")]


def write(rows, notes, steadiness, machine):
    with open(RESULTS / "jitter.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    lines = ["# Wake-up latency and step time, microseconds", "", "bench/jitter.py; ns in jitter.csv. " + "; ".join(machine) + ".",
             "Load none is without stress-ng. With a load average well above 0 at the start others used the machine, and tails are theirs.",
             "In turn: percentiles are the median of the slices' percentiles. Stalls: ticks whose work ended after the next was due, without those that only",
             "queued behind another (ours); wake-ups later than the next deadline (cyclictest's, which does no work).", "",
             "| case | period | spin | how | load | | p50 | p99 | p99.9 | p99.99 | max | stalls | late |", "|---|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        numbers = " | ".join(f"{row[name] / 1000:.1f}" for name in ("p50", "p99", "p999", "p9999", "max"))
        lines.append("| " + " | ".join(str(row[name]) for name in ("scenario", "period_us", "spin_us", "how", "load", "what")) + f" | {numbers} | {row['stalls']} | {row['late']} |")
    lines += ["", *notes, "", "## Steps between sums", "",
              "steadiness_bench. Longer: the share that took more than 1.5 times the median.", "",
              "| load | | | count | least | p50 | p99 | p99.9 | longer |", "|---|---|---|---|---|---|---|---|---|", *steadiness]
    (RESULTS / "jitter.md").write_text("\n".join(lines) + "\n")


def main():
    machine, rows, notes, steadiness = describe_machine(), [], [], []
    for load in ("none", "stress-ng"):
        stress = start_load() if load == "stress-ng" else None
        try:
            for case in CASES:
                found, causes = run_case(*case)
                common = dict(zip(COLUMNS, case), load=load)
                rows += [dict(common, what=what, **row) for what, row in found.items()]
                notes.append(describe_case(case, load, found, causes))
                print(notes[-1], flush=True)
            for spin_us in (0, 100):
                steadiness += describe_steadiness(load, spin_us)
        finally:
            if stress:
                stress.terminate()
                stress.wait()
    write(rows, notes, steadiness, machine)


if __name__ == "__main__":
    main()
