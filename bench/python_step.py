#!/usr/bin/python3
"""One call a step from Python beside run(), by turns over the same ticks: python_step.py [BUILD_FOLDER]. Writes bench/results/python.md."""
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build/release"
sys.path.insert(0, str(BUILD / "python"))

import unlatch  # noqa: E402

BLOCK, TURNS = 200, 401
rows = ""
for name, tick in (("boosters", 300), ("array", 3000), ("tree20", 100)):
    with unlatch.load(ROOT / f"hil/scenarios/{name}/reference.yaml") as sim:
        sim.run(ticks=tick)
        state, native = sim.save(), sim._native
        singles, runs, differences = [], [], []
        for _ in range(TURNS):
            sim.restore(state)
            native.advance(10, False)
            step, begin = sim.step, time.perf_counter_ns()
            for _ in range(BLOCK):
                step()
            single = (time.perf_counter_ns() - begin) / BLOCK
            sim.restore(state)
            native.advance(10, False)
            begin = time.perf_counter_ns()
            native.advance(BLOCK, False)
            run = (time.perf_counter_ns() - begin) / BLOCK
            singles.append(single)
            runs.append(run)
            differences.append(single - run)
        rows += (f"| {name} | {min(runs):.0f}, {statistics.median(runs):.0f} | {min(singles):.0f}, {statistics.median(singles):.0f} | "
                 f"{statistics.median(differences):.0f} |\n")
commit = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True, text=True, check=False).stdout.strip()
text = (f"# Steps from Python\n\nns for each tick: least, and median of {TURNS} blocks of {BLOCK}; `difference` is the median of block by block. Commit {commit}. "
        "Written by bench/python_step.py.\n\n| scenario | run() | step() in a loop | difference |\n|---|---|---|---|\n" + rows)
(ROOT / "bench/results/python.md").write_text(text, encoding="utf-8")
print(text)
