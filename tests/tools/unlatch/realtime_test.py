#!/usr/bin/env python3
"""Facts about the cyclic thread from the view of the operating system, and about `unlatch preflight`. Run by ctest:

    realtime_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]

Exit code 77, and the reason, if the machine does not allow the check of a fact.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

from processes import BOOSTERS, HANG, PATIENT, REFERENCE, SANITIZED, UNLATCH


def call(*arguments, **options):
    return subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=HANG, **options)


class RealtimeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="unlatch_realtime_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_hil(self, *arguments, scenario=BOOSTERS, code=0, before=(), **options):
        result = call(*before, UNLATCH, "hil", scenario, "--transport", "inproc", "--pace", "realtime", "--json", "-",
                      *PATIENT, *arguments, **options)
        report = json.loads(result.stdout) if result.stdout else None
        if code == 0:  # on a slow machine commands are late, and a requirement may not be met
            self.assertEqual(report and report["status"], "ok", result.stderr[-2000:])
        else:
            self.assertEqual(result.returncode, code, result.stderr[-2000:])
        return report, result.stderr

    @unittest.skipIf(SANITIZED, "LeakSanitizer does not work under strace")
    def test_between_deadlines_there_is_no_system_call_but_the_clock(self):
        if not shutil.which("strace"):
            self.skipTest("strace is not installed")
        trace = self.folder / "trace"
        if call("strace", "-f", "-o", trace, "true").returncode != 0:
            self.skipTest("strace may not trace here")
        # For any cost of the tracer, after an overrun the next tick waits for its deadline again.
        report, _ = self.run_hil("--until", "1", "--overruns", "slip", before=["strace", "-f", "--decode-pids=comm", "-o", trace])
        calls = re.findall(r"^\d+<unlatch-cyclic>\s+(.*)", trace.read_text(errors="replace"), re.M)
        names = [re.match(r"\w+", text).group() for text in calls if text[0].isalpha()]  # without the ends of unfinished calls
        # The thread's counts are read before the first tick, and when an overrun is found.
        cycle = names[names.index("getrusage") + 1:]
        sleeps = [i for i, name in enumerate(cycle) if name == "clock_nanosleep"]
        cycle = cycle[:sleeps[-1]]
        overruns = report["timing"]["overruns"]
        print(f"{report['ticks']} ticks, {len(cycle)} system calls, {overruns} overruns")
        self.assertEqual(report["ticks"], 1000)
        self.assertGreater(len(sleeps), report["ticks"] / 2)
        self.assertEqual(set(cycle) - {"clock_nanosleep", "getrusage", "clock_gettime"}, set())
        self.assertLessEqual(cycle.count("getrusage"), overruns)

    def test_ticks_come_from_an_eventfd(self):
        event = os.eventfd(0)
        self.addCleanup(os.close, event)
        done = threading.Event()

        def pulse():
            while not done.wait(0.0005):
                os.eventfd_write(event, 1)

        thread = threading.Thread(target=pulse)
        thread.start()
        try:
            report, _ = self.run_hil("--until", "0.2", "--tick-source", f"fd:{event}", pass_fds=[event])
        finally:
            done.set()
            thread.join()
        self.assertEqual((report["status"], report["ticks"]), ("ok", 200))
        self.assertEqual(report["timing"]["wakeup_ns"]["count"], 200)

    def test_a_tick_source_that_ends_is_named(self):
        fifo = self.folder / "ticks"
        os.mkfifo(fifo)

        def pulse():
            with open(fifo, "wb", buffering=0) as end:
                time.sleep(0.2)
                end.write(b"." * 10)

        thread = threading.Thread(target=pulse)
        thread.start()
        report, _ = self.run_hil("--until", "1", "--tick-source", fifo, scenario=REFERENCE, code=1)
        thread.join()
        self.assertEqual(report["status"], "aborted")
        self.assertIn("its other end was closed", report["message"])
        result = call(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "realtime", "--tick-source", "fd:99")
        self.assertEqual(result.returncode, 2)
        self.assertIn("fd:99", result.stderr)

    def test_overruns_end_in_the_policy_that_the_command_line_names(self):
        # No machine steps the boosters in a microsecond.
        tiny = ["--dt", "0.000001", "--until", "0.001"]
        report, _ = self.run_hil(*tiny, "--overruns", "fail", scenario=REFERENCE, code=1)
        self.assertEqual(report["status"], "aborted")
        self.assertIn("policy: fail", report["message"])
        self.assertEqual(report["timing"]["overruns"], 1)
        report, _ = self.run_hil(*tiny, "--overruns", "catch_up=3", scenario=REFERENCE, code=1)
        self.assertIn("catch_up, at most 3 ticks", report["message"])
        report, _ = self.run_hil(*tiny, "--overruns", "slip", scenario=REFERENCE)
        timing = report["timing"]
        self.assertEqual(report["ticks"], 1000)
        self.assertGreater(timing["slipped_ns"], 0)
        self.assertEqual(sum(timing["overrun_causes"].values()), timing["overruns"])
        self.assertEqual(len(timing["worst_overruns"]), 16)
        for name in ("step_ns", "wakeup_ns"):
            self.assertEqual(sum(count for _, count in timing[name]["histogram"]), 1000)

    def test_every_ticks_account_is_in_the_recording_if_asked(self):
        log = self.folder / "run.log"
        self.run_hil("--until", "0.1", "--tick-times", "--log", log)
        self.assertEqual(log.read_bytes().count(b"UNLATCH_LOG_TIMING"), 100)
        result = call(UNLATCH, "replay", log, "--json", "-")
        self.assertTrue(json.loads(result.stdout)["replay"]["agrees"])

    @unittest.skipIf(SANITIZED, "a sanitizer locks no memory, and says that it did")
    def test_without_privileges_the_run_says_what_it_lacks(self):
        if os.geteuid() != 0 or not shutil.which("setpriv"):
            self.skipTest("needs root, to give its privileges up, and setpriv")
        report, said = self.run_hil("--until", "0.05", before=["setpriv", "--bounding-set=-all", "--inh-caps=-all",
                                                               "prlimit", "--rtprio=0", "--memlock=65536"])
        self.assertEqual(report["status"], "ok")
        self.assertIn("no SCHED_FIFO", said)
        self.assertIn("no locked memory", said)
        self.assertTrue(any("no SCHED_FIFO" in text for text in report["refused"]), report["refused"])

    def test_preflight_says_what_everything_costs_and_how_to_mend_it(self):
        result = call(UNLATCH, "preflight", "--cpu", "0", "--json", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual(report["schema"], 1)
        names = [check["name"] for check in report["checks"]]
        for name in ("kernel", "governor", "isolated CPUs", "timer resolution", "locked memory", "real-time priority",
                     "transparent huge pages", "interruptions", "below the kernel"):
            self.assertIn(name, names)
            self.assertIn(name, result.stderr)
        for check in report["checks"]:
            self.assertIn(check["verdict"], ("good", "costs", "missing", "unknown"))
            self.assertTrue(check["found"])
            if check["verdict"] in ("costs", "missing"):
                self.assertTrue(check["cost"] and check["mend"], check)

    def test_strict_preflight_fails_unless_everything_is_good(self):
        strict = call(UNLATCH, "preflight", "--strict", "--no-trial", "--json", "-")
        report = json.loads(strict.stdout)
        self.assertEqual(strict.returncode, 0 if report["verdict"] == "good" else 3)
        self.assertEqual([check["found"] for check in report["checks"] if check["name"] == "interruptions"], ["not tried"])

    def test_preflight_names_a_cpu_that_there_is_not(self):
        result = call(UNLATCH, "preflight", "--cpu", "1000")
        self.assertEqual(result.returncode, 2)
        self.assertIn("CPU 1000 does not exist", result.stderr)


if __name__ == "__main__":
    del sys.argv[1:3]
    program = unittest.main(verbosity=2, exit=False)
    if not program.result.wasSuccessful():
        sys.exit(1)
    if program.result.skipped:
        print("skipped:", program.result.skipped[0][1])
        sys.exit(77)
