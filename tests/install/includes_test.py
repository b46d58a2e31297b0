#!/usr/bin/env python3
"""Layers: modules include only modules below them, folders of hil only folders below them, the kernel nothing but Eigen and
the standard library: includes_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("kernel", "hil", "bridge", "tools")  # from below
HIL = ("messages", "language", "flexible", "scenario", "realtime", "simulation", "recording", "analysis", "run", "session",
       "faults", "executive")  # from below
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.M)


def list_includes(room):
    for path in sorted((ROOT / room).rglob("*")):
        if path.suffix in (".h", ".cc") and "examples" not in path.parts:
            for ours, foreign in INCLUDE.findall(path.read_text(encoding="utf-8")):
                yield path.relative_to(ROOT), ours, foreign


class IncludesTest(unittest.TestCase):
    def test_rooms_include_only_what_is_below_them(self):
        for level, room in enumerate(ROOMS):
            allowed = ROOMS[:level + 1]
            for path, ours, _ in list_includes(room):
                other = ours.split("/")[0]
                if other in (*ROOMS, "tests", "bench"):
                    self.assertIn(other, allowed, f"{path} includes {ours}")

    def test_folders_of_hil_include_only_what_is_below_them(self):
        for path, ours, _ in list_includes("hil"):
            folder, parts = path.parts[1], ours.split("/")
            self.assertIn(folder, HIL, f"{path}: a folder without a layer")
            if parts[0] == "hil":
                self.assertIn(parts[1], HIL[:HIL.index(folder) + 1], f"{path} includes {ours}")

    def test_each_folder_of_hil_says_what_it_is(self):
        for folder in HIL:
            self.assertTrue((ROOT / "hil" / folder / "README.md").is_file(), f"hil/{folder} has no README.md")

    def test_the_kernel_includes_nothing_but_eigen_and_the_standard_library(self):
        standard = re.compile(r"[a-z_]+")  # <vector>: no folder, no ending
        for path, ours, foreign in list_includes("kernel"):
            if ours:
                self.assertTrue(ours.startswith(("kernel/", "unlatch/")), f"{path} includes {ours}")
            elif not foreign.startswith("Eigen/") and foreign not in ("immintrin.h", "arm_neon.h"):
                self.assertTrue(standard.fullmatch(foreign), f"{path} includes <{foreign}>")


if __name__ == "__main__":
    unittest.main()
