#!/usr/bin/python3
"""Where the capsules of a campaign land: landing.py FOLDER...

FOLDER has the samples.csv of landing.yaml, with the capsule's state at the end of the burn. From there a point mass flies in the
central field and, ballistically, in an exponential atmosphere that does not turn, down to the ground; RK4 with STEP. It prints the
standard deviations along and across the track, the semi-axes of the 3-sigma ellipse, and the state of entry at a height of 100 km.
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
ENTRY = 100e3                                     # m, the height at which entry begins by convention
COLUMNS = [f"output.capsule.{name}.final" for name in ("x", "y", "z", "vx", "vy", "vz")]


def calc_rates(states):
    """Of states (6, n): positions from the Earth's centre, velocities."""
    place, velocity = states[:3], states[3:]
    distance = np.linalg.norm(place, axis=0)
    drag = DENSITY * np.exp(-(distance - EARTH) / SCALE_HEIGHT) * np.linalg.norm(velocity, axis=0) / (2 * BALLISTIC)
    return np.concatenate([velocity, -MU * place / distance**3 - drag * velocity])


def descend(states, height):
    """States (6, n), from the Earth's centre, at which states (6, n) as landing.yaml gives them come down to a height. One that is
    still above it after LONGEST has nan."""
    now = np.array(states, dtype=float)
    now[0] += ORBIT
    there = np.full_like(now, np.nan)
    flying = np.arange(now.shape[1])
    for _ in range(round(LONGEST / STEP)):
        k1 = calc_rates(now)
        k2 = calc_rates(now + STEP / 2 * k1)
        k3 = calc_rates(now + STEP / 2 * k2)
        k4 = calc_rates(now + STEP * k3)
        later = now + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        before, after = (np.linalg.norm(s[:3], axis=0) - EARTH - height for s in (now, later))
        down = after <= 0
        if down.any():
            share = before[down] / (before[down] - after[down])
            there[:, flying[down]] = now[:, down] + share * (later[:, down] - now[:, down])
        now, flying = later[:, ~down], flying[~down]
        if not flying.size:
            break
    return there


def locate(states):
    """Places (2, n) on the ground below states, m along and across the track."""
    along = np.arctan2(-states[2], states[0])  # the orbit goes to -z
    across = np.arcsin(states[1] / np.linalg.norm(states[:3], axis=0))
    return EARTH * np.array([along, across])


def land(states):
    """Places of landing (2, n)."""
    return locate(descend(states, 0))


def calc_entry(states):
    """Speed, m/s, angle of the flight path below the horizon, rad, and place along and across the track, m, at ENTRY: (4, n)."""
    there = descend(states, ENTRY)
    speed = np.linalg.norm(there[3:], axis=0)
    rise = (there[:3] * there[3:]).sum(axis=0) / np.linalg.norm(there[:3], axis=0)
    return np.array([speed, np.arcsin(-rise / speed), *locate(there)])


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
        states = read_states(folder)
        places = land(states)
        up = np.isnan(places[0])
        mean, axes, _ = calc_ellipse(places[:, ~up])
        along, across = places[:, ~up].std(axis=1, ddof=1)
        print(f"{folder}: {places.shape[1] - up.sum()} land at {mean[0] / 1e3:.1f} km along, {mean[1] / 1e3:.2f} km across; sigma {along / 1e3:.2f} "
              f"and {across / 1e3:.2f} km; ellipse {axes[0] / 1e3:.1f} x {axes[1] / 1e3:.1f} km")
        entry = calc_entry(states)[:, ~up]
        (speed, angle, far, _), sigma = entry.mean(axis=1), entry.std(axis=1, ddof=1)
        print(f"  at {ENTRY / 1e3:.0f} km: {speed:.1f} m/s (sigma {sigma[0]:.2f}), {math.degrees(angle):.3f} deg below the horizon (sigma "
              f"{math.degrees(sigma[1]):.3f}), {far / 1e3:.0f} km along (sigma {sigma[2] / 1e3:.1f}), sigma {sigma[3] / 1e3:.2f} km across")
