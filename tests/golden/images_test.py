#!/usr/bin/env python3
"""`unlatch compile`: its images fly with the hashes of the scenarios, and are refused with a reason when they are not
what the program can use: images_test.py BIN SOURCE"""

import json
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BIN, ROOT = (Path(sys.argv.pop(1)).resolve() for _ in range(2))
SCENARIOS = ROOT / "hil/scenarios"
GOLDEN = json.loads((ROOT / "tests/data/golden.json").read_text(encoding="utf-8"))["scenarios"]
TICKS = 200  # of each scenario
EDITS = 20000
# With the kernel's golden models they have every list of a plan.
EDITED = ("antenna/ring", "array/elastic", "boosters/ascent", "deployer/scenario", "fairing/design", "interstage/scenario", "launcher/scenario",
          "mast/scenario", "orbit/drag", "sensors/scenario", "slosh/scenario", "tree3/reference", "yoyo/scenario")
# Places in the header: kernel/plan/plan_image.h.
BYTE_ORDER, VERSION, LAYOUT, CHECKSUM = 8, 12, 16, 32


def run(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300, check=False)


class ImagesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)

    def compile(self, name, *overrides):
        image = Path(self.folder.name) / ("-".join((name, *overrides)).replace("/", "-") + ".plan")
        if not image.exists():
            done = run(BIN / "unlatch", "compile", SCENARIOS / f"{name}.yaml", *(f"--set={text}" for text in overrides), "--out", image)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"{image.stat().st_size} bytes, plan ", done.stdout)
        return image

    def fly(self, *flights):
        return run(BIN / "golden_images", *flights)

    def test_every_scenario_has_the_same_hashes_from_its_image(self):
        flights = []
        for name, hashes in GOLDEN.items():
            ticks = min(TICKS, max(int(key) for key in hashes if key.isdigit()))
            flights.append(f"{name}={self.compile(name)}={ticks}")
        done = self.fly(*flights)
        self.assertEqual(done.returncode, 0, done.stderr)
        compared = 0
        for line in done.stdout.splitlines():
            name, tick, value = line.split()
            if tick.isdigit() and tick in GOLDEN[name]:
                self.assertEqual(GOLDEN[name][tick], value, f"{name} at {tick}")
                compared += 1
        self.assertGreaterEqual(compared, len(GOLDEN))

    def test_an_image_that_is_none_of_this_machine_s_is_refused_with_what_mends_it(self):
        good = self.compile("boosters/reference").read_bytes()
        changed = Path(self.folder.name) / "changed"

        def refuse(data, text):
            changed.write_bytes(data)
            done = self.fly(f"x={changed}=1")
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(text, done.stderr)

        def put(place, form, value):
            data = bytearray(good)
            struct.pack_into(form, data, place, value)
            return bytes(data)

        self.assertEqual(struct.unpack_from("<I", good, BYTE_ORDER)[0], 0x01020304)
        refuse(put(BYTE_ORDER, "<I", 0x04030201), "the other byte order: compile it on a machine with this one")
        refuse(put(VERSION, "<I", 99), "another version of the format: compile it again")
        layout = struct.unpack_from("<Q", good, LAYOUT)[0]
        refuse(put(LAYOUT, "<Q", layout ^ 1), "another layout of numbers or by another version of unlatch")
        refuse(put(CHECKSUM, "<Q", 0), "checksum is wrong, some bit has changed: copy it again")
        refuse(good[:-1], "shorter than it says: copy it whole")
        refuse(b"PNG" + good, "no plan image: give what `unlatch compile` writes")

    def test_changed_numbers_with_a_right_checksum_are_refused_or_fly(self):
        models = Path(self.folder.name) / "models"
        models.mkdir()
        self.assertEqual(run(BIN / "golden", "--images", models).returncode, 0)
        images = [self.compile(name) for name in EDITED] + sorted(models.iterdir())
        images.append(self.compile("array/scenario", "elements.drive1.implicit=true"))
        seed = 48
        done = run(BIN / "image_edits", "--edits", EDITS, "--seed", seed, *images)
        self.assertEqual(done.returncode, 0, f"seed {seed}: {done.stdout}{done.stderr}")
        self.assertRegex(done.stdout, r"\n(\d+) of \1 lists have items")
        outcomes = {line.rsplit(": ", 1)[0]: int(line.rsplit(": ", 1)[1]) for line in done.stdout.splitlines() if ": " in line}
        self.assertEqual(sum(outcomes.values()), EDITS)
        for outcome in ("refused", "flown"):  # both are common, or the edits miss what they are for
            self.assertGreater(outcomes[outcome], EDITS // 10)

    def test_a_scenario_with_mistakes_leaves_no_image(self):
        image = Path(self.folder.name) / "none.plan"
        done = run(BIN / "unlatch", "compile", SCENARIOS / "boosters/reference.yaml", "--set", "step.dt=-1", "--out", image)
        self.assertNotEqual(done.returncode, 0)
        self.assertFalse(image.exists())


if __name__ == "__main__":
    unittest.main()
