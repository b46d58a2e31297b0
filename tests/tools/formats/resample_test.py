#!/usr/bin/env python3
"""Facts about `unlatch resample`: tables from scattered points, their errors, and what is refused. Run by ctest like tools_test.py."""

import csv
import json
import math

from processes import UNLATCH, ProcessTest, main

# Points of two functions over two axes, of which the first four are the corners of the hull: rows of a lattice that is shifted from
# row to row (no two distances alike).
COUNT, GOLDEN = 60, (math.sqrt(5) - 1) / 2
NODE = 1e-12  # of a value: rounding


def cx(mach, alpha):
    return 0.4 + 0.2 * math.exp(-(((mach - 1.1) / 0.3)**2)) + 0.001 * alpha**2


def plane(mach, alpha):
    return 3 - 0.5 * mach + 0.02 * alpha


def list_points(count=COUNT):
    points = [(0.5, -10.0), (0.5, 10.0), (2.0, -10.0), (2.0, 10.0)]
    for i in range(1, count - 3):
        points.append((0.5 + 1.5 * (i / (count - 3)), -10 + 20 * ((i * GOLDEN) % 1)))
    return points


def write_points(points, functions=(cx, plane)):
    names = ", ".join(function.__name__ for function in functions)
    return f"# a database\nmach, alpha [deg], {names}\n" + "".join(",".join(map(repr, (*at, *(f(*at) for f in functions)))) + "\n" for at in points)


class ResampleTest(ProcessTest):
    AXES = ("--axis", "mach=0.5:2:16", "--axis", "alpha=-10,-5,0,5,10")

    def resample(self, text, *options, axes=AXES, code=0):
        points, table = self.folder / "points.csv", self.folder / "table.csv"
        points.write_text(text)
        return self.run_ok(UNLATCH, "resample", points, *axes, "--out", table, "--force", *options, code=code)

    def resample_json(self, text, *options, axes=AXES):
        return json.loads(self.resample(text, "--json", "-", *options, axes=axes).stdout)

    def read_table(self):
        lines = [line for line in (self.folder / "table.csv").read_text().splitlines() if not line.startswith("#")]
        rows = list(csv.reader(lines))
        return [name.strip() for name in rows[0]], [[float(cell) for cell in row] for row in rows[1:]]

    def test_a_table_has_the_values_of_a_plane_and_is_near_a_curve(self):
        result = self.resample_json(write_points(list_points()))
        names, rows = self.read_table()
        self.assertEqual(names, ["mach", "alpha [deg]", "cx", "plane"])
        self.assertEqual(len(rows), 16 * 5)
        self.assertEqual([row[:2] for row in rows[:6]], [[0.5, -10], [0.5, -5], [0.5, 0], [0.5, 5], [0.5, 10], [0.6, -10]])
        self.assertLess(max(abs(row[3] - plane(*row[:2])) for row in rows), 1e3 * NODE)  # a polynomial of degree 1 is exact
        truly = [abs(row[2] - cx(*row[:2])) for row in rows]
        errors = result["columns"]["cx"]
        self.assertLess(max(truly), 5 * errors["left_out"]["greatest"] + errors["corners_left_out"]["greatest"])
        self.assertLess(errors["left_out"]["greatest"], 0.1)
        self.assertGreater(errors["left_out"]["greatest"], 1e-4)  # it is no estimate of 0
        self.assertEqual(errors["corners_left_out"]["points"], 4)
        self.assertEqual(errors["left_out"]["points"] + 4, result["points"])

    def test_errors_are_those_of_scipy(self):
        try:
            import numpy as np
            from scipy.interpolate import RBFInterpolator
        except ImportError:
            self.skipTest("no SciPy")
        points = list_points()
        at = np.array([((m - 0.5) / 1.5, (a + 10) / 20) for m, a in points])
        values = np.array([cx(*p) for p in points])
        for radial, kernel in (("smooth", "cubic"), ("linear", "linear")):
            for neighbours in (None, 20):
                options = ("--radial", radial, *(("--neighbours", neighbours) if neighbours else ()))
                errors = self.resample_json(write_points(points), *options)["columns"]["cx"]
                _, rows = self.read_table()
                there = np.array([((m - 0.5) / 1.5, (a + 10) / 20) for m, a, *_ in rows])
                expected = RBFInterpolator(at, values, kernel=kernel, degree=1, neighbors=neighbours)(there)
                self.assertLess(np.abs(expected - [row[2] for row in rows]).max(), 1e-11)
                left_out = []
                for i in range(4, len(points)):
                    others = np.arange(len(points)) != i
                    left_out.append(abs(RBFInterpolator(at[others], values[others], kernel=kernel, degree=1, neighbors=neighbours)(at[i:i + 1])[0] - values[i]))
                self.assertAlmostEqual(errors["left_out"]["greatest"], max(left_out), delta=1e-10)
                self.assertAlmostEqual(errors["left_out"]["rms"], math.sqrt(sum(e * e for e in left_out) / len(left_out)), delta=1e-10)

    def test_errors_of_the_table_at_the_points_are_those_of_its_interpolation(self):
        errors = self.resample_json(write_points(list_points()))["columns"]["cx"]
        _, rows = self.read_table()
        values = {(row[0], row[1]): row[2] for row in rows}
        machs, alphas = sorted({m for m, _ in values}), sorted({a for _, a in values})
        greatest = 0
        for m, a in list_points():
            i = min(max(k for k, mach in enumerate(machs) if mach <= m), len(machs) - 2)
            j = min(max(k for k, alpha in enumerate(alphas) if alpha <= a), len(alphas) - 2)
            u, v = (m - machs[i]) / (machs[i + 1] - machs[i]), (a - alphas[j]) / (alphas[j + 1] - alphas[j])
            found = sum((u if p else 1 - u) * (v if q else 1 - v) * values[machs[i + p], alphas[j + q]] for p in (0, 1) for q in (0, 1))
            greatest = max(greatest, abs(found - cx(m, a)))
        self.assertAlmostEqual(errors["table_linear"]["greatest"], greatest, delta=NODE)
        self.assertLess(errors["table_smooth"]["greatest"], errors["table_linear"]["greatest"])

    def test_a_scenario_reads_the_table(self):
        self.resample(write_points(list_points()))
        (self.folder / "dart.yaml").write_text("""unlatch: 1
name: dart
step: {dt: 10 ms, until: 1 s}
bodies: {dart: {mass: 2 kg, inertia: [1, 1, 1]}}
tables: {axial: {file: table.csv, column: cx, axes: {mach: {ends: notice}, alpha: {}}, interpolation: smooth}}
quantities: {c: {expression: "axial(1.1, 0 deg)"}}
""")
        self.run_ok(UNLATCH, "check", self.folder / "dart.yaml")

    def test_what_lies_outside_of_the_hull_is_refused_or_takes_the_nearest_value_of_it(self):
        wide = ("--axis", "mach=0.5,1,2", "--axis", "alpha=-10,0,12")
        refused = self.resample(write_points(list_points()), axes=wide, code=2).stderr
        self.assertIn("outside of the points' hull: 3 entries of the table, the first at mach 0.5, alpha 12, the farthest by 0.1", refused)
        result = self.resample_json(write_points(list_points()), "--outside", "nearest", axes=wide)
        self.assertEqual(result["outside"], 3)
        self.assertAlmostEqual(result["farthest"], 0.1, delta=NODE)
        _, rows = self.read_table()
        for row in rows:
            self.assertAlmostEqual(row[3], plane(row[0], min(row[1], 10)), delta=1e3 * NODE)
        self.assertIn("Outside of the points' hull: 3 entries of 9", (self.folder / "table.csv").read_text())

    def test_mistakes_are_refused_with_their_place(self):
        points = list_points()
        text = write_points(points)
        for wrong, said in ((text + text.splitlines()[10] + "\n", "this point stands in line 11 already"), (text.replace("\n0.5,10.0,", "\n0.5,nan,", 1), "line 4, column 5: 'nan' is not finite"),
                            (text + "1,2,3\n", "line 63"), ("mach, alpha [deg], cx\n" + "".join(f"{i},{2 * i},1\n" for i in range(9)), "lie on one line"),
                            ("mach, alpha [deg], cx\n" + "".join(f"1,{i},1\n" for i in range(9)), "'mach' is 1 at all points"),
                            ("mach, alpha, cx\n0,0,1\n1,0,1\n0,1,1\n", "it has 3 points"), ("mach, alpha\n" + "".join(f"{i},{i * i}\n" for i in range(9)), "all its columns are axes"),
                            ("mach, beta, cx\n1,2,3\n", "there is no column 'alpha'; it has mach, beta, cx")):
            self.assertIn(said, self.resample(wrong, code=2).stderr)
        for axes, said in ((("--axis", "mach"), "neither NAME=KNOT"), (("--axis", "mach=1"), "two knots"), (("--axis", "mach=2,1"), "above the one before"),
                           (("--axis", "mach=0:1:1.5"), "whole number"), (("--axis", "mach=0,one"), "'one' is not a number"), (("--axis", "mach=0,1", "--axis", "mach=0,1"), "stands twice")):
            self.assertIn(said, self.resample(text, axes=axes, code=2).stderr)
        self.assertIn("at least 4", self.resample(text, "--neighbours", "3", code=2).stderr)
        for knots, said in ((3000, "the grid has more than 4194304 entries; fewer knots"), (700, "and the tables of a scenario at most 16777216; fewer knots")):
            self.assertIn(said, self.resample(text, axes=("--axis", f"mach=0.5:2:{knots}", "--axis", f"alpha=-10:10:{knots}"), code=2).stderr)
        self.run_ok(UNLATCH, "resample", self.folder / "none.csv", *self.AXES, "--out", "-", code=2)

    def test_an_existing_file_stays(self):
        (self.folder / "points.csv").write_text(write_points(list_points()))
        (self.folder / "table.csv").write_text("mine")
        done = self.run_ok(UNLATCH, "resample", self.folder / "points.csv", *self.AXES, "--out", self.folder / "table.csv", code=2)
        self.assertIn("--force", done.stderr)
        self.assertEqual((self.folder / "table.csv").read_text(), "mine")


if __name__ == "__main__":
    main()
