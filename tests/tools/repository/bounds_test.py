#!/usr/bin/env python3
"""tools/bounds: what it takes for bounded and for recursion, and that kernel/BOUNDS.md is what the sources and the code have.

    bounds_test.py GOLDEN_FOLDER [unittest options]     without a folder, or "": the code is not looked at
"""

import importlib.machinery
import importlib.util
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
LOADER = importlib.machinery.SourceFileLoader("bounds", str(ROOT / "tools/bounds"))
sys.dont_write_bytecode = True  # nothing beside the script
bounds = importlib.util.module_from_spec(importlib.util.spec_from_loader("bounds", LOADER))
LOADER.exec_module(bounds)
FOLDER = sys.argv.pop(1) if len(sys.argv) > 1 else ""


class BoundsTest(unittest.TestCase):
    def check(self, text, bounded):
        loops = bounds.list_loops("void f() { " + text + " }")
        self.assertEqual([good for _, good in loops], bounded, text)

    def test_loops_over_ranges_and_counts_are_bounded(self):
        self.check("for (const Body& b : plan.bodies) use(b);", [True])
        self.check("for (int i = 0; i < count; ++i) { use(i); }", [True])
        self.check("for (std::size_t i = 0, n = 4; i < region.count && more; i += 2) use(i);", [True])
        self.check("for (std::size_t g = groups.size(); g-- > 0;) use(g);", [True])
        self.check("for (unsigned left = rows; left != 0; left &= left - 1) use(left);", [True])
        self.check("for (; looks > 0 && may_peak(left); --looks) { if (a == looks) break; }", [True])
        self.check("for (const T* p = first; p != end; ++p) for (int i = 0; i < 3; ++i) use(p, i);", [True, True])

    def test_a_loop_that_waits_is_not(self):
        self.check("while (high - low > 1) use();", [False])
        self.check("for (;;) {}", [False])
        self.check("do { use(); } while (more);", [False])
        self.check("for (double now = begin; now < end;) now = advance(now);", [False])

    def test_a_count_that_the_body_moves_is_not(self):
        self.check("for (int i = 0; i < n; ++i) { if (bad) --i; }", [False])
        self.check("for (int i = 0; i < n; ++i) i = 0;", [False])
        self.check("for (int i = 0; i < n; ++i) advance(&i);", [False])
        self.check("for (std::size_t g = n; g-- > 0;) g += 2;", [False])

    def test_a_limit_that_the_body_moves_is_not(self):
        self.check("for (int i = 0; i < n; ++i) ++n;", [False])
        self.check("for (int i = 0; i < region.count; ++i) region.count += 1;", [False])
        self.check("for (std::size_t g = n; g-- > least;) least = 0;", [False])

    def test_comments_and_texts_are_no_loops(self):
        self.check('// while (true)\n use("for (;;)"); /* do {} */', [])

    def test_recursion_is_found_through_pointers_too(self):
        listing = ("0000000000000010 <unlatch::step(int)>:\n  10:\tcall   20 <unlatch::a(int)>\n  15:\tjmp    30 <unlatch::step(int) [clone .cold]>\n"
                   "0000000000000020 <unlatch::a(int)>:\n  20:\tcall   *0x18(%rax)\n  24:\tmovslq (%rdx,%rax,4),%rax\n  28:\tjmp    *%rax\n"
                   "0000000000000030 <unlatch::step(int) [clone .cold]>:\n  30:\tjmp    12 <unlatch::step(int)+0x2>\n"
                   "0000000000000040 <unlatch::avx2::b(int)>:\n  40:\tjmp    20 <unlatch::a(int)>\n")
        calls, pointers = bounds.read_calls(listing)
        self.assertEqual(calls["unlatch::step(int)"], {"unlatch::a(int)"})
        self.assertEqual(pointers, {"unlatch::a(int)"})
        reached, cycle = bounds.find_cycle(calls, ["unlatch::step(int)"])
        self.assertEqual((len(reached), cycle), (2, None))
        calls["unlatch::a(int)"].add("unlatch::avx2::b(int)")
        self.assertEqual(bounds.find_cycle(calls, ["unlatch::step(int)"])[1], ["unlatch::a(int)", "unlatch::avx2::b(int)", "unlatch::a(int)"])

    def test_names_lose_what_all_have(self):
        self.assertEqual(bounds.shorten("int unlatch::avx2::factor<4>(unlatch::PlanData const&, double)"), "avx2::factor<4>")
        self.assertEqual(bounds.shorten("unlatch::(anonymous namespace)::project(unlatch::Instant const&)"), "project")

    def test_every_loop_of_a_step_is_bounded_by_constants_of_the_plan(self):
        self.assertTrue(bounds.check_loops(bounds.read_page()[0]))

    def test_nothing_of_a_step_calls_itself_and_pointers_lead_to_known_tables(self):
        program = Path(FOLDER) / "golden"
        if not FOLDER or not program.is_file():
            self.skipTest("no program of this build to look at")
        self.assertTrue(bounds.check_calls(program, bounds.read_page()[1]))


if __name__ == "__main__":
    unittest.main()
