"""What the tests of `unlatch optimize` share: a problem whose optimum is known in closed form, and how it is searched."""

import json
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from browser import Browser
from processes import UNLATCH, ProcessTest

MODULE = Path(UNLATCH).parent.parent / "lib"
SCENARIO = """unlatch: 1
name: push
step: {dt: 100 ms, until: 1 s}
bodies: {block: {mass: 1 kg, inertia: [1, 1, 1]}}
elements:
  px: {type: force, body: block, direction: [1, 0, 0], profile: 1 N}
  py: {type: force, body: block, direction: [0, 1, 0], profile: 1 N}
requirements:
  - {id: far, position: {body: block, along: [1, 1, 0]}, take: final, at_least: 1 m}
"""
# The block reaches (a/2, b/2) m, so (a + b) / sqrt(8) >= L: the optimum has a = 4 b, value 6.4 L^2, shadow price 12.8 L.
PROBLEM = """unlatch_optimize: 1
name: least-push
scenario: s.yaml
variables:
  a: {path: elements.px.profile, between: [0 N, 5 N]}
  b: {path: elements.py.profile, between: [0 N, 5 N]}
objectives: [{minimise: a^2 + 4*b^2}]
"""
CATALOGUE = PROBLEM.replace("between: [0 N, 5 N]", "values: [0 N, 1 N, 2 N, 3 N]")
FRONT = PROBLEM.replace("[{minimise: a^2 + 4*b^2}]", "[{minimise: a}, {minimise: b}]") + "budget: {runs: 2000}\n"
VALUE = 1e-5   # relative: constraints are kept by 1e-6 of their limit


class OptimizeCase(ProcessTest):
    def setUp(self):
        if not list(MODULE.rglob("libunlatch-optimizers.so")):
            self.skipTest("built without NLopt or pagmo")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "s.yaml").write_text(SCENARIO)

    def start(self, text, out, *options):
        (self.folder / "p.yaml").write_text(text)
        return subprocess.Popen([UNLATCH, "optimize", self.folder / "p.yaml", "--out", self.folder / out, *options],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def optimize(self, text, out, *options, code=0):
        process = self.start(text, out, *options)
        printed, errors = process.communicate(timeout=250)
        if code is not None:
            self.assertEqual(process.returncode, code, printed + errors)
        return json.loads((self.folder / out / "result.json").read_text())

    def look_at(self, out):
        """Returns a function that evaluates in the page of a result, in a browser without a network."""
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(self.folder / out / "report.html")
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:"))], [])
        self.browser = browser
        return browser.evaluate

    def write_campaign(self, samples, seed=1):
        (self.folder / "c.yaml").write_text(
            f"unlatch_campaign: 1\nname: c\nscenario: s.yaml\nsamples: {samples}\nseed: {seed}\n"
            "parameters: {m: {path: bodies.block.mass, uniform: {min: 0.9 kg, max: 1.1 kg}}}\n")

    def interrupt_verification(self, text):
        """Interrupts a search after it has written patch.yaml, which it verifies then; returns what it tells."""
        process = self.start(text, "o")
        while not (self.folder / "o/patch.yaml").exists():
            self.assertIsNone(process.poll())
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        printed, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, printed + errors)
        self.assertNotIn("OTHER BITS", printed)
        self.assertNotIn("not all constraints met", printed)
        self.assertIn("interrupted before its end, so nothing is verified", printed)
        result = json.loads((self.folder / "o/result.json").read_text())
        self.assertEqual((result["status"], result["verification"]["finished"]), ("unverified", False))
        return result
