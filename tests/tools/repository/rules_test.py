#!/usr/bin/env python3
"""tools/rules: rules_test.py [unittest options]     with RULES_ALL=1 also all sources of the stepping part (minutes)"""

import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
LOADER = importlib.machinery.SourceFileLoader("rules_tool", str(ROOT / "tools/rules"))
sys.dont_write_bytecode = True  # nothing beside the script
rules = importlib.util.module_from_spec(importlib.util.spec_from_loader("rules_tool", LOADER))
LOADER.exec_module(rules)

PAGE = """
| rule | check | files that deviate | why |
|---|---|---|---|
| 8.2.5 | `casts` | [a.h](simd/a.h) | reasons |
| 9.6.1 | `jumps` | none | |
| 11.3.1 | `arrays` | any file | reasons |
"""


class RulesTest(unittest.TestCase):
    def compare(self, *found, whole=True):
        return rules.compare(set(found), rules.read_page(PAGE), whole)

    def test_deviations_that_are_listed_are_right(self):
        self.assertEqual(self.compare(("casts", "simd/a.h", 3), ("arrays", "step/b.cc", 4)), [])

    def test_a_file_that_is_not_listed_is_found(self):
        self.assertIn("kernel/step/b.cc:7 breaks the rule of jumps", self.compare(("casts", "simd/a.h", 3), ("arrays", "c.h", 1), ("jumps", "step/b.cc", 7))[0])
        self.assertIn("kernel/step/b.cc:8 breaks the rule of casts", self.compare(("casts", "step/b.cc", 8), whole=False)[0])

    def test_a_file_that_is_listed_without_a_finding_is_found(self):
        self.assertEqual(len(self.compare(("arrays", "c.h", 1))), 1)
        self.assertEqual(len(self.compare(("casts", "simd/a.h", 3))), 1)

    def test_the_page_lists_files_that_exist(self):
        allowed = rules.read_page(rules.PAGE.read_text(encoding="utf-8"))
        self.assertGreater(len(allowed), 20)
        for files in allowed.values():
            for name in files - {rules.EVERYWHERE}:
                self.assertTrue((ROOT / "kernel" / name).is_file(), name)

    @unittest.skipUnless(os.environ.get("RULES_ALL"), "without RULES_ALL=1")
    def test_the_stepping_part_keeps_the_rules(self):
        done = subprocess.run([ROOT / "tools/rules", "--jobs", "2"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    if os.environ.get("RULES_ALL") and not shutil.which("clang-tidy"):
        print("clang-tidy is missing: tools/setup long")
        sys.exit(77)  # skipped, as ctest knows it
    unittest.main()
