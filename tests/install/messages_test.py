#!/usr/bin/env python3
"""Messages with a number and its noun are right for 1 too, by count() of hil/scenario/text/count.h: messages_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = ("kernel", "hil", "library", "bridge", "tools")
NOUN = r" (?:[a-z]+ )?([a-z]+s)\b"
PATTERN = re.compile(r"%[0-9*]*(?:ll|l|z)?[diu]" + NOUN)
TEXT = re.compile(r"to_string\((?!k[A-Z])(?:[^()\"]|\([^()]*\))*\)\s*\+\s*\"" + NOUN)
# Words with an s that are no nouns in the plural, and units.
OTHERS = {"s", "ms", "us", "ns", "is", "was", "has", "its", "as", "this", "differs", "fails", "follows", "lies", "takes", "needs", "stays",
          "outside", "across", "shapes"}  # "pair 1 of shapes"
# Numbers that are never 1, each with its reason.
NEVER_ONE = {
    "hil/session/realtime/preflight.cc: bytes": "a limit of memory",
    "hil/scenario/language/scenario_sources.cc: bytes": "a limit",
    "hil/run/notices/step_notices.cc: steps": "of all, after some dozen",
    "kernel/compile/validate.cc: bodies": "more than the most",
    "kernel/elements/kinds/contact/rigid_contact_model.cc: pairs": "more than the most",
    "tools/unlatch/check/command_check.cc: corners": "a constant, eight",
    "tools/watch/screen.cc: times": "more than once",
}


def find_plurals(text):
    """The nouns, with the numbers of their lines."""
    joined = re.sub(r"\"\s*\n\s*\"", "", text)  # a literal in several pieces
    return [match[1] for expression in (PATTERN, TEXT) for match in expression.finditer(joined) if match[1] not in OTHERS]


class MessagesTest(unittest.TestCase):
    def test_a_number_and_its_noun_go_through_count(self):
        found = {f"{path.relative_to(ROOT)}: {noun}" for module in MODULES for path in sorted((ROOT / module).rglob("*"))
                 if path.suffix in (".h", ".cc") for noun in find_plurals(path.read_text(encoding="utf-8"))}
        self.assertEqual(sorted(found - set(NEVER_ONE)), [], "write count(number, \"sample\")")
        self.assertEqual(sorted(set(NEVER_ONE) - found), [], "no longer there")

    def test_the_search_finds_each_form(self):
        for text in ('"%lld samples"', '"%zu mass points"', '"of %d other runs fail"', 'std::to_string(a.size()) + " rows"',
                     'std::to_string(n) +\n    " shell elements"'):
            self.assertEqual(len(find_plurals(text)), 1, text)
        for text in ('"%lld of %s"', '"%d us"', 'to_string(tick) + " is over"', 'std::to_string(kMost) + " bodies"', '"%.3f samples"'):
            self.assertEqual(find_plurals(text), [], text)


if __name__ == "__main__":
    unittest.main()
