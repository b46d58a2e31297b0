#!/usr/bin/env python3
"""Facts about sessions whose processes, clock, processors and disks fail, with real processes. Run by ctest in a network namespace:

    chaos_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]

UNLATCH_CYCLES: in how many sessions something is killed or stopped (6). A thousand, by hand:

    UNLATCH_CYCLES=1000 PYTHONPATH=tests/support tests/support/netns.sh python3 tests/tools/unlatch/chaos_test.py build/release/bin . ChaosTest.test_sessions_survive_what_befalls_their_processes
"""

import collections
import json
import os
import random
import signal
import subprocess
import threading
import time

from processes import BOOSTERS, FSW, HANG, PATIENT, REFERENCE, UNLATCH, ProcessTest, main
from recording_files import read_events, read_ticks

CYCLES = int(os.environ.get("UNLATCH_CYCLES", 6))
TIMEOUT = 0.2  # s of wall time after which the policy acts
ENDINGS = (0, 1, -signal.SIGINT)  # the last one if it was interrupted before it began
POLICIES = ("hold", "zero", "safe", "pause", "abort", "evict")


class Session:
    """A simulator, its flight software and a logger, over real middleware; each can be started again."""

    def __init__(self, test, number, draw):
        self.test, self.folder = test, test.folder / str(number)
        self.folder.mkdir()
        self.transport = ["--transport", draw.choice(("dds", "lcm", "udp"))]
        self.pace, self.policy = draw.choice(("lockstep", "realtime")), draw.choice(POLICIES)
        self.until = draw.randrange(1, 6)
        self.starts = collections.Counter()
        self.running = {}

    def start(self, name):
        self.starts[name] += 1
        stem = self.folder / f"{name}{self.starts[name]}"
        arguments = {
            "simulator": [UNLATCH, "hil", BOOSTERS, "--pace", self.pace, "--until", self.until, "--log", f"{stem}.log",
                          "--set", f"flight_software.policy={self.policy}", "--set", f"flight_software.timeout={TIMEOUT}"],
            "fsw": [FSW, "--patience", "3"],
            "logger": [UNLATCH, "log", "--out", f"{stem}.log"],
        }[name]
        with open(f"{stem}.said", "w", encoding="utf-8") as said:
            self.running[name] = subprocess.Popen([*map(str, arguments), *self.transport], stdout=said, stderr=said)

    def is_running(self, name):
        return self.running[name].poll() is None

    def get_log(self, name):
        return self.folder / f"{name}{self.starts[name]}.log"

    def get_said(self, name):
        return (self.folder / f"{name}{self.starts[name]}.said").read_text(encoding="utf-8")

    def kill(self, name):
        self.running[name].kill()
        return self.running[name].wait(HANG)

    def interrupt(self, name):
        """Interrupts a process like a user, at any moment."""
        if self.is_running(name):
            self.running[name].send_signal(signal.SIGINT)
        return self.running[name].wait(HANG)

    def close(self):
        for process in self.running.values():
            process.kill()
            process.wait()


class ChaosTest(ProcessTest):

    # --- Processes ----------------------------------------------------------------------------------------------

    def check_recording(self, session, was_killed):
        """Checks that the recording is complete, replays, and contains no other policy than the scenario's."""
        log = session.get_log("simulator")
        events, rest = read_events(log) if log.exists() else ([], False)
        if not events:
            self.assertTrue(was_killed or "takes part" not in session.get_said("simulator"), session.get_said("simulator"))
            return "before its recording began"
        ticks = read_ticks(log)
        self.assertEqual(ticks, list(range(len(ticks))), "no gap")
        self.assertTrue(was_killed or not rest)
        report = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertTrue(report["replay"]["agrees"], report)
        self.assertEqual(report["replay"]["ticks_compared"], len(ticks) if report["status"] == "truncated" else report["ticks"] + 1)
        self.assertEqual(report["status"] == "truncated", was_killed and events[-1][0] != "UNLATCH_LOG_END", report)
        policies = {notice["name"] for notice in report["notices"] if notice["name"].startswith("policy.")}
        self.assertLessEqual(policies, {f"policy.{session.policy}"})
        return "with its policy applied" if policies else "undisturbed as far as it knows"

    def check_logger(self, session):
        """Checks that the logger's file is complete."""
        if session.get_log("logger").exists():
            read_events(session.get_log("logger"))

    def disturb(self, session, draw):
        """Disturbs one of the processes; returns a description."""
        name = draw.choice(("simulator", "fsw", "logger"))
        time.sleep(draw.uniform(0, 0.7))
        if not session.is_running(name):
            return f"{name} was done"
        if draw.random() < 0.3:
            session.running[name].send_signal(signal.SIGSTOP)
            time.sleep(draw.uniform(0, 3 * TIMEOUT))
            session.running[name].send_signal(signal.SIGCONT)
            return f"{name} stood still"
        self.assertIn(session.kill(name), (-signal.SIGKILL, 0, 1))
        if name == "simulator":
            self.check_recording(session, was_killed=True)
        elif name == "logger":
            self.check_logger(session)
        time.sleep(draw.uniform(0, 2 * TIMEOUT))
        session.start(name)
        return f"{name} was killed"

    def run_cycle(self, number, seed):
        draw = random.Random(seed)
        session = Session(self, number, draw)
        try:
            names = ["simulator", "fsw", "logger"]
            draw.shuffle(names)
            for name in names:
                session.start(name)
                time.sleep(draw.choice((0, 0.05)))
            what = self.disturb(session, draw)
            time.sleep(draw.uniform(0, 0.5))
            code = session.interrupt("simulator")
            self.assertIn(code, ENDINGS, session.get_said("simulator"))
            outcome = self.check_recording(session, was_killed=code < 0)
            # A process that did not receive the end stops by itself (the flight software), or is stopped (the logger).
            self.assertIn(session.running["fsw"].wait(HANG), (0, 1), session.get_said("fsw"))
            self.assertIn(session.interrupt("logger"), ENDINGS, session.get_said("logger"))
            self.check_logger(session)
        finally:
            session.close()
        return f"{what}; ended {outcome}"

    def test_sessions_survive_what_befalls_their_processes(self):
        seed = int.from_bytes(os.urandom(4), "big")
        print(f"seed {seed}, {CYCLES} cycles")
        outcomes = collections.Counter()
        for number in range(CYCLES):
            with self.subTest(cycle=number, seed=seed + number):
                outcomes[self.run_cycle(number, seed + number)] += 1
        for outcome, count in sorted(outcomes.items()):
            print(f"  {count:4} {outcome}")
        self.assertEqual(sum(outcomes.values()), CYCLES)
        if CYCLES >= 50:  # in fewer cycles it may not have occurred
            self.assertTrue(any("policy applied" in outcome for outcome in outcomes), "no policy has ever acted")

    # --- Clock --------------------------------------------------------------------------------------------------

    def test_a_clock_that_stops_ends_the_run_and_its_recording_replays(self):
        event = os.eventfd(0)
        self.addCleanup(os.close, event)
        log, report = self.folder / "run.log", self.folder / "run.json"
        process = subprocess.Popen([UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "realtime", "--until", "10",
                                    *PATIENT, "--tick-source", f"fd:{event}", "--log", str(log), "--json", str(report)],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, pass_fds=[event])
        for _ in range(200):  # and no more
            os.eventfd_write(event, 1)
            time.sleep(0.0005)
        self.assertEqual(process.wait(HANG), 1)
        said = json.loads(report.read_text(encoding="utf-8"))
        self.assertEqual(said["status"], "aborted")
        self.assertIn("the tick source has failed", said["message"])
        again = self.run_json(UNLATCH, "replay", log, code=None)  # 1: a requirement was not reached
        self.assertTrue(again["replay"]["agrees"])
        self.assertEqual(again["ticks"], said["ticks"])

    # --- Processors ---------------------------------------------------------------------------------------------

    def check_starved(self, report, log, overruns):
        self.assertGreater(report["timing"]["overruns"], 0)
        self.assertEqual(report["replay"]["agrees"], True)
        self.assertEqual(self.run_json(UNLATCH, "replay", log)["hash"], report["hash"])
        if overruns == "fail":
            self.assertEqual(report["status"], "aborted")
        else:
            self.assertEqual((report["status"], report["ticks"]), ("ok", 2000))
        self.assertEqual(report["timing"]["slipped_ns"] > 0, overruns == "slip")

    def test_a_simulator_that_stood_still_goes_on_as_its_policy_says(self):
        for overruns in ("fail", "catch_up", "slip", "skip_output"):
            log, report = self.folder / "run.log", self.folder / "run.json"
            process = subprocess.Popen([UNLATCH, "hil", REFERENCE, "--transport", "inproc", "--pace", "realtime", "--until", "2",
                                        "--overruns", overruns, "--log", str(log), "--json", str(report)],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while process.poll() is None:  # repeatedly: its start time is unknown
                process.send_signal(signal.SIGSTOP)
                time.sleep(0.05)
                process.send_signal(signal.SIGCONT)
                time.sleep(0.05)
            self.assertEqual(process.wait(HANG), 1 if overruns == "fail" else 0)
            self.check_starved(json.loads(report.read_text(encoding="utf-8")), log, overruns)

    def test_a_simulator_among_hogs_loses_no_tick(self):
        """Runs at ordinary priority, on one processor that four others use as well."""
        log, report = self.folder / "run.log", self.folder / "run.json"
        cpu = str(min(os.sched_getaffinity(0)))
        hogs = [subprocess.Popen(["taskset", "-c", cpu, "sh", "-c", "while :; do :; done"]) for _ in range(4)]
        try:
            result = subprocess.run(["taskset", "-c", cpu, "prlimit", "--rtprio=0", "setpriv", "--bounding-set=-all", "--inh-caps=-all",
                                     UNLATCH, "hil", REFERENCE, "--transport", "inproc", "--pace", "realtime", "--until", "2",
                                     "--log", str(log), "--json", str(report)], capture_output=True, text=True, timeout=HANG)
        finally:
            for hog in hogs:
                hog.kill()
                hog.wait()
        self.assertEqual(result.returncode, 0, result.stderr[-2000:])
        self.check_starved(json.loads(report.read_text(encoding="utf-8")), log, "catch_up")

    # --- Disks --------------------------------------------------------------------------------------------------

    def test_a_logger_whose_disk_is_full_says_so_and_disturbs_nobody(self):
        heard, log = self.folder / "heard.log", self.folder / "run.log"
        logger = subprocess.Popen(["prlimit", "--fsize=100000", UNLATCH, "log", "--transport", "lcm", "--out", str(heard)],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(logger.kill)
        while "waits for a session" not in logger.stderr.readline():
            pass
        flight_software = threading.Thread(target=subprocess.run, args=([FSW, "--transport", "lcm"],),
                                           kwargs={"capture_output": True, "timeout": HANG})
        flight_software.start()
        report = self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", "lcm", "--pace", "lockstep", "--until", "0.5", *PATIENT,
                               "--log", log)
        flight_software.join()
        said = logger.communicate(timeout=HANG)[1]
        self.assertEqual(logger.returncode, 3, said)
        self.assertIn("File too large", said)
        read_events(heard)
        self.assertEqual(report["status"], "ok")
        self.assertTrue(report["replay"]["agrees"])


if __name__ == "__main__":
    main()
