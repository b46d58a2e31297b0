#!/usr/bin/env python3
"""tools/coverage: coverage_test.py BIN [unittest options]     with COVERAGE_ALL=1 also the coverage itself (half an hour);
BIN: a finished build's programs"""

import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
LOADER = importlib.machinery.SourceFileLoader("coverage_tool", str(ROOT / "tools/coverage"))
sys.dont_write_bytecode = True  # nothing beside the script
coverage = importlib.util.module_from_spec(importlib.util.spec_from_loader("coverage_tool", LOADER))
LOADER.exec_module(coverage)

PAGE = """
| file | functions | why |
|---|---|---|
| [step/a.cc](step/a.cc) | `get_name` | reasons |
"""


def count(*lines):
    """A file whose lines have these counts, number, count and branches each, all of one function."""
    file = coverage.File()
    for number, times, taken in lines:
        branches = [{"count": one, "throw": False} for one in taken] + [{"count": 0, "throw": True}]
        file.add({"line_number": number, "count": times, "branches": branches}, "get_name")
    return file


class CoverageTest(unittest.TestCase):
    def test_a_line_that_is_not_run_is_found_unless_its_function_is_listed(self):
        listed = coverage.read_page(PAGE)
        self.assertEqual(listed, {("step/a.cc", "get_name")})
        self.assertEqual(coverage.compare({"step/a.cc": count((3, 0, []))}, listed), [])
        found = coverage.compare({"step/a.cc": count((3, 0, [])), "step/b.cc": count((4, 0, []))}, listed)
        self.assertEqual(len(found), 1)
        self.assertIn("kernel/step/b.cc:4, in get_name, is run by no test", found[0])

    def test_a_function_that_is_listed_and_runs_is_found(self):
        self.assertIn("whose lines are all run", coverage.compare({"step/a.cc": count((3, 1, []))}, coverage.read_page(PAGE))[0])

    def test_a_line_and_a_branch_count_once_however_many_codes_a_template_makes(self):
        file = count((3, 0, []), (3, 2, [0, 2]), (3, 1, [1, 0]), (4, 1, [1, 0]))
        self.assertEqual(file.list_missing(), [])
        self.assertEqual(file.count_branches(), (3, 4))
        self.assertEqual(file.list_not_taken(), [4])

    def test_names_are_without_templates_and_parameters(self):
        self.assertEqual(coverage.get_short_name("unlatch::(anonymous namespace)::Rows<int, A<b> >::list(int) const"), "Rows::list")

    def test_the_page_lists_functions_that_there_are(self):
        listed = coverage.read_page(coverage.PAGE.read_text(encoding="utf-8"))
        self.assertGreater(len(listed), 5)
        for path, name in listed:
            self.assertIn(name.split("::")[-1] + "(", (ROOT / "kernel" / path).read_text(encoding="utf-8"), path)

    @unittest.skipUnless(os.environ.get("COVERAGE_ALL"), "without COVERAGE_ALL=1")
    def test_the_kernels_own_tests_run_the_stepping_part(self):
        done = subprocess.run([ROOT / "tools/coverage", "--bin", BIN], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, (done.stdout + done.stderr)[-5000:])


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    if os.environ.get("COVERAGE_ALL") and not shutil.which("gcov"):
        print("gcov is missing: tools/setup long")
        sys.exit(77)  # skipped, as ctest knows it
    unittest.main()
