#!/usr/bin/env python3
"""Facts about `unlatch modes`, with CalculiX as a real process where it is installed. Run by ctest:

    modes_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import json
import shutil
import subprocess
import unittest

from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

TABLE = json.loads((SOURCE / "tests/data/fairing_shell.json").read_text())
FAIRING = SOURCE / "hil/scenarios/fairing/fairing.modes"
AGREES = 0.005  # relative error of a frequency that the mesh may cause


def needs_calculix(test):
    return unittest.skipUnless(shutil.which("ccx"), "CalculiX is not installed (tools/setup test)")(test)


class ModesTest(ProcessTest):
    def test_arc_prints_both_models(self):
        result = self.run_ok(UNLATCH, "modes", "arc", "--radius", "2", "--thickness", "0.01")
        for number in ("1.970867585", "5.0619", "1.837171899", "4.9463", "11.114943737", "29.9255"):
            self.assertIn(number, result.stdout)
        report = self.run_json(UNLATCH, "modes", "arc", "--points", "7")
        shallow, exact = report["models"]
        self.assertEqual(shallow["model"], "beam_3_4")
        self.assertEqual(len(exact["modes"][2]["radial"]), 7)

    def check_shell(self, name, *options):
        report = self.run_json(UNLATCH, "modes", "shell", "--modes", "7", *options)
        for mode, hz in zip(report["modes"], TABLE[name]["hz"], strict=True):
            self.assertAlmostEqual(mode["hz"] / hz, 1, delta=AGREES, msg=str(mode))
            self.assertGreater(mode["symmetry"], 0.999)
        beams = {mode["beam"]["number"]: mode for mode in report["modes"] if "beam" in mode}
        self.assertEqual([beams[k]["mode"] for k in (1, 2, 3)], TABLE[name]["beams"])
        return report, beams

    @needs_calculix
    def test_half_cylinder_is_the_exact_arc(self):
        _, beams = self.check_shell("cylinder", "--cone", "0")
        for mode in beams.values():
            self.assertAlmostEqual(mode["hz"] / mode["beam"]["exact_arc_hz"], 1, delta=0.002)
            self.assertGreater(mode["beam"]["mac"], 0.98)

    @needs_calculix
    def test_half_shell_with_its_cone_has_the_papers_first_and_fourth(self):
        path = self.folder / "half.modes"
        report, beams = self.check_shell("apex", "--keep", self.folder / "ccx", "--out", path,
                                         "--marker", "hinge=0,2,0")
        self.assertEqual((beams[1]["mode"], beams[2]["mode"]), (1, 4))
        body = report["body"]
        self.assertAlmostEqual(body["mass"] / TABLE["apex"]["mass"], 1, delta=1e-3)
        self.assertLess(body["made"]["gram"], 1e-12)
        self.assertLess(body["made"]["momentum"], 1e-12)
        self.assertLess(body["found"]["gram"], 1e-2)
        # CalculiX's own files, imported like those of any user, give the same file apart from the mesh.
        again = self.folder / "again.modes"
        self.run_ok(UNLATCH, "modes", "import", self.folder / "ccx/shell.frd", "--dat", self.folder / "ccx/shell.dat",
                    "--thickness", "0.01", "--density", "4000", "--modes", "7", "--marker", "hinge=0,2,0",
                    "--out", again)
        numbers = [[line for line in file.read_text().splitlines() if not line.startswith("source")]
                   for file in (path, again)]
        self.assertEqual(*numbers)

    @needs_calculix
    def test_a_deck_in_millimetres_and_tonnes_gives_the_same_file_with_units_and_a_warning_without(self):
        self.run_ok(UNLATCH, "modes", "shell", "--modes", "7", "--cone", "0", "--keep", self.folder / "ccx", "--out", self.folder / "metres.modes")
        # The same deck with lengths in mm, E in N/mm2, density in t/mm3.
        lines, section = [], ""
        for line in (self.folder / "ccx/shell.inp").read_text().splitlines():
            if line.startswith("*"):
                section = line
            elif section.startswith(("*NODE\n", "*SHELL SECTION")) or section == "*NODE":
                cells = line.split(",")
                kept = 1 if section == "*NODE" else 0
                line = ", ".join(cells[:kept] + [repr(1000 * float(cell)) for cell in cells[kept:]])
            elif section == "*ELASTIC":
                young, poisson = line.split(",")
                line = f"{float(young) * 1e-6!r}, {poisson}"
            elif section == "*DENSITY":
                line = repr(float(line) * 1e-12)
            lines.append(line)
        (self.folder / "mm.inp").write_text("\n".join(lines) + "\n")
        subprocess.run(["ccx", "mm"], cwd=self.folder, check=True, stdout=subprocess.DEVNULL, timeout=300)
        arguments = [UNLATCH, "modes", "import", self.folder / "mm.frd", "--dat", self.folder / "mm.dat", "--thickness", "0.01", "--density", "4000",
                     "--modes", "7", "--out", self.folder / "mm.modes", "--json"]
        self.run_ok(UNLATCH, "modes", "show", self.folder / "metres.modes", "--json", self.folder / "metres.json")
        metres = json.loads((self.folder / "metres.json").read_text())
        self.run_ok(*arguments, self.folder / "mm.json", "--units", "mm")
        report = json.loads((self.folder / "mm.json").read_text())
        self.assertNotIn("warnings", report)
        self.assertAlmostEqual(report["mass"] / metres["mass"], 1, delta=1e-5)
        self.assertLess(report["found"]["gram"], 1e-2)
        for mode, same in zip(report["modes"], metres["modes"], strict=True):
            self.assertAlmostEqual(mode["hz"] / same["hz"], 1, delta=1e-4)
        result = self.run_ok(*arguments, self.folder / "wrong.json")
        self.assertIn("the file is in mm and t; add --units mm", result.stderr)
        self.assertIn("--units mm", json.loads((self.folder / "wrong.json").read_text())["warnings"][0])
        for density, warns in (("4400", False), ("8000", True)):  # 10 % are within what a coarse mesh explains
            other = [density if argument == "4000" else argument for argument in arguments[:-1]]
            self.assertEqual("another than in the deck" in self.run_ok(*other, "--units", "mm").stderr, warns)

    def test_the_shipped_fairing_half_is_conditioned(self):
        report = self.run_json(UNLATCH, "modes", "show", FAIRING, "--select", "1,4,5")
        self.assertEqual([mode["number"] for mode in report["modes"] if mode["selected"]], [1, 4, 5])
        for mode, hz in zip(report["modes"], TABLE["apex"]["hz"]):
            self.assertAlmostEqual(mode["hz"] / hz, 1, delta=AGREES)
        self.assertLess(report["made"]["gram"], 1e-12)

    def test_elastic_halves_part_and_stay_clear_of_the_payload(self):
        scenario = SCENARIOS / "fairing/scenario.yaml"
        self.assertIn("half1_hinge", self.run_ok(UNLATCH, "check", scenario).stdout)
        report = self.run_json(UNLATCH, "run", scenario)
        self.assertEqual(report["status"], "ok")
        times = {event["subject"]: event["t"] for event in report["events"] if event["name"] == "release"}
        self.assertAlmostEqual(times["half1"], times["half2"], delta=1e-9)  # mirror images
        rigid = self.run_json(UNLATCH, "run", scenario, "--set", "bodies.half1.flexible.select=[8]", "--set",
                              "bodies.half2.flexible.select=[8]")
        closest = [min(pair["min"] for pair in run["clearance"]) for run in (report, rigid)]
        self.assertGreater(closest[0], 0.2)
        self.assertLess(closest[0], closest[1] - 0.03)  # breathing brings the edges nearer
        p, q = report["samples"][-1]["bodies"]["half1"]["p"], report["samples"][-1]["bodies"]["half2"]["p"]
        self.assertAlmostEqual(p[1], -q[1], delta=1e-9)

    def test_damaged_files_are_refused_with_their_place(self):
        text = FAIRING.read_text()
        bad = self.folder / "bad.modes"
        for damage, says in ((text[: len(text) // 2], "numbers"), (text.replace("end\n", ""), "ends too early"),
                             ("nonsense\n", "not a modes file")):
            bad.write_text(damage)
            result = self.run_ok(UNLATCH, "modes", "show", bad, code=2)
            self.assertRegex(result.stderr, r"bad\.modes:\d+:\d+: ")
            self.assertIn(says, result.stderr)
        bad.write_text("   2C   4\n")
        self.assertIn("without its last line", self.run_ok(
            UNLATCH, "modes", "import", bad, "--thickness", "1", "--density", "1", "--out", self.folder / "o",
            code=2).stderr)
        self.assertFalse((self.folder / "o").exists())

    def test_missing_calculix_is_the_environments_fault(self):
        result = self.run_ok(UNLATCH, "modes", "shell", "--ccx", "/nowhere/ccx", code=3)
        self.assertIn("calculix-ccx", result.stderr)


if __name__ == "__main__":
    main()
