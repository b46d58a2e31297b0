#!/usr/bin/env python3
"""Comments of C and C++ files begin with their subject, not with a question word or with "Of": comments_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = ("kernel", "hil", "library", "bridge", "tools", "bench", "tests")
WITHOUT_SUBJECT = re.compile(r"(?://+|/\*+)[!<]*\s*(?:What|Where|Whether|How|When|Who|Which|Why|Of)\b")


def find_without_subject(text):
    """Returns the numbers of lines that begin a block of comment lines with a question word or with "Of"."""
    found, after_comment, inside = [], False, False
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        is_comment = inside or line.startswith(("//", "/*"))
        if is_comment and not after_comment and WITHOUT_SUBJECT.match(line):
            found.append(number)
        if line.startswith("/*") or inside:
            inside = "*/" not in line
        after_comment = is_comment
    return found


class CommentsTest(unittest.TestCase):
    def test_begin_with_their_subject(self):
        paths = [path for module in MODULES for path in sorted((ROOT / module).rglob("*")) if path.suffix in (".h", ".cc", ".c")]
        places = [f"{path.relative_to(ROOT)}:{number}" for path in paths
                  for number in find_without_subject(path.read_text(encoding="utf-8"))]
        self.assertEqual(places, [], "begin with the subject:\n" + "\n".join(places))

    def test_the_search_finds_each_form(self):
        for text in ("// What it is.\n", "int a;\n  /// How it is.\n", "/* Why it is. */\n", "/** When it is,\n * and so on. */\n",
                     "// Of a spring.\n", "  /* Of a spring. */\n"):
            self.assertEqual(len(find_without_subject(text)), 1, text)
        for text in ("// The place.\n// Where it is.\n", "int what;  // What follows code.\n", "/* The place,\n// Who */\n", "// Whatever.\n",
                     "// The size\n// Of all.\n", "int size;  // Of all.\n", "// Official.\n"):
            self.assertEqual(find_without_subject(text), [], text)


if __name__ == "__main__":
    unittest.main()
