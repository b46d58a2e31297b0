#!/usr/bin/env python3
"""Layers: modules include only modules below them, folders only folders below them, the kernel nothing but Eigen and the
standard library; no folder is a list: includes_test.py"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MODULES = ("kernel", "hil", "library", "bridge", "tools")  # lowest first
KERNEL = ("include", "math", "geometry", "simd", "model", "environment", "plan", "joints", "elements", "dynamics", "quantities", "laws", "tree",
          "compile", "solver", "dispatch", "integration", "events", "step", "images", "cost",
          "cost/measured", "targets", "targets/ports")  # lowest first
HIL = ("scenario/base", "session/messages", "scenario/text", "scenario/yaml", "scenario/language", "scenario/flexible",
       "scenario/shapes", "scenario", "session/realtime", "run/simulation", "run/recording", "run/motion", "run/audit", "run/notices", "run/findings",
       "run/extremes", "run/analysis", "run/outputs", "run", "session/participants", "session/faults", "session/executive", "study/statistics",
       "study/sampling", "study/evaluation", "study/campaign", "study/campaign/samples", "study/optimize/problem",
       "study/optimize")  # lowest first
HIL_GROUPS = ("scenario", "run", "session", "study")
LIBRARY = ("include", "c", "python", "fmi")  # lowest first
TOOLS = ("common", "program", "pages", "fsw", "fmu", "modes", "import", "export", "report", "watch", "campaign", "optimize", "requirements", "dossier",
         "unlatch/options", "unlatch/results", "unlatch/studies", "unlatch/check", "unlatch/run", "unlatch/recordings", "unlatch/dossier", "unlatch/files",
         "unlatch", "mpi")  # lowest first
BRIDGE = ("schema", "participant", "target", "stacks", "core", "udp", "uart", "lcm", "dds", "telemetry")  # lowest first
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.M)


def list_includes(module):
    for path in sorted((ROOT / module).rglob("*")):
        if path.suffix in (".h", ".cc") and "examples" not in path.parts:
            for ours, foreign in INCLUDE.findall(path.read_text(encoding="utf-8")):
                yield path.relative_to(ROOT), ours, foreign


def find_layer(path, folders):
    """The innermost of the folders that the file is in."""
    parts = path.parts[1:-1]
    names = ("/".join(parts[:n]) for n in range(len(parts), 0, -1))
    return next((name for name in names if name in folders), None)


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
            folder = find_layer(path, folders)
            self.assertIsNotNone(folder, f"{path}: a folder without a layer")
            if ours.startswith(module + "/"):
                self.assertIn(find_layer(Path(ours), folders), folders[:folders.index(folder) + 1], f"{path} includes {ours}")
        for folder in folders:  # a folder of a group is described in the group's page
            path = ROOT / module / folder
            pages = [path / "README.md", path.parent / "README.md", path.parent.parent / "README.md"]
            self.assertTrue(any(page.is_file() for page in pages), f"{module}/{folder} has no README.md")

    def test_folders_of_the_kernel_include_only_what_is_below_them(self):
        self.check_folders("kernel", KERNEL)

    def test_folders_of_hil_include_only_what_is_below_them(self):
        self.check_folders("hil", HIL)

    def test_studies_need_no_flight_software(self):
        for path, ours, _ in list_includes("hil"):
            if path.parts[1] == "study":
                self.assertNotRegex(ours, r"^hil/session/(participants|faults|executive)/", path)

    def test_each_group_of_hil_has_a_readme_that_the_page_of_hil_lists(self):
        page = (ROOT / "hil/README.md").read_text(encoding="utf-8")
        for group in HIL_GROUPS:
            self.assertTrue((ROOT / "hil" / group / "README.md").is_file(), group)
            self.assertIn(f"[{group}]({group}/README.md)", page)

    def test_folders_of_the_library_include_only_what_is_below_them(self):
        self.check_folders("library", LIBRARY)

    def test_folders_of_the_bridge_include_only_what_is_below_them(self):
        self.check_folders("bridge", BRIDGE)

    def test_folders_of_the_tools_include_only_what_is_below_them(self):
        self.check_folders("tools", TOOLS)

    def test_folders_are_described_in_their_page_or_in_that_of_their_group(self):
        for module in (*MODULES, "tests"):
            for folder in (ROOT / module).iterdir():
                if folder.is_dir() and folder.name != "__pycache__" and not (folder / "README.md").is_file():
                    page = (folder.parent / "README.md").read_text(encoding="utf-8")
                    self.assertRegex(page, rf"[`\[(/]{folder.name}[`/\]]", f"{folder.relative_to(ROOT)} has no README.md, and that of {module} does not name it")

    def test_no_folder_is_a_list(self):
        several = 20  # headers and sources, some ten pairs; more belong into folders by subject
        for module in MODULES:
            for folder in [ROOT / module, *(path for path in (ROOT / module).rglob("*") if path.is_dir())]:
                files = [path for path in folder.iterdir() if path.suffix in (".h", ".cc")]
                self.assertLessEqual(len(files), several, folder.relative_to(ROOT))

    def test_one_folder_knows_mpi(self):
        users = {path.parent.as_posix() for module in MODULES for path, _, foreign in list_includes(module) if foreign == "mpi.h"}
        self.assertEqual(users, {"tools/mpi"})

    def test_the_library_knows_nothing_of_the_bus(self):
        for path, ours, _ in list_includes("library"):
            self.assertNotEqual(ours.split("/")[0], "bridge", f"{path} includes {ours}")

    def test_nothing_below_the_step_includes_its_header(self):
        for path, ours, _ in list_includes("kernel"):
            if ours == "unlatch/step.h":
                self.assertGreaterEqual(KERNEL.index(find_layer(path, KERNEL)), KERNEL.index("step"), f"{path} includes {ours}")

    def test_the_kernel_includes_nothing_but_eigen_and_the_standard_library(self):
        standard = re.compile(r"[a-z_]+")  # <vector>: no folder, no ending
        for path, ours, foreign in list_includes("kernel"):
            if ours:
                self.assertTrue(ours.startswith(("kernel/", "unlatch/")), f"{path} includes {ours}")
            elif not foreign.startswith("Eigen/") and foreign not in ("immintrin.h", "arm_neon.h"):
                self.assertTrue(standard.fullmatch(foreign), f"{path} includes <{foreign}>")


if __name__ == "__main__":
    unittest.main()
