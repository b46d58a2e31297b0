#!/usr/bin/env python3
"""tools/sbom states a version of every package that the executables are built from."""

import json
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class SbomTest(unittest.TestCase):
    def test_every_package_of_the_executables_has_a_version(self):
        done = subprocess.run([ROOT / "tools/sbom"], capture_output=True, text=True, check=False)
        self.assertIn(done.returncode, (0, 3), done.stderr)  # 3: packages for developers or benches are not installed
        document = json.loads(done.stdout)
        self.assertEqual(document["spdxVersion"], "SPDX-2.3")
        versions = {package["name"]: package["versionInfo"] for package in document["packages"]}
        lines = (ROOT / "tools/packages.txt").read_text(encoding="utf-8").splitlines()
        needed = [line.split()[1] for line in lines if line.startswith("demo ")]
        self.assertGreater(len(needed), 5)
        for name in needed:
            self.assertRegex(versions.get(name, ""), r"\d", name)
        for name in json.loads((ROOT / "tools/pages/package.json").read_text(encoding="utf-8"))["dependencies"]:
            self.assertRegex(versions.get(name, ""), r"\d", name)
        identities = {package["SPDXID"] for package in document["packages"]} | {"SPDXRef-DOCUMENT"}
        self.assertEqual(len(identities), len(document["packages"]) + 1)
        for relationship in document["relationships"]:
            self.assertIn(relationship["spdxElementId"], identities)
            self.assertIn(relationship["relatedSpdxElement"], identities)


if __name__ == "__main__":
    unittest.main()
