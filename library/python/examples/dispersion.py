#!/usr/bin/env python3
"""A dispersion study with plots: the boosters' clearances when masses and thrusts scatter. dispersion.py SCENARIO PICTURE [SAMPLES]"""
import sys

import matplotlib
import numpy as np

import unlatch

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

count = int(sys.argv[3]) if len(sys.argv) > 3 else 40
random = np.random.default_rng(1)
masses = random.normal(4380, 44, (count, 4))  # kg, masses of the boosters

with unlatch.Batch(sys.argv[1], judge=True) as batch:
    for sample in masses:
        batch.add({f"bodies.booster{i + 1}.mass": mass for i, mass in enumerate(sample)})
    batch.run()
    assert batch.ok.all(), batch.why(int(np.argmin(batch.ok)))
    margins, times = batch.margins, batch.event_times
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 4), layout="constrained")
    for i in range(4):
        left.plot(masses[:, i], times[f"release:booster{i + 1}"], ".", label=f"booster {i + 1}")
    left.set(xlabel="mass of the booster, kg", ylabel="release, s")
    left.legend()
    right.boxplot([values[~np.isnan(values)] for values in margins.values()], labels=list(margins))
    right.set(ylabel="margin")
    figure.savefig(sys.argv[2])
    for name, values in margins.items():
        print(f"{name}: margin from {np.nanmin(values):.4f} to {np.nanmax(values):.4f}")
