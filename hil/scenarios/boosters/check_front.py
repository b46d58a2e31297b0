#!/usr/bin/python3
"""Compares the Pareto front of synthesis-front.yaml with a grid of its design space, which no optimiser chooses:

    check_front.py BIN [--front FILE.csv] [--levels NOZZLE,OPENING,UNLIKE] [--json]

Flies the grid by `unlatch campaign`, and the front by `unlatch optimize` unless --front gives its front.csv. `missed`: the part of
the objectives' ranges by which some design of the grid that meets all constraints is better than each point of the front, at the
most (additive epsilon; Zitzler et al. 2003). `gained`: the same with front and grid exchanged.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import yaml

HERE = pathlib.Path(__file__).resolve().parent
PROBLEM = HERE / "synthesis-front.yaml"


def read_table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [{name.partition(" [")[0]: cell for name, cell in row.items()} for row in csv.DictReader(file)]


def call(*arguments, codes=(0, 1)):  # 1: requirements that are not met
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit(done.stderr)


def fly_grid(program, folder, levels):
    """Objectives (nozzle, N; unlike) of the designs of the grid that meet all constraints, and the number of designs."""
    problem = yaml.safe_load(PROBLEM.read_text(encoding="utf-8"))
    parameters = {}
    for (name, variable), count in zip(problem["variables"].items(), levels):
        low, high = variable["between"]
        parameters[name] = {"path": variable["path"], "levels": count, "uniform": {"min": low, "max": high}}
    (folder / "grid.yaml").write_text(yaml.safe_dump({"unlatch_campaign": 1, "name": "grid", "scenario": str(HERE / problem["scenario"]),
                                                     "set": problem["set"], "sampling": "grid", "parameters": parameters}), encoding="utf-8")
    call(program, "campaign", folder / "grid.yaml", "--out", folder / "grid")
    rows = read_table(folder / "grid/samples.csv")
    margins = [f"{name}.margin" for name in problem["constraints"]]
    met = [(float(row["nozzle"]), float(row["unlike"])) for row in rows if all(row[name] and float(row[name]) >= 0 for name in margins)]
    return met, len(rows)


def calc_epsilon(points, others, ranges):
    """The least part of the ranges by which `points` would have to be better, so that each of `others` is no better than one of them."""
    return max(min(max((point[0] - other[0]) / ranges[0], (other[1] - point[1]) / ranges[1]) for point in points) for other in others)


def find_front(points):
    """Points that no other dominates, by the first objective."""
    front, best = [], -1.0
    for nozzle, unlike in sorted(points, key=lambda point: (point[0], -point[1])):
        if unlike > best:
            front.append((nozzle, unlike))
            best = unlike
    return front


def compare(program, folder, levels, front_file=None):
    if front_file is None:
        call(program, "optimize", PROBLEM, "--out", folder / "front", codes=(0,))
        front_file = folder / "front/front.csv"
    front = [(float(row["nozzle"]), float(row["unlike"])) for row in read_table(front_file)]
    met, count = fly_grid(program, folder, levels)
    scanned = find_front(met)
    ranges = [max(point[i] for point in front + scanned) - min(point[i] for point in front + scanned) for i in (0, 1)]
    return {"designs": count, "met": len(met), "front": front, "scanned": scanned, "grid": met,
            "missed": calc_epsilon(front, scanned, ranges), "gained": calc_epsilon(scanned, front, ranges)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--front", type=pathlib.Path)
    parser.add_argument("--levels", default="25,3,41")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = compare(options.bin / "unlatch", pathlib.Path(folder), [int(level) for level in options.levels.split(",")], options.front)
    if options.json:
        print(json.dumps(found))
    else:
        print(f"grid: {found['met']} of {found['designs']} designs meet all constraints, {len(found['scanned'])} of them on its front; "
              f"missed by the front of {len(found['front'])} points: {found['missed']:.2%}, gained: {found['gained']:.2%} of the ranges")


if __name__ == "__main__":
    main()
