"""Real processes under test. A test file is run with BIN_FOLDER SOURCE_FOLDER [unittest options]."""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BIN, SOURCE = Path(sys.argv[1]), Path(sys.argv[2])
UNLATCH, FSW = str(BIN / "unlatch"), str(BIN / "unlatch-fsw")
SCENARIOS = SOURCE / "hil/scenarios"
BOOSTERS = str(SCENARIOS / "boosters/scenario.yaml")
REFERENCE = str(SCENARIOS / "boosters/reference.yaml")

# A sanitizer uses its own memory, and another debug format than valgrind reads.
CACHE = BIN.parent / "CMakeCache.txt"
SANITIZED = CACHE.exists() and re.search("^UNLATCH_SANITIZE:STRING=.", CACHE.read_text(encoding="utf-8"), re.M) is not None

HANG = 240  # s; far longer than any step here, so that a hang ends in a failure. No fact depends on wall time.
PATIENT = ["--set", "flight_software.timeout=30"]  # a stalled machine must not count as dead flight software


def call(*arguments):
    return subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=HANG)


def start(*arguments, stderr=subprocess.DEVNULL):
    return subprocess.Popen(list(map(str, arguments)), stdout=subprocess.DEVNULL, stderr=stderr, text=True)


# A dart in the air: tables, expressions, quantities of flight, a channel that scales a table.
FLIGHT = """unlatch: 1
name: dart
step: {dt: 0.005, until: 2}
constants: {fineness: 1.5}
environment: {planet: wgs84, origin: start, atmosphere: us1976, wind: {altitude: [0, 60 km], east: [5 m/s, 40 m/s]}}
start: {body: dart, latitude: 46 deg, altitude: 30 km, velocity: {speed: 1 km/s, flight_path_angle: 10 deg}, attitude: {pitch: 14 deg}}
bodies:
  dart: {mass: 300, inertia: [40, 300, 300]}
channels:
  gain: {initial: 1, range: [0, 2]}
tables:
  pitching: {axes: {alpha: {of: alpha, at: [-60 deg, -20 deg, 0, 20 deg, 60 deg], unit: rad}}, values: [0.9, 0.3, 0, -0.3, -0.9], interpolation: smooth,
             scale: 1.0, offset: 0.0, scale_channel: gain}
quantities:
  alpha: {angle_of_attack: dart}
  mach: {mach: dart}
  load: {expression: "fineness * sin(2 * alpha) * mach"}
elements:
  air: {type: aerodynamics, body: dart, area: 1 m2, length: 2 m, drag: 0.3, cz: {expression: -load}, cm: [{expression: pitching}, 0.001], damping: {cm: [0, -0.5, 0]}}
sensors:
  alpha: {type: quantity, quantity: alpha}
  load: {type: quantity, quantity: load}
"""


class ProcessTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="unlatch_tools_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def begin(self, *arguments, **options):
        process = start(*arguments, **options)

        def end():
            process.kill()
            process.wait()
            if process.stderr:
                process.stderr.close()

        self.addCleanup(end)
        return process

    def run_ok(self, *arguments, code=0):
        """Runs a program. `code` None: any exit code."""
        result = call(*arguments)
        if code is not None:
            self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout[-2000:]}\n{result.stderr[-2000:]}")
        return result

    def run_json(self, *arguments, code=0):
        return json.loads(self.run_ok(*arguments, "--json", "-", code=code).stdout)


def main():
    del sys.argv[1:3]
    unittest.main(verbosity=2)
