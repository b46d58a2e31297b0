#!/usr/bin/env python3
"""tools/determinism finds differences: determinism_test.py"""

import importlib.machinery
import importlib.util
import sys
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "tools/determinism"
LOADER = importlib.machinery.SourceFileLoader("determinism", str(SCRIPT))
sys.dont_write_bytecode = True  # nothing beside the script
determinism = importlib.util.module_from_spec(importlib.util.spec_from_loader("determinism", LOADER))
sys.modules["determinism"] = determinism
LOADER.exec_module(determinism)

GOLDEN = {"kernel": {"boosters": {"100": "aa", "200": "bb", "outputs": "cc"}, "array": {"100": "dd"}}}


class DeterminismTest(unittest.TestCase):
    def expect(self, lines, *words):
        found = {"kernel": determinism.parse_hashes("\n".join(lines))}
        difference = determinism.find_difference(found, GOLDEN)
        if not words:
            self.assertIsNone(difference)
        for word in words:
            self.assertIn(word, difference)

    def test_equal_hashes_agree(self):
        self.expect(["array 100 dd", "boosters 100 aa", "boosters 200 bb", "boosters outputs cc"])

    def test_the_first_tick_that_differs_is_named(self):
        self.expect(["array 100 dd", "boosters 100 aa", "boosters 200 XX", "boosters outputs YY"], "boosters", "tick 200", "XX")

    def test_outputs_count(self):
        self.expect(["array 100 dd", "boosters 100 aa", "boosters 200 bb", "boosters outputs YY"], "outputs")

    def test_a_run_that_ends_early_differs(self):
        self.expect(["array 100 dd", "boosters 100 aa", "boosters outputs cc"], "tick 200", "None")

    def test_a_model_without_golden_hash_is_refused(self):
        self.expect(["array 100 dd", "boosters 100 aa", "boosters 200 bb", "boosters outputs cc", "new 100 ee"], "new", "--update")

    def test_a_model_that_was_not_run_is_missed(self):
        self.expect(["boosters 100 aa", "boosters 200 bb", "boosters outputs cc"], "array", "not run")


if __name__ == "__main__":
    unittest.main()
