#!/usr/bin/env python3
"""Layers: modules include only modules below them, folders only folders below them, the kernel nothing but Eigen and the
standard library: includes_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = ("kernel", "hil", "library", "bridge", "tools")  # lowest first
KERNEL = ("include", "math", "geometry", "simd", "model", "plan", "joints", "dynamics", "compile", "solver", "dispatch",
          "step")  # lowest first
HIL = ("modules", "messages", "language", "flexible", "meshes", "scenario", "realtime", "simulation", "recording", "motion", "notices",
       "separations", "analysis", "outputs", "run", "evaluation", "sampling", "statistics", "campaign", "synthesis", "session", "faults", "executive")  # lowest first
LIBRARY = ("include", "c", "python", "fmi")  # lowest first
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.M)


def list_includes(module):
    for path in sorted((ROOT / module).rglob("*")):
        if path.suffix in (".h", ".cc") and "examples" not in path.parts:
            for ours, foreign in INCLUDE.findall(path.read_text(encoding="utf-8")):
                yield path.relative_to(ROOT), ours, foreign


class IncludesTest(unittest.TestCase):
    def test_modules_include_only_modules_below_them(self):
        for level, module in enumerate(MODULES):
            allowed = MODULES[:level + 1]
            for path, ours, _ in list_includes(module):
                other = ours.split("/")[0]
                if other in (*MODULES, "tests", "bench"):
                    self.assertIn(other, allowed, f"{path} includes {ours}")

    def check_folders(self, module, folders):
        for path, ours, _ in list_includes(module):
            folder, parts = path.parts[1], ours.split("/")
            self.assertIn(folder, folders, f"{path}: a folder without a layer")
            if parts[0] == module:
                self.assertIn(parts[1], folders[:folders.index(folder) + 1], f"{path} includes {ours}")
        for folder in folders:
            self.assertTrue((ROOT / module / folder / "README.md").is_file(), f"{module}/{folder} has no README.md")

    def test_folders_of_the_kernel_include_only_what_is_below_them(self):
        self.check_folders("kernel", KERNEL)

    def test_folders_of_hil_include_only_what_is_below_them(self):
        self.check_folders("hil", HIL)

    def test_the_table_of_hil_lists_its_folders_from_below(self):
        table = re.findall(r"^\| \[(\w+)\]\(\1/README\.md\)", (ROOT / "hil/README.md").read_text(encoding="utf-8"), re.M)
        self.assertEqual(tuple(table), HIL)

    def test_folders_of_the_library_include_only_what_is_below_them(self):
        self.check_folders("library", LIBRARY)

    def test_one_folder_knows_mpi(self):
        users = {path.parent.as_posix() for module in MODULES for path, _, foreign in list_includes(module) if foreign == "mpi.h"}
        self.assertEqual(users, {"tools/mpi"})

    def test_the_library_knows_nothing_of_the_bus(self):
        for path, ours, _ in list_includes("library"):
            self.assertNotEqual(ours.split("/")[0], "bridge", f"{path} includes {ours}")

    def test_the_kernel_includes_nothing_but_eigen_and_the_standard_library(self):
        standard = re.compile(r"[a-z_]+")  # <vector>: no folder, no ending
        for path, ours, foreign in list_includes("kernel"):
            if ours:
                self.assertTrue(ours.startswith(("kernel/", "unlatch/")), f"{path} includes {ours}")
            elif not foreign.startswith("Eigen/") and foreign not in ("immintrin.h", "arm_neon.h"):
                self.assertTrue(standard.fullmatch(foreign), f"{path} includes <{foreign}>")


if __name__ == "__main__":
    unittest.main()
