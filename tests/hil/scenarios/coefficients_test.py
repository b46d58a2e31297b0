#!/usr/bin/env python3
"""Random flights with forces of the air by tables and expressions, against tests/references/coefficients_reference.py (DOP853 at
3e-14). Run by ctest:

    coefficients_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import sys

from processes import SOURCE, UNLATCH, ProcessTest, main

REFERENCE = json.loads((SOURCE / "tests/data/coefficients.json").read_text())
RELATIVE = 1e-9  # of the value's scale in a flight
SCALES = {"altitude": 40e3, "latitude": 1, "longitude": 1, "north": 1500, "east": 1500, "down": 1500, "roll": 1, "pitch": 1, "yaw": 1, "p": 0.5,
          "q": 0.5, "r": 0.5, "place_x": 3e6, "place_y": 3e6, "place_z": 3e6, "alpha": 1, "beta": 1}


CASES = {name: case for name, case in REFERENCE.items() if name != "about"}


class CoefficientsTest(ProcessTest):
    def measure(self, case, *options):
        """The largest error of a flight, of its value's scale, and whose it is."""
        file = self.folder / "flight.yaml"
        file.write_text(json.dumps(case["scenario"]))
        report = self.run_json(UNLATCH, "run", file, "--outputs", "quantity.*@1", *options)
        self.assertEqual(report["status"], "ok")
        table = report["outputs"][0]
        self.assertAlmostEqual(table["t"][-1], case["scenario"]["step"]["until"], delta=1e-9)
        names = [column["name"].removeprefix("quantity.") for output in table["outputs"] for column in output["columns"]]
        found = dict(zip(names, table["rows"][-1], strict=True))
        return max((abs(found[name] - value) / SCALES[name], name) for name, value in case["end"].items())

    def test_flights_by_tables_and_expressions_go_as_their_references_do(self):
        self.assertGreater(len(CASES), 4)
        for name, case in CASES.items():
            error, whose = self.measure(case)
            print(f"{name}: {error:.1e} ({whose})", file=sys.stderr)
            with self.subTest(name):
                self.assertLess(error, RELATIVE, whose)

    def test_smooth_tables_keep_the_fourth_order_of_the_method(self):
        for name, case in CASES.items():
            coarse, fine = (self.measure(case, "--set", f"step.dt={dt}")[0] for dt in (0.01, 0.005))
            with self.subTest(name):
                self.assertGreater(coarse, 12 * fine)


if __name__ == "__main__":
    main()
