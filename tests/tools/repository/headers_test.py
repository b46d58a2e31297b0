#!/usr/bin/env python3
"""The C++ reference: every public name has a description, and plain comments become descriptions.

    headers_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree

from processes import HANG, SOURCE, ProcessTest, main

SAMPLE = """// Sample: a header in this project's style. Its second sentence.
//
//   a table   that keeps   its columns
#pragma once

namespace sample {

// --- Ruler ------------------------------------------------------------------------------------------------------------

// A kind of thing.
enum class Kind { kFirst, kSecond };

struct Thing {  // One thing. With <angle> brackets, a @command and a \\\\backslash.
  double mass = 0;       // kg, > 0
  double width, height;  // m, mm
  int long_one;          // a description
                         // in two lines
  // Above.
  Kind kind = Kind::kFirst;

  // Ends of something.
  double from, to;
};

// Two like functions.
int first(int x) noexcept;
inline int second(int x) {
  return x;  // not a description
}

// Describes nothing.

enum class State {
  kOff,  // at rest
  kOn,   // at work
};

}  // namespace sample
"""


class HeadersTest(ProcessTest):
    def build(self, headers=None):
        """Returns (exit code, undescribed names with their places, output) of tools/docs."""
        environment = {**os.environ, **({"UNLATCH_PUBLIC_HEADERS": str(headers)} if headers else {})}
        done = subprocess.run([SOURCE / "tools/docs", self.folder / "docs"], env=environment, capture_output=True, text=True, timeout=HANG)
        missing = dict(reversed(m) for m in re.findall(r"^(\S+:\d+): (\S+) has no description$", done.stderr, re.M))
        return done.returncode, missing, done.stdout + done.stderr

    def write(self, text):
        headers = self.folder / "include/sample"
        headers.mkdir(parents=True, exist_ok=True)
        (headers / "sample.h").write_text(text)
        return headers

    def describe(self):
        """Returns descriptions by name, from Doxygen's XML."""
        texts = {}
        for path in (self.folder / "docs/.work/xml").glob("*.xml"):
            for node in ElementTree.parse(path).getroot().iter():
                if node.tag in ("compounddef", "memberdef", "enumvalue"):
                    name = node.findtext("name") or node.findtext("compoundname")
                    said = [" ".join("".join(node.find(tag).itertext()).split()) for tag in ("briefdescription", "detaileddescription")]
                    texts[name] = " ".join(filter(None, said))
        return texts

    def test_every_public_name_has_a_description(self):
        code, missing, said = self.build()
        self.assertEqual(set(missing), set(), said)
        self.assertEqual(code, 0, said)
        self.assertTrue((self.folder / "docs/cpp/index.html").exists())

    def test_plain_comments_become_descriptions(self):
        code, missing, said = self.build(self.write(SAMPLE))
        self.assertEqual(set(missing), {"sample::State"}, said)
        self.assertEqual(code, 1)
        texts = self.describe()
        self.assertEqual(texts["sample::Thing"], "One thing. With <angle> brackets, a @command and a \\\\backslash.")
        self.assertEqual(texts["mass"], "kg, > 0")
        self.assertEqual((texts["width"], texts["height"]), ("m", "mm"))
        self.assertEqual(texts["long_one"], "a description in two lines")
        self.assertEqual(texts["kind"], "Above.")
        self.assertEqual((texts["from"], texts["to"]), ("Ends of something.",) * 2)
        self.assertEqual((texts["first"], texts["second"]), ("Two like functions.",) * 2)
        self.assertEqual(texts["kOff"], "at rest")
        self.assertEqual(texts["Kind"], "A kind of thing.")
        self.assertTrue(texts["sample.h"].startswith("Sample: a header in this project's style. Its second sentence."))
        page = (self.folder / "docs/cpp/sample_8h.html").read_text()
        self.assertIn("a table   that keeps   its columns", page)

    def test_a_name_without_a_description_is_named_with_its_line(self):
        bare = SAMPLE.replace("  double mass = 0;       // kg, > 0\n", "  double mass = 0;\n").replace("// Describes nothing.\n\n", "// A state.\n")
        code, missing, said = self.build(self.write(bare))
        self.assertEqual(code, 1, said)
        line = bare.split("\n").index("  double mass = 0;") + 1
        self.assertEqual(list(missing), ["sample::Thing::mass"])
        self.assertTrue(missing["sample::Thing::mass"].endswith(f"sample/sample.h:{line}"), missing)

    def test_a_described_header_passes(self):
        code, missing, said = self.build(self.write(SAMPLE.replace("// Describes nothing.\n\n", "// A state.\n")))
        self.assertEqual((code, missing), (0, {}), said)


if __name__ == "__main__":
    main()
