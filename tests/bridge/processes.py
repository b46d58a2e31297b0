"""Code shared by the tests with real processes: starting, observing and ending programs, and their sessions."""
import json
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

BIN, SOURCE = Path(sys.argv[1]), Path(sys.argv[2])
UNLATCH, FSW = str(BIN / "unlatch"), str(BIN / "unlatch-fsw")
BOOSTERS = str(SOURCE / "hil/scenarios/boosters/scenario.yaml")
PROBE = str(SOURCE / "bridge/examples/probe.yaml")

HANG = 120  # s; far longer than any step here, so that a hang ends in a failure. No fact depends on wall time.
PATIENT = ["--set", "flight_software.timeout=30"]  # a stalled machine is no dead flight software
SKIPPED = 77  # ctest's SKIP_RETURN_CODE


def run_tests():
    """Exits with the code for "skipped" if a requirement of the tests is missing; unittest alone would report success."""
    arguments = [sys.argv[0], *sys.argv[3:]]
    result = unittest.main(module="__main__", argv=arguments, verbosity=2, exit=False).result
    sys.exit(1 if not result.wasSuccessful() else SKIPPED if result.skipped else 0)


class ProcessTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="unlatch_bridge_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.processes = 0

    def begin(self, *arguments, **options):
        """A program that keeps running; its text for people goes to process.said, a file."""
        self.processes += 1
        said = self.folder / f"said{self.processes}"
        with open(said, "w") as out:
            process = subprocess.Popen(list(map(str, arguments)), stdout=options.pop("stdout", out), stderr=out, text=True,
                                       **options)
        process.said = said

        def end():
            process.kill()
            process.wait()

        self.addCleanup(end)
        return process

    def wait_for(self, process, text):
        """Waits until the program has printed it."""
        for _ in range(HANG * 100):
            if text in process.said.read_text():
                return
            if process.poll() is not None and text not in process.said.read_text():
                break
            time.sleep(0.01)
        self.fail(f"never said {text!r}: {process.said.read_text()[-2000:]}")

    def finish(self, process, code=0):
        """Waits for the end. `code` None: any exit code."""
        process.wait(HANG)
        said = process.said.read_text()
        if code is not None:
            self.assertEqual(process.returncode, code, said[-2000:])
        return said

    def run_ok(self, *arguments, code=0):
        result = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=HANG)
        if code is not None:
            self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout[-2000:]}\n{result.stderr[-2000:]}")
        return result

    def run_json(self, *arguments, code=0):
        return json.loads(self.run_ok(*arguments, "--json", "-", code=code).stdout)
