#!/usr/bin/env python3
"""Facts about recordings and checkpoints, with real processes, real kills and real full disks:

    recordings_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]

UNLATCH_KILLS: number of killed processes (60).
"""

import concurrent.futures
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest

from processes import BOOSTERS, HANG, PATIENT, REFERENCE, SANITIZED, SCENARIOS, UNLATCH, ProcessTest, call, main
from recording_files import read_events, read_ticks

KILLS = int(os.environ.get("UNLATCH_KILLS", 60))
ENDLESS = ["--until", "100000"]


def in_mounts_of_its_own(script, *arguments):
    """Runs a shell script that may mount file systems privately; None if that is not allowed."""
    for how in ("-m", "-rm"):
        if subprocess.run(["unshare", how, "true"], capture_output=True).returncode == 0:
            return subprocess.run(["unshare", how, "sh", "-c", script, "sh", *map(str, arguments)],
                                  capture_output=True, text=True, timeout=HANG)
    return None


class RecordingsTest(ProcessTest):

    # --- Killed -------------------------------------------------------------------------------------------------

    def kill_one(self, number, seed):
        """Kills a recording run at a random moment. Returns the ticks recorded, after checking the file."""
        log, moment = self.folder / f"{number}.log", random.Random(seed)
        if number % 8 == 0:  # in the loop, in real time
            arguments = ["hil", BOOSTERS, "--transport", "inproc", "--pace", "realtime", *ENDLESS, *PATIENT]
        else:  # as fast as possible: more data are on the way to the file
            arguments = ["run", SCENARIOS / "tree3/reference.yaml", *ENDLESS]
        process = subprocess.Popen([UNLATCH, *map(str, arguments), "--log", str(log)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        size = moment.randrange(40_000 if number % 8 == 0 else 200_000)
        if number % 8 == 1:  # at its beginning
            size = 0
        while number % 8 != 2 and not (log.exists() and log.stat().st_size >= size):
            self.assertIsNone(process.poll())
            time.sleep(0.0005)
        time.sleep(moment.uniform(0, 0.02) if size else 0)
        process.kill()
        self.assertEqual(process.wait(HANG), -signal.SIGKILL, "it was killed, not done")
        if not log.exists():
            return "before the file was there"
        events, _ = read_events(log)
        if not events:
            result = call(UNLATCH, "replay", log)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertRegex(result.stderr, "is empty|ends before its header is complete")
            return "before its header was"
        self.assertEqual(events[0][0], "UNLATCH_LOG_HEADER")
        ticks = read_ticks(log)
        self.assertEqual(ticks, list(range(len(ticks))), "no gap")
        report = self.run_json(UNLATCH, "replay", log, code=None)  # 1: requirements were not reached
        self.assertEqual(report["status"], "truncated")
        self.assertEqual(report["replay"], {"ticks_compared": len(ticks), "agrees": True})
        log.unlink()
        return "in its first ticks" if len(ticks) < 100 else "well under way"

    def test_killed_at_any_moment_everything_up_to_the_last_complete_record_is_there(self):
        seed = int.from_bytes(os.urandom(4), "big")
        print(f"seed {seed}, {KILLS} kills")
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            outcomes = list(pool.map(self.kill_one, range(KILLS), range(seed, seed + KILLS)))
        for outcome in sorted(set(outcomes)):
            print(f"  {outcomes.count(outcome):4} killed {outcome}")
        self.assertIn("well under way", outcomes)

    # --- No space, no permission --------------------------------------------------------------------------------

    def check_cut_short(self, result, log, report_file, replay):
        """Checks a run whose recording had no space: reported at once and at the end, with the result of the whole run."""
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn(f"{log}: cannot be written", result.stderr)
        report = json.loads(report_file.read_text())
        self.assertEqual((report["status"], report["ticks"]), ("ok", 3000))
        self.assertEqual(replay["status"], "truncated")
        self.assertTrue(replay["replay"]["agrees"])
        self.assertGreater(replay["replay"]["ticks_compared"], 100)
        self.assertLess(replay["replay"]["ticks_compared"], 3000)

    def test_a_full_disk_cuts_a_recording_short_and_says_so(self):
        disk, report, replay = self.folder / "disk", self.folder / "run.json", self.folder / "replay.json"
        disk.mkdir()
        script = ('mount -t tmpfs -o size=200k unlatch "$1" || exit 99; shift; log=$1 report=$2 replay=$3; shift 3; '
                  '"$@" --log "$log" --json "$report"; code=$?; "$0" replay "$log" --json "$replay" >/dev/null; exit $code')
        for arguments in (["run", REFERENCE], ["hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", *PATIENT]):
            log = disk / "full.log"
            result = in_mounts_of_its_own(script.replace('"$0"', f'"{UNLATCH}"'), disk, log, report, replay, UNLATCH,
                                          *arguments, "--until", "3")
            if result is None or result.returncode == 99:
                self.skipTest("this machine allows no mounts")
            self.assertIn("No space left on device", result.stderr)
            self.check_cut_short(result, log, report, json.loads(replay.read_text()))

    def test_a_file_at_its_size_limit_is_like_a_full_disk(self):
        log, report = self.folder / "limited.log", self.folder / "run.json"
        result = subprocess.run([UNLATCH, "run", REFERENCE, "--until", "3", "--log", str(log), "--json", str(report)],
                                capture_output=True, text=True, timeout=HANG,
                                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)))
        self.assertIn("File too large", result.stderr)
        self.assertEqual(log.stat().st_size, 300_000)
        self.check_cut_short(result, log, report, self.run_json(UNLATCH, "replay", log))

    def test_a_read_only_folder_is_an_error_before_the_run(self):
        disk = self.folder / "disk"
        disk.mkdir()
        script = 'mount -t tmpfs -o ro unlatch "$1" || exit 99; shift; exec "$@"'
        for option in (["--log", disk / "x"], ["--checkpoint", "0", disk / "x"]):
            result = in_mounts_of_its_own(script, disk, UNLATCH, "run", REFERENCE, *option)
            if result is None or result.returncode == 99:
                self.skipTest("this machine allows no mounts")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn(f"{disk}/x: cannot be created: Read-only file system", result.stderr)
            self.assertEqual(result.stdout, "")

    # --- Checkpoints --------------------------------------------------------------------------------------------

    def test_a_run_taken_up_again_is_the_same_to_the_last_bit(self):
        whole, rest, again = (self.folder / name for name in ("whole.log", "rest.log", "again.json"))
        for scenario, until in ((REFERENCE, 2), (SCENARIOS / "array/reference.yaml", 2), (BOOSTERS, 2)):
            seed = int.from_bytes(os.urandom(4), "big")
            print(f"seed {seed}")
            times = sorted(random.Random(seed).randrange(0, 1000 * until + 1) / 1000 for _ in range(3))
            checkpoints = [self.folder / f"{i}.checkpoint" for i in range(3)]
            options = [word for time, file in zip(times, checkpoints) for word in ("--checkpoint", time, file)]
            report = self.run_json(UNLATCH, "run", scenario, "--until", until, "--log", whole, *options)
            for t, file in zip(times, checkpoints):
                # The checkpoints of a resumed run are the same files.
                last = ["--checkpoint", times[2], again] if t < times[2] else []
                resumed = self.run_json(UNLATCH, "run", scenario, "--until", until, "--resume", file, "--log", rest, *last)
                self.assertEqual((resumed["ticks"], resumed["hash"]), (report["ticks"], report["hash"]))
                self.assertEqual(resumed["samples"], report["samples"])
                self.assertEqual(resumed["events"], [e for e in report["events"] if e["t"] > t])
                if last:
                    self.assertEqual(again.read_bytes(), checkpoints[2].read_bytes())
                difference = self.run_json(UNLATCH, "diff", whole, rest)
                self.assertEqual((difference["result"], difference["first_tick"]), ("same", round(t * 1000)))
                self.assertTrue(self.run_json(UNLATCH, "replay", rest)["replay"]["agrees"])

    def test_a_checkpoint_that_finds_no_room_leaves_the_old_one_alone(self):
        checkpoint = self.folder / "run.checkpoint"
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "1", "--checkpoint", "0.5", checkpoint)
        before = checkpoint.read_bytes()
        result = subprocess.run([UNLATCH, "run", REFERENCE, "--until", "1", "--checkpoint", "0.7", str(checkpoint)],
                                capture_output=True, text=True, timeout=HANG,
                                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertEqual(checkpoint.read_bytes(), before)
        self.assertEqual([file.name for file in self.folder.iterdir()], [checkpoint.name], "nothing half-written")

    def test_foreign_checkpoints_exit_2_and_say_why(self):
        checkpoint, log = self.folder / "run.checkpoint", self.folder / "run.log"
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "1", "--checkpoint", "0.5", checkpoint, "--log", log)
        for arguments, why in (
            ([SCENARIOS / "array/reference.yaml", "--resume", checkpoint], "is of scenario 'boosters'"),
            ([REFERENCE, "--dt", "0.002", "--resume", checkpoint], "a step of 0.001 s"),
            ([REFERENCE, "--set", "bodies.core.mass=99000", "--resume", checkpoint], "the model differs"),
            ([REFERENCE, "--until", "0.4", "--resume", checkpoint], "after the end of this run"),
            ([REFERENCE, "--sample", "0.4", "--resume", checkpoint], "is not within the run"),
            ([REFERENCE, "--resume", log], "is a recording, not a checkpoint"),
            ([REFERENCE, "--resume", REFERENCE], "is not a recording"),
            ([REFERENCE, "--checkpoint", "5", checkpoint], "is not within the run"),
        ):
            self.assertIn(why, self.run_ok(UNLATCH, "run", *arguments, code=2).stderr)
        self.assertIn("is a checkpoint, not a recording", self.run_ok(UNLATCH, "replay", checkpoint, code=2).stderr)

    # --- diff ---------------------------------------------------------------------------------------------------

    def test_diff_answers_scripts_and_people(self):
        a, b = self.folder / "a.log", self.folder / "b.log"
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.2", "--log", a)
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.2", "--log", b)
        self.assertIn("the same bits at all 201 ticks", self.run_ok(UNLATCH, "diff", a, b).stdout)
        self.assertEqual(self.run_json(UNLATCH, "diff", a, b)["result"], "same")
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.1", "--log", b)
        text = self.run_ok(UNLATCH, "diff", a, b, code=1).stdout
        for part in ("the same bits at all 101 ticks", "up to tick 200", "up to tick 100"):
            self.assertIn(part, text)
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.2", "--dt", "0.002", "--log", b)
        self.assertIn("different steps", self.run_ok(UNLATCH, "diff", a, b, code=2).stderr)
        self.run_ok(UNLATCH, "diff", a, self.folder / "missing", code=2)

    def test_diff_names_the_command_that_one_of_two_runs_did_not_hear(self):
        logs = [self.folder / name for name in ("first.log", "second.log", "alone.log")]
        for log, pace in zip(logs, ("lockstep", "lockstep", "fast")):
            self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", pace, "--until", "1.5", *PATIENT,
                          "--log", log)
        self.assertEqual(self.run_json(UNLATCH, "diff", logs[0], logs[1])["result"], "same")
        report = self.run_json(UNLATCH, "diff", logs[0], logs[2], code=1)
        self.assertEqual(report["result"], "different")
        difference = report["difference"]
        self.assertEqual(difference["fields_tick"], difference["tick"])
        self.assertTrue(difference["fields"])
        self.assertLess(report["first_input"]["tick"], difference["tick"])
        printed = [entry["channel"] for entry in difference["inputs"] if not entry["same"]]
        self.assertIn(report["first_input"]["channel"], printed)
        self.assertEqual({change["cause"] for change in difference["changes"][0]}, {"command"})
        self.assertEqual(difference["changes"][1], [], "no participant at pace fast")
        text = self.run_ok(UNLATCH, "diff", logs[0], logs[2], code=1).stdout
        self.assertRegex(text, r"first difference at tick \d+ \(t = ")
        self.assertIn(" ULP", text)

    # --- Length -------------------------------------------------------------------------------------------------

    def measure(self, *arguments):
        """Returns the peak memory of a process, bytes."""
        process = subprocess.Popen(list(map(str, arguments)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 0)
        return usage.ru_maxrss * 1024

    @unittest.skipIf(SANITIZED, "a sanitizer's program is none for valgrind")
    def test_a_replay_is_clean_under_valgrind(self):
        if shutil.which("valgrind") is None:
            self.skipTest("valgrind is not installed (tools/setup dev)")
        log = self.folder / "run.log"
        self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.8", "--log", log)  # releases and contacts are before
        said = self.run_ok("valgrind", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite,indirect,possible",
                           UNLATCH, "replay", log).stderr
        print(re.search("ERROR SUMMARY.*", said).group())

    @unittest.skipIf(SANITIZED, "a sanitizer keeps what was freed")
    def test_memory_does_not_grow_with_the_length_of_a_recording(self):
        log = self.folder / "long.log"
        scenario = SCENARIOS / "tree20/reference.yaml"
        peaks = {}
        for ticks in (500, 10_000):
            options = ["--dt", "0.001", "--until", ticks * 0.001]
            recorded = self.measure(UNLATCH, "run", scenario, *options, "--log", log)
            replayed = self.measure(UNLATCH, "replay", log)
            compared = self.measure(UNLATCH, "diff", log, log)
            peaks[ticks] = (recorded, replayed, compared)
            size = log.stat().st_size
            print(f"  {ticks} ticks, {size} bytes: recorded in {recorded >> 20} MiB, replayed in {replayed >> 20} MiB, "
                  f"compared in {compared >> 20} MiB")
        slack = 2 << 20  # variations of the allocator, and parts of the rings that a short run never uses
        self.assertGreater(log.stat().st_size, slack)
        for short, long in zip(peaks[500], peaks[10_000]):
            self.assertLess(long, short + slack)


if __name__ == "__main__":
    main()
