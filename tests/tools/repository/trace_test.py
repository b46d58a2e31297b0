#!/usr/bin/env python3
"""tools/trace: every requirement of the stepping part has tests, and these exist: trace_test.py"""

import importlib.machinery
import importlib.util
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
LOADER = importlib.machinery.SourceFileLoader("trace_tool", str(ROOT / "tools/trace"))
sys.dont_write_bytecode = True  # nothing beside the script
trace = importlib.util.module_from_spec(importlib.util.spec_from_loader("trace_tool", LOADER))
LOADER.exec_module(trace)

KNOWN = {"Suite.Works": Path("a.cc"), "Suite.*Works": Path("b.txt")}


class TraceTest(unittest.TestCase):
    def find(self, text):
        return trace.find_mistakes(trace.read_requirements(text), KNOWN)

    def test_a_requirement_with_a_test_is_right(self):
        self.assertEqual(self.find("# Things\nA-01 It works.\n  Suite.Works\nA-02 All of it.\n  Suite.* Suite.PortWorks\n"), [])

    def test_a_requirement_without_a_test_is_found(self):
        self.assertEqual(self.find("# Things\nA-01 It works.\nA-02 It runs.\n  Suite.Works\n"), ["A-01: no test proves it"])

    def test_a_test_that_does_not_exist_is_found(self):
        self.assertEqual(self.find("# Things\nA-01 It works.\n  Suite.Work Other.*\n"),
                         ["A-01: there is no test Suite.Work", "A-01: there is no test Other.*"])

    def test_a_number_that_is_there_twice_is_refused(self):
        with self.assertRaisesRegex(ValueError, "line 3: A-01 is there twice"):
            self.find("# Things\nA-01 It works.\nA-01 It works.\n")

    def test_a_line_that_is_no_requirement_is_refused(self):
        with self.assertRaisesRegex(ValueError, "line 2: neither"):
            self.find("# Things\nIt works\n")

    def test_the_page_is_what_the_requirements_and_the_tests_give(self):
        done = subprocess.run([ROOT / "tools/trace", "--check"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
