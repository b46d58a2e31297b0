#!/usr/bin/env python3
"""tools/targets finds differences and heaps: targets_test.py"""

import importlib.machinery
import importlib.util
import sys
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "tools/targets"
LOADER = importlib.machinery.SourceFileLoader("targets", str(SCRIPT))
sys.dont_write_bytecode = True  # nothing beside the script
targets = importlib.util.module_from_spec(importlib.util.spec_from_loader("targets", LOADER))
sys.modules["targets"] = targets
LOADER.exec_module(targets)

GOLDEN = {"kernel": {"boosters": {"100": "aa", "200": "bb", "outputs": "cc", "events": "4"}}}
WHOLE = ["boosters 100 aa", "boosters 200 bb", "boosters outputs cc", "boosters events 4"]


class TargetsTest(unittest.TestCase):
    def compare(self, lines, ticks=200):
        return targets.compare(lines, [("boosters", "kernel", None, ticks)], GOLDEN)

    def test_equal_hashes_are_counted(self):
        self.assertEqual(self.compare(WHOLE), 4)

    def test_of_a_flight_that_is_cut_short_only_its_ticks_are_compared(self):
        self.assertEqual(self.compare(["boosters 100 aa", "boosters outputs XX"], 100), 1)

    def test_a_difference_is_named(self):
        with self.assertRaisesRegex(targets.Failed, "boosters differs at 200: golden bb, here XX"):
            self.compare([WHOLE[0], "boosters 200 XX", *WHOLE[2:]])

    def test_a_line_that_is_missing_is_a_difference(self):
        with self.assertRaisesRegex(targets.Failed, "boosters differs at 100: golden aa, here None"):
            self.compare(["fault"])

    def test_a_flight_without_golden_hash_is_refused(self):
        with self.assertRaisesRegex(targets.Failed, "no hash was compared"):
            targets.compare(["new 100 aa"], [("new", "kernel", None, 100)], GOLDEN)

    def test_a_heap_in_the_link_map_is_found(self):
        for line in (" .text.malloc  0x00001234  0x10 libc.a(malloc.o)", " .text  0x0 0x1 malloc", "   0x1234   _sbrk",
                     "   0x00001234   operator_new _Znwj", " 0x1 free", " 0x1 _ZdlPvj"):
            self.assertTrue(targets.HEAP.search(line), line)
        for line in (" .text._ZN7unlatch4freeEv", " freedoms", " memcpy"):
            self.assertFalse(targets.HEAP.search(line), line)

    def test_recursion_is_found_and_calls_through_registers_are_counted(self):
        listing = ("00000010 <a>:\n  10:\tbl\t20 <b>\n  14:\tblx\tr3\n  18:\tbx\tlr\n  1a:\tb.n\t10 <a>\n"
                   "00000020 <b>:\n  20:\tbeq.n\t30 <c+0x4>\n  24:\tbl\t40 <d>\n"
                   "0000002c <c>:\n  2c:\tbl\t20 <b>\n00000040 <d>:\n  40:\tbx\tlr\n")
        calls, indirect = targets.read_calls(listing)
        self.assertEqual(calls, {"a": {"b"}, "b": {"c", "d"}, "c": {"b"}, "d": set()})
        self.assertEqual(indirect, {"a": 1})
        self.assertEqual(targets.find_recursion(calls), ["b", "c"])
        self.assertEqual(targets.find_recursion({"a": {"b"}, "b": {"d"}, "d": set()}), [])
        self.assertEqual(targets.find_recursion({"a": {"a"}}), ["a"])


if __name__ == "__main__":
    unittest.main()
