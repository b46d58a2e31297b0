#!/usr/bin/env python3
"""Facts about `unlatch watch` beside real sessions. Run by ctest in a network namespace of its own."""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time

from processes import BOOSTERS, FSW, HANG, PATIENT, UNLATCH, ProcessTest, main

FLIGHT = ["--pace", "realtime", "--until", "60", *PATIENT]


class Terminal:
    """A program on a terminal, and the text on its screen."""

    def __init__(self, command, columns=100, rows=40):
        import pyte
        self.screen = pyte.Screen(columns, rows)
        self.stream = pyte.ByteStream(self.screen)
        self.raw = b""
        self.child, self.terminal = pty.fork()
        if self.child == 0:
            time.sleep(0.2)  # until the size is set
            os.execv(command[0], list(map(str, command)))
        self.resize(columns, rows)

    def resize(self, columns, rows):
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.screen.resize(rows, columns)

    def read(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not select.select([self.terminal], [], [], 0.05)[0]:
                continue
            try:
                got = os.read(self.terminal, 65536)
            except OSError:
                return
            self.raw += got
            self.stream.feed(got)

    def wait_for(self, pattern):
        end = time.monotonic() + HANG
        while time.monotonic() < end:
            self.read(0.2)
            text = "\n".join(self.screen.display)
            if re.search(pattern, text):
                return text
        raise AssertionError(f"{pattern} never stood on the screen:\n" + "\n".join(self.screen.display))

    def close(self):
        os.kill(self.child, signal.SIGKILL)
        os.waitpid(self.child, 0)
        os.close(self.terminal)


class WatchTest(ProcessTest):
    def fly(self, transport, *arguments):
        self.begin(FSW, "--transport", transport)
        return self.begin(UNLATCH, "hil", BOOSTERS, "--transport", transport, *FLIGHT, *arguments)

    def watch(self, *arguments):
        """Yields its lines of JSON as they arrive."""
        process = subprocess.Popen([UNLATCH, "watch", *arguments, "--json", "-"], stdout=subprocess.PIPE,
                                   stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(lambda: (process.kill(), process.wait(), process.stdout.close()))
        return map(json.loads, process.stdout)

    def find(self, lines, wanted):
        end = time.monotonic() + HANG
        for line in lines:
            if wanted(line):
                return line
            self.assertLess(time.monotonic(), end, f"never seen; the last look: {json.dumps(line)[:3000]}")
        self.fail("watch has ended")

    def check_look(self, transport):
        self.fly(transport)
        look = self.find(self.watch("--transport", transport), lambda look: look["knows_scenario"] and "health" in look
                         and look["reactions_tick"] >= 0 and look["status"] == "running" and look["clearance"]
                         and look["messages"]["State"]["per_second"] > 0)
        self.assertEqual(look["scenario"], "boosters")
        self.assertIn(look["joints"]["nose1"]["mode"], ("tied", "hinge", "slider", "free"))
        self.assertEqual(len(look["joints"]["nose4"]["reaction"]), 6)
        self.assertEqual(len(look["clearance"]), 10)
        self.assertEqual([(one["name"], one["status"]) for one in look["participants"]], [("fsw", "ready")])
        self.assertGreater(look["participants"][0]["answered_tick"], 0)
        self.assertGreater(look["health"]["step_ns"]["max"], 0)
        self.assertEqual(look["malformed"], 0)

    def test_everything_is_known_over_dds_to_who_comes_late(self):
        self.check_look("dds")

    def test_everything_is_known_over_lcm_to_who_comes_late(self):
        self.check_look("lcm")

    def test_reactions_are_those_of_the_run(self):
        """Runs in lockstep to a tick before any event, then compares the last observation with the run's own result."""
        lines = self.watch("--transport", "dds")
        simulator = subprocess.Popen([UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "lockstep", "--until", "0.2", *PATIENT,
                                      "--start-timeout", "60", "--json", "-"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                     text=True)
        self.addCleanup(lambda: (simulator.kill(), simulator.wait(), simulator.stdout.close()))
        self.find(lines, lambda look: "nose4" in look["joints"])  # they are connected; the run waits for its flight software
        self.begin(FSW, "--transport", "dds")
        report = json.loads(simulator.communicate(timeout=HANG)[0])
        look = self.find(lines, lambda look: look["status"] == "done" and look["reactions_tick"] == 200 and look["knows_scenario"])
        self.assertEqual(look["lost"], 0)
        sample = report["samples"][0]["reactions"]
        for joint, reaction in sample.items():
            seen = dict(zip(("x", "y", "z", "rot_x", "rot_y", "rot_z"), look["joints"][joint]["reaction"]))
            self.assertEqual([seen[row] for row in reaction["rows"]], reaction["lambda"])

    def test_a_killed_simulator_is_reported_and_the_next_one_followed(self):
        lines = self.watch("--transport", "dds")
        first = self.fly("dds")
        before = self.find(lines, lambda look: look["status"] == "running" and look["tick"] > 100)
        first.kill()
        self.find(lines, lambda look: any("stopped sending" in notice["text"] for notice in look["notices"]))
        self.fly("dds", "--start-timeout", "60")
        after = self.find(lines, lambda look: look["session"] != before["session"] and look["tick"] > 100)
        self.assertTrue(any("now follows" in notice["text"] for notice in after["notices"]))

    def test_once_shows_one_look_and_leaves(self):
        self.fly("dds")
        text = self.run_ok(UNLATCH, "watch", "--transport", "dds", "--once").stdout
        for part in ("boosters", "nose1", "Clearance", "core – booster1", "Step", "Messages", "fsw"):
            self.assertIn(part, text)
        self.run_ok(UNLATCH, "watch", "--transport", "dds", "--domain", "77", "--once", "--for", "0.5", code=1)

    def test_without_a_terminal_it_is_a_line_a_second(self):
        self.fly("lcm")
        result = self.run_ok(UNLATCH, "watch", "--transport", "lcm", "--for", "4")
        lines = result.stdout.splitlines()
        self.assertIn(len(lines), range(2, 7))
        self.assertNotIn("\033", result.stdout)
        self.assertRegex(lines[-1], r"^t \d+\.\d+ s, tick \d+, .*nose1 ")

    def test_a_terminal_shows_it_in_whatever_size_and_is_given_back(self):
        try:
            import pyte  # noqa: F401
        except ImportError:
            self.skipTest("python3-pyte is not installed")
        self.fly("dds")
        terminal = Terminal([UNLATCH, "watch", "--transport", "dds"])
        try:
            text = terminal.wait_for(r"(?s)nose4.*core – booster1.*Step +\[.*Messages +State")
            self.assertIn("boosters", text)
            self.assertIn("running", text)
            for columns, rows in ((60, 16), (30, 5), (120, 50)):
                terminal.resize(columns, rows)
                terminal.read(0.7)
                self.assertIn("unlatch watch", terminal.screen.display[0])
            terminal.wait_for(r"(?s)nose4.*booster3 – booster4.*fsw")
            self.assertFalse(termios.tcgetattr(terminal.terminal)[3] & termios.ECHO)
            os.write(terminal.terminal, b"q")
            terminal.read(3)
            self.assertIn(b"\033[?1049l", terminal.raw[-2000:])
            self.assertIn(b"\033[?25h", terminal.raw[-2000:])
            self.assertEqual(os.waitpid(terminal.child, os.WNOHANG)[1], 0)
        finally:
            try:
                terminal.close()
            except (ChildProcessError, ProcessLookupError):
                pass


if __name__ == "__main__":
    main()
