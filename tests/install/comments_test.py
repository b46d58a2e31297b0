#!/usr/bin/env python3
"""Comments of C and C++ files begin with their subject, not with a question word: comments_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = ("kernel", "hil", "library", "bridge", "tools", "bench", "tests")
QUESTION = re.compile(r"(?://+|/\*+)[!<]*\s*(?:What|Where|Whether|How|When|Who|Which|Why)\b")


def find_questions(text):
    """Returns the numbers of lines that begin a block of comment lines with a question word."""
    found, after_comment, inside = [], False, False
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        is_comment = inside or line.startswith(("//", "/*"))
        if is_comment and not after_comment and QUESTION.match(line):
            found.append(number)
        if line.startswith("/*") or inside:
            inside = "*/" not in line
        after_comment = is_comment
    return found


class CommentsTest(unittest.TestCase):
    def test_begin_with_their_subject(self):
        places = [f"{path.relative_to(ROOT)}:{number}" for module in MODULES for path in sorted((ROOT / module).rglob("*"))
                  if path.suffix in (".h", ".cc", ".c") for number in find_questions(path.read_text(encoding="utf-8"))]
        self.assertEqual(places, [], "begin with the subject:\n" + "\n".join(places))

    def test_the_search_finds_each_form(self):
        for text in ("// What it is.\n", "int a;\n  /// How it is.\n", "/* Why it is. */\n", "/** When it is,\n * and so on. */\n"):
            self.assertEqual(len(find_questions(text)), 1, text)
        for text in ("// The place.\n// Where it is.\n", "int what;  // What follows code.\n", "/* The place,\n// Who */\n", "// Whatever.\n"):
            self.assertEqual(find_questions(text), [], text)


if __name__ == "__main__":
    unittest.main()
