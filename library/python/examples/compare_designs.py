#!/usr/bin/env python3
"""Two designs side by side: the unchanged scenario, and one with a heavier core. compare_designs.py SCENARIO"""
import sys

import numpy as np

import unlatch

DESIGNS = {"as it is": {}, "heavier core": {"bodies.core.mass": "110 t"}}

paths = {}
for name, overrides in DESIGNS.items():
    with unlatch.load(sys.argv[1], overrides) as sim:
        core, booster = sim.bodies["core"], sim.bodies["booster1"]
        path = []
        while sim.tick < 1500:
            sim.run(ticks=100)
            path.append((booster.position - core.position).copy())  # views change with the simulation: copies are kept
        paths[name] = np.array(path)
        release = next(event.time for event in sim.events if event.name == "release")
        print(f"{name}: release at {release:.4f} s, booster1 {np.linalg.norm(path[-1]):.3f} m from the core at {sim.time:g} s")
first, second = paths.values()
print(f"largest difference {np.abs(first - second).max():.3f} m")
