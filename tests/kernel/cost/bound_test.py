#!/usr/bin/env python3
"""Instructions of steps of random systems, counted by callgrind, are below the bound of `unlatch check --cost x86-64`:
bound_test.py BIN [FIRST_SEED]. Skipped (77) where valgrind is missing or the processor has no AVX2, which the table is for."""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FIRST, SYSTEMS, TICKS, MOST_BYTES = 200_001, 8, 40, 30_000  # few and small: callgrind is slow; a million steps are among the long tests
STEP = "unlatch::step(unlatch::Plan const&, unlatch::Inputs const&, unlatch::State&, unlatch::Workspace&, unlatch::MotionLog*)"


def run(command, **options):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True, **options).stdout


def count_steps(models, image, folder):
    """Of each step: what it has done (the words of StepCounts), instructions."""
    steps = run(["valgrind", "-q", "--tool=callgrind", f"--toggle-collect={STEP}", f"--dump-after={STEP}",
                 f"--callgrind-out-file={folder}/dump", models, "steps", image, TICKS]).splitlines()
    dumps = sorted(folder.glob("dump.*"), key=lambda path: int(path.suffix[1:]))
    totals = [int(re.search(r"^(?:totals|summary): (\d+)", dump.read_text(errors="replace"), re.M)[1]) for dump in dumps]
    for dump in dumps:
        dump.unlink()
    return list(zip(steps, totals))


def main():
    models = Path(sys.argv[1]) / "cost_models"
    if not shutil.which("valgrind") or "avx2" not in Path("/proc/cpuinfo").read_text():
        print("skipped: no valgrind, or no AVX2")
        return 77
    first = int(sys.argv[2]) if len(sys.argv) > 2 else FIRST
    print(f"seeds from {first}")
    worst, steps, above, unmeasured = 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder, left, seed = Path(name), SYSTEMS, first
        while left > 0:
            image = folder / (run([models, "images", folder, seed, 1]).strip() + ".plan")
            seed += 1
            if image.stat().st_size > MOST_BYTES:
                continue
            if run([models, "bound", "x86-64"], input=f"{image} 1 1 1 1 1\n").strip() == "unmeasured":
                unmeasured += 1
                continue
            left -= 1
            counted = count_steps(models, image, folder)[1:]  # the first begins without an evaluation of its state
            asked = "".join(f"{image} {counts}\n" for counts, _ in counted)
            for (counts, count), bound in zip(counted, run([models, "bound", "x86-64"], input=asked).split()):
                steps += 1
                share = count / float(bound)
                worst = max(worst, share)
                if share > 1:
                    above += 1
                    print(f"{image.stem}: integrations, rounds, waits, jumps and timed splits {counts}: {count} instructions, bound {bound}")
    print(f"{steps} steps, the largest {worst:.3f} of its bound, {above} above; {unmeasured} systems have no bound")
    return 1 if above or steps < SYSTEMS * TICKS / 2 else 0


if __name__ == "__main__":
    sys.exit(main())
