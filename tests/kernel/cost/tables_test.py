#!/usr/bin/env python3
"""What tools/cost does with its tables and pages. The test of coefficients is skipped without scipy."""

import importlib.machinery
import importlib.util
import sys
import tempfile
import types
import unittest
from unittest import mock
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def load_cost():
    loader = importlib.machinery.SourceFileLoader("cost", str(ROOT / "tools/cost"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("cost", loader))
    loader.exec_module(module)
    return module


cost = load_cost()


class Tables(unittest.TestCase):
    def test_every_row_of_the_tables_is_read(self):
        for name in cost.TARGETS:
            _, units, coefficients = cost.read_table(name)
            text = (ROOT / f"kernel/cost/measured/{name}.cc").read_text(encoding="utf-8")
            self.assertEqual(text.count("{Primitive::k"), len(coefficients), name)
            self.assertEqual(set(units) - set(cost.list_units()), set(), name)
            self.assertEqual(set(primitive for primitive, _ in coefficients) - set(cost.UNITS_OF), set(), name)

    def test_primitives_and_units_are_asked_for_by_name(self):
        self.assertEqual(cost.read_only("round,readings:ReadFallingQuantities"), {"round": set(), "readings": {"ReadFallingQuantities"}})
        for wrong in ("rounds", "round:ReadFallingQuantities"):
            with self.assertRaises(cost.Failed):
                cost.read_only(wrong)

    def test_coefficients_are_above_all_counts_and_no_smaller_than_asked(self):
        try:
            import scipy  # noqa: F401  # pylint: disable=import-outside-toplevel,unused-import
        except ImportError:
            self.skipTest("no scipy")
        names, rows = ["One", "Bodies1", "Loads"], [([1, 2, 0], 120), ([1, 4, 0], 220), ([1, 1, 1], 75)]
        values, _ = cost.fit(names, rows, [1, 1, 1], {})
        self.assertAlmostEqual(values["One"], 20)
        self.assertAlmostEqual(values["Bodies1"], 50)
        self.assertAlmostEqual(values["Loads"], 5)
        values, _ = cost.fit(names, rows, [1, 1, 1], {"Bodies1": 60, "Loads": 30})
        self.assertAlmostEqual(values["Bodies1"], 60)
        self.assertAlmostEqual(values["Loads"], 30)
        self.assertNotIn("One", values)  # nothing is left for it

    def test_units_that_are_asked_for_get_what_the_others_leave_in_the_plans_that_have_them(self):
        names, rows = ["One", "Bodies1", "Loads"], [([1, 2, 0], 500), ([1, 4, 1], 250), ([1, 1, 2], 105)]
        values = cost.fit_rest(names, rows, [1, 1, 1], {"One": 20, "Bodies1": 50, "Loads": 0}, {"Loads"})
        self.assertEqual(list(values), ["Loads"])
        self.assertAlmostEqual(values["Loads"], 30)  # the first plan, which has none, asks for nothing

    def test_a_page_keeps_the_sections_of_other_targets(self):
        with tempfile.TemporaryDirectory() as name:
            arguments = types.SimpleNamespace(table=Path(name) / "page.md", long=10**9, budget=10**7, kept_plans=[])
            for target, count in (("cortex-m7", 90.0), ("x86-64", 80.0), ("cortex-m7", 70.0)):
                cost.write_page(target, {"boosters": cost.LargestStep(count, 100.0, ["1", "0", "0", "0", "0"])}, 5, 1, 0.5, {"boosters": 0}, arguments)
            sections = cost.read_sections(arguments.table)
            self.assertEqual(list(sections), ["x86-64", "cortex-m7"])
            self.assertIn("| boosters | 0 | 1 | 0 | 0 | 0 | 0 | 80 | 100 | 1.25 |", sections["x86-64"])
            self.assertIn("| boosters | 0 | 1 | 0 | 0 | 0 | 0 | 70 | 100 | 1.43 |", sections["cortex-m7"])

    def test_a_page_keeps_the_steps_of_plans_that_are_not_flown_beside_their_present_bounds(self):
        with tempfile.TemporaryDirectory() as name:
            arguments = types.SimpleNamespace(table=Path(name) / "page.md", long=10**9, budget=10**7, kept_plans=[], plans="*")
            step = cost.LargestStep(80.0, 100.0, ["1", "0", "0", "0", "0"])
            cost.write_page("x86-64", {"array": step, "boosters": step}, 5, 2, 0.5, {"array": 0, "boosters": 0}, arguments)
            arguments.kept_plans, arguments.plans = [types.SimpleNamespace(name="array")], "boosters"
            with mock.patch.object(cost, "calc_bounds", return_value=["88"]), mock.patch.object(cost, "count_contacts", return_value={"array": 0}):
                cost.write_page("x86-64", {"boosters": step._replace(count=50.0)}, 3, 1, 0.5, {"boosters": 0}, arguments)
            lines = cost.read_sections(arguments.table)["x86-64"]
            self.assertIn("| array | 0 | 1 | 0 | 0 | 0 | 0 | 80 | 88 | 1.10 |", lines)
            self.assertIn("| boosters | 0 | 1 | 0 | 0 | 0 | 0 | 50 | 100 | 2.00 |", lines)
            self.assertIn("Flown again later: `boosters`.", lines)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
