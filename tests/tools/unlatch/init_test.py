#!/usr/bin/env python3
"""Creation and inspection of a scenario: `unlatch init`, `unlatch check --graph`.

    init_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import os
import subprocess
import xml.etree.ElementTree as ElementTree

from processes import BOOSTERS, REFERENCE, SOURCE, UNLATCH, ProcessTest, call, main

KINDS = sorted(path.stem for path in (SOURCE / "tools/unlatch/files/starters").glob("*.yaml"))
# Events that each starter shows when it is run.
HAPPENS = {"separation": ["release"], "boosters": ["release", "contact", "liftoff"], "array": ["latch"],
           "capsule": ["release", "ignition"], "fairing": ["release"], "antenna": ["release", "taut", "latch", "slack"],
           "deployer": ["open", "touch", "lift", "release", "stroke_end", "exit"], "interstage": ["break", "stroke_end"],
           "launcher": ["burnout", "ignition"], "mast": ["taut", "slack", "lock"], "orbit": ["release", "stroke_end"],
           "sensors": ["release", "opens", "broken", "stroke_end"], "slosh": [], "yoyo": ["free", "unwound", "release"]}
COUNTS = {"boosters": 12, "array": 2, "fairing": 2, "capsule": 2, "separation": 1, "antenna": 24, "deployer": 6, "interstage": 8, "launcher": 2, "mast": 3, "orbit": 2, "sensors": 4, "slosh": 0, "yoyo": 5}  # names and subjects
SYSTEMS = {path.parent.name for path in (SOURCE / "hil/scenarios").glob("*/*.yaml")} - {"tree3", "tree20", "checkcases"}  # those are for tests


class InitTest(ProcessTest):
    def test_starters_check_and_run_and_something_happens(self):
        self.assertEqual(KINDS, sorted(HAPPENS))
        for kind in KINDS:
            path = self.folder / f"my-{kind}.yaml"
            made = call(UNLATCH, "init", self.folder / f"my-{kind}", "--like", kind)
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(call(UNLATCH, "check", path).returncode, 0)
            report = self.run_json(UNLATCH, "run", path)
            self.assertEqual((report["status"], report["scenario"]), ("ok", f"my-{kind}"))
            happened = {(e["name"], e["subject"]) for e in report["events"]}
            self.assertEqual({name for name, _ in happened}, set(HAPPENS[kind]), kind)
            text = path.read_text()
            self.assertEqual(len(happened), COUNTS[kind], happened)
            self.assertTrue(all(entry["met"] for entry in report.get("verdict", [])), report.get("verdict"))
            self.assertIn("#", text)

    def test_each_shipped_system_has_a_starter(self):
        self.assertLessEqual(SYSTEMS, set(KINDS))
        helped = call(UNLATCH, "init", "--help").stdout
        for kind in KINDS:
            self.assertIn(kind, helped)

    def test_init_overwrites_nothing(self):
        path = self.folder / "mine.yaml"
        path.write_text("mine")
        (self.folder / "unlatch.schema.json").write_text("theirs")
        refused = call(UNLATCH, "init", path)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("already", refused.stderr)
        self.assertEqual(path.read_text(), "mine")
        self.assertEqual(call(UNLATCH, "init", self.folder / "other").returncode, 0)
        self.assertEqual((self.folder / "unlatch.schema.json").read_text(), "theirs")

    def test_init_refuses_what_is_no_name_and_says_where_it_cannot_write(self):
        for name in ("1st", "a b", "", "x" * 41):
            self.assertEqual(call(UNLATCH, "init", self.folder / f"{name}.yaml").returncode, 2, name)
        self.assertEqual(call(UNLATCH, "init", self.folder / "nowhere/first").returncode, 3)
        self.assertEqual(call(UNLATCH, "init", "first", "--like", "rocket").returncode, 2)

    def test_the_schema_of_init_is_the_projects(self):
        self.assertEqual(call(UNLATCH, "init", self.folder / "first").returncode, 0)
        self.assertEqual((self.folder / "unlatch.schema.json").read_bytes(), (SOURCE / "hil/scenarios/unlatch.schema.json").read_bytes())

    def test_graphs_show_bodies_joints_modes_and_events(self):
        picture = self.folder / "boosters.svg"
        done = call(UNLATCH, "check", BOOSTERS, "--graph", picture)
        self.assertEqual(done.returncode, 0, done.stderr)
        root = ElementTree.parse(picture).getroot()
        words = {text.strip() for text in root.itertext()}
        for word in ("core", "booster1", "nose4", "hinge", "slider", "release", "liftoff", "ties_cut"):
            self.assertTrue(any(word in w for w in words), word)
        self.assertTrue(any("reaction x > 0" in w for w in words), words)

    def test_a_missing_graphviz_is_said_and_leaves_no_file(self):
        picture = self.folder / "boosters.svg"
        done = subprocess.run([UNLATCH, "check", REFERENCE, "--graph", picture], capture_output=True, text=True,
                              env={**os.environ, "PATH": str(self.folder)})
        self.assertEqual(done.returncode, 3)
        self.assertIn("apt-get install graphviz", done.stderr)
        self.assertFalse(picture.exists())
        self.assertEqual(call(UNLATCH, "check", REFERENCE, "--graph", self.folder / "nowhere/a.svg").returncode, 3)


if __name__ == "__main__":
    main()
