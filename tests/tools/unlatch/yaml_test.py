#!/usr/bin/env python3
"""Scenarios after processing by tools for YAML 1.1: each shipped one, read and written by PyYAML, is accepted and has the same hash.

    yaml_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import shutil

import yaml
from processes import SCENARIOS, UNLATCH, ProcessTest, call, main

END = 0.3  # s of each run; long enough for the first events of most scenarios


def write_back(text):
    """Returns PyYAML's form of a file. The order of keys stays: it determines the numbers of bodies and joints."""
    return yaml.safe_dump(yaml.safe_load(text), sort_keys=False)


class YamlTest(ProcessTest):
    def run_hash(self, path):
        """Runs it; the requirements of such a short run may be met or missed."""
        report = self.run_json(UNLATCH, "run", path, "--until", END, code=None)
        self.assertEqual(report["status"], "ok")
        return report["hash"]

    def test_scenarios_written_back_by_pyyaml_are_accepted_and_keep_their_hash(self):
        copy = self.folder / "scenarios"
        shutil.copytree(SCENARIOS, copy)
        for path in copy.rglob("*.yaml"):
            path.write_text(write_back(path.read_text()))
        shipped = sorted(p for p in SCENARIOS.glob("*/*.yaml") if "\nunlatch:" in p.read_text())
        self.assertGreater(len(shipped), 15)
        for path in shipped:
            written = copy / path.relative_to(SCENARIOS)
            self.run_ok(UNLATCH, "check", written)
            self.assertEqual(self.run_hash(written), self.run_hash(path), path)

    def test_the_old_key_is_refused_with_its_place_and_the_new_name(self):
        text = (SCENARIOS / "capsule/scenario.yaml").read_text()
        old = self.folder / "old.yaml"
        old.write_text(text.replace("    enabled: false", "    on: false", 1))
        line = old.read_text().split("\n").index("    on: false") + 1
        refused = call(UNLATCH, "check", old)
        self.assertEqual(refused.returncode, 2)
        self.assertIn(f"old.yaml:{line}:5: unknown key 'on' in element 'retro'", refused.stderr)
        self.assertIn("`enabled`", refused.stderr)
        back = self.folder / "back.yaml"
        back.write_text(write_back(old.read_text()))
        self.assertIn("\n    true: false\n", back.read_text())
        refused = call(UNLATCH, "check", back)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("`enabled`", refused.stderr)
        refused = call(UNLATCH, "check", SCENARIOS / "capsule/scenario.yaml", "--set", "elements.retro.on=true")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("`enabled`", refused.stderr)


if __name__ == "__main__":
    main()
