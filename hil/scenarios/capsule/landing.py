#!/usr/bin/python3
"""Where the capsules of a campaign land: landing.py FOLDER...

FOLDER has the samples.csv of landing.yaml, with the capsule's state at the end of the burn. From there a point mass flies in the
central field and, ballistically, in an exponential atmosphere that does not turn, down to the ground; RK4 with STEP. It prints the
standard deviations along and across the track, and the semi-axes of the 3-sigma ellipse. SI.
"""
import csv
import math
import pathlib
import sys

import numpy as np

MU, EARTH, ORBIT = 398600.4418e9, 6371e3, 6721e3  # m3/s2, m, m; as in deorbit.yaml
DENSITY, SCALE_HEIGHT = 1.225, 7200.0             # kg/m3 at the ground, m
BALLISTIC = 400 / (1.0 * math.pi * 0.9**2)        # kg/m2: 400 kg, drag coefficient 1, radius 0.9 m
STEP, LONGEST = 0.25, 7200.0                      # s
COLUMNS = [f"output.capsule.{name}.final" for name in ("x", "y", "z", "vx", "vy", "vz")]


def calc_rates(states):
    """Of states (6, n): positions from the Earth's centre, velocities."""
    place, velocity = states[:3], states[3:]
    distance = np.linalg.norm(place, axis=0)
    drag = DENSITY * np.exp(-(distance - EARTH) / SCALE_HEIGHT) * np.linalg.norm(velocity, axis=0) / (2 * BALLISTIC)
    return np.concatenate([velocity, -MU * place / distance**3 - drag * velocity])


def land(states):
    """Places of landing (2, n), m along and across the track, of states (6, n) as landing.yaml gives them. One that is still up
    after LONGEST has nan."""
    now = np.array(states, dtype=float)
    now[0] += ORBIT
    places = np.full((2, now.shape[1]), np.nan)
    flying = np.arange(now.shape[1])
    for _ in range(round(LONGEST / STEP)):
        k1 = calc_rates(now)
        k2 = calc_rates(now + STEP / 2 * k1)
        k3 = calc_rates(now + STEP / 2 * k2)
        k4 = calc_rates(now + STEP * k3)
        later = now + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        before, after = (np.linalg.norm(s[:3], axis=0) - EARTH for s in (now, later))
        down = after <= 0
        if down.any():
            share = before[down] / (before[down] - after[down])
            ground = now[:3, down] + share * (later[:3, down] - now[:3, down])
            along = np.arctan2(-ground[2], ground[0])  # the orbit goes to -z
            across = np.arcsin(ground[1] / np.linalg.norm(ground, axis=0))
            places[:, flying[down]] = EARTH * np.array([along, across])
        now, flying = later[:, ~down], flying[~down]
        if not flying.size:
            break
    return places


def read_states(folder):
    with open(pathlib.Path(folder) / "samples.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    places = [[title.split(" ")[0] for title in header].index(name) for name in COLUMNS]  # titles have units
    return np.array([[float(row[place]) for row in rows] for place in places])


def calc_ellipse(places):
    """Mean (2), semi-axes of the 3-sigma ellipse (2), longest first, and its directions as columns (2, 2)."""
    values, vectors = np.linalg.eigh(np.cov(places))
    return places.mean(axis=1), 3 * np.sqrt(values[::-1]), vectors[:, ::-1]


if __name__ == "__main__":
    for folder in sys.argv[1:]:
        places = land(read_states(folder))
        up = np.isnan(places[0])
        mean, axes, _ = calc_ellipse(places[:, ~up])
        along, across = places[:, ~up].std(axis=1, ddof=1)
        print(f"{folder}: {places.shape[1] - up.sum()} land at {mean[0] / 1e3:.1f} km along, {mean[1] / 1e3:.2f} km across; sigma {along / 1e3:.2f} "
              f"and {across / 1e3:.2f} km; ellipse {axes[0] / 1e3:.1f} x {axes[1] / 1e3:.1f} km")
