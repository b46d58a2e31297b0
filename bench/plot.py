#!/usr/bin/python3
"""Draws cost against n and lists the ratios to the other solvers, from the results of solve_bench in bench/results.

Usage: bench/plot.py    (reads results/solve_bench*.csv, writes results/solve.svg, solve.png and ratios.md)
"""
import csv
import math
import pathlib
import re

import matplotlib
matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "unlatch"  # the same file from the same numbers
import matplotlib.pyplot as plt

RESULTS = pathlib.Path(__file__).parent / "results"
SHAPES = ["star", "chain", "bintree", "random", "welded_chain"]
TITLES = {"star": "Star", "chain": "Chain", "bintree": "Binary tree", "random": "Random tree, mixed joints",
          "welded_chain": "Chain held at both ends"}
# who: label, colour, line, marker
STYLES = {
    "unlatch": ("unlatch, everything", "#c1121f", "-", "o"),
    "unlatch_factor_solve": ("unlatch, factor + solve", "#c1121f", "--", "o"),
    "textbook": ("textbook blocks (Eigen)", "#1d3557", "-", "s"),
    "eigen_sparse": ("Eigen SimplicialLDLT", "#457b9d", "-", "^"),
    "eigen_dense": ("Eigen dense LDLT", "#7fa7c4", "-", "v"),
    "simbody": ("Simbody 3.7", "#2a9d5c", "-", "D"),
    "simbody_solve": ("Simbody, solve alone", "#2a9d5c", "--", "D"),
    "mujoco": ("MuJoCo 2.2", "#e09f3e", "-", "P"),
}
# Targets: slower, faster, shape, n, at least. Solvers that start from given blocks are compared with factor + solve.
TARGETS = [
    ("mujoco", "unlatch", "star", 5, 11),
    ("mujoco", "unlatch_factor_solve", "star", 5, 11),
    ("textbook", "unlatch_factor_solve", "star", 5, 18),
    ("simbody", "unlatch", "chain", 64, 5),
    ("simbody_solve", "unlatch_factor_solve", "chain", 64, 5),
    ("textbook", "unlatch_factor_solve", "chain", 64, 14),
    ("textbook", "unlatch_factor_solve", "star", 1024, 38),
    ("textbook", "unlatch_factor_solve", "bintree", 1024, 26),
    ("textbook", "unlatch_factor_solve", "random", 1000, 12),
]
FITTED = ((8, 2048), (64, 2048))  # n: from a few bodies on, and from the size that fills all lanes
# shape, n, ns per body at most
PER_BODY = [("star", 100000, 60), ("bintree", 100000, 160), ("welded_chain", 512, 90)]


def read_times():
    """Returns {(who, shape): {n: ns per solve, the least of the repetitions}}."""
    times, rows = {}, []
    for path in sorted(RESULTS.glob("solve_bench*.csv")):
        lines = path.read_text().splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith("name,"))
        rows += csv.DictReader(lines[start:])
    for row in rows:
        match = re.fullmatch(r"solve/(\w+)/(\w+)/(\d+)_least", row["name"])
        if match:
            who, shape, n = match.groups()
            times.setdefault((who, shape), {})[int(n)] = float(row["cpu_time"])
    return times


def calc_exponent(curve, first, last):
    """Slope of log cost over log n from `first` to `last`, least squares; None for fewer than three points."""
    points = [(math.log(n), math.log(t)) for n, t in curve.items() if first <= n <= last]
    if len(points) < 3:
        return None
    mean_x = sum(x for x, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / sum((x - mean_x) ** 2 for x, _ in points)


def draw(times):
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans", "svg.fonttype": "none"})
    figure, grid = plt.subplots(2, 3, figsize=(8.6, 6.6), sharey=True)  # the width of a page: text keeps its size
    axes = list(grid.flat)
    for axis, shape in zip(axes, SHAPES):
        for who, (label, colour, line, marker) in STYLES.items():
            curve = sorted(times.get((who, shape), {}).items())
            if not curve:
                continue
            ours = who.startswith("unlatch")
            axis.loglog([n for n, _ in curve], [t / 1e3 for _, t in curve], line, color=colour, marker=marker,
                        markersize=3.5, markerfacecolor="white" if line == "--" else colour,
                        linewidth=1.8 if ours else 1.1, label=label, zorder=3 if ours else 2)
        axis.set_title(TITLES[shape])
        axis.set_xlabel("bodies")
        axis.grid(True, which="major", color="#dddddd", linewidth=0.6)
        axis.tick_params(which="minor", length=2)
        axis.spines[["top", "right"]].set_visible(False)
    for row in grid:
        row[0].set_ylabel("time of one acceleration solve, µs")
    labels = {}
    for axis in axes[:len(SHAPES)]:
        labels.update({label: handle for handle, label in zip(*axis.get_legend_handles_labels())})
    order = [label for label, *_ in STYLES.values() if label in labels]
    axes[-1].axis("off")
    axes[-1].legend([labels[label] for label in order], order, loc="center", frameon=False, handlelength=2.4)
    figure.tight_layout()
    figure.savefig(RESULTS / "solve.svg", metadata={"Date": None})
    figure.savefig(RESULTS / "solve.png", dpi=130)


def write_ratios(times):
    with open(RESULTS / "ratios.md", "w") as out:
        out.write("| | ns | peer, ns | ratio | target | |\n|---|---|---|---|---|---|\n")
        for slower, faster, shape, n, target in TARGETS:
            ours = times.get((faster, shape), {}).get(n)
            theirs = times.get((slower, shape), {}).get(n)
            if ours is None or theirs is None:
                continue
            ratio = theirs / ours
            verdict = "reached" if ratio >= target else f"short by a factor of {target / ratio:.1f}"
            out.write(f"| {shape} {n}: {slower} / {faster} | {ours:.0f} | {theirs:.0f} | {ratio:.1f} | {target} | {verdict} |\n")
        out.write("\n| ns per body | unlatch | unlatch_factor_solve | at most |\n|---|---|---|---|\n")
        for shape, n, limit in PER_BODY:
            cells = [times.get((who, shape), {}).get(n) for who in ("unlatch", "unlatch_factor_solve")]
            if None not in cells:
                out.write(f"| {shape} {n} | " + " | ".join(f"{t / n:.0f}" for t in cells) + f" | {limit} |\n")
        for first, last in FITTED:
            out.write(f"\n| exponent of cost in n, {first}…{last} | " + " | ".join(SHAPES) + " |\n"
                      + "|---" * (len(SHAPES) + 1) + "|\n")
            for who in STYLES:
                exponents = [calc_exponent(times.get((who, shape), {}), first, last) for shape in SHAPES]
                if any(exponents):
                    out.write(f"| {who} | " + " | ".join(f"{e:.2f}" if e else "–" for e in exponents) + " |\n")
        sizes = (5, 64, 512, 1000, 1024, 4096, 16384, 100000)
        out.write("\n| ns per body | " + " | ".join(map(str, sizes)) + " |\n" + "|---" * (len(sizes) + 1) + "|\n")
        for who in ("unlatch", "unlatch_factor_solve", "textbook"):
            for shape in SHAPES:
                curve = times.get((who, shape), {})
                cells = [f"{curve[n] / n:.0f}" if n in curve else "–" for n in sizes]
                if any(cell != "–" for cell in cells):
                    out.write(f"| {who}, {shape} | " + " | ".join(cells) + " |\n")


def main():
    times = read_times()
    draw(times)
    write_ratios(times)


if __name__ == "__main__":
    main()
