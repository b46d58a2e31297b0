#!/usr/bin/env python3
"""Effects that any program of the network can have on the simulator, with real sockets, pipes and signals. Run by ctest in a network
namespace:

    wire_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import os
import re
import shlex
import signal
import socket
import struct
import subprocess
import threading
import time

from processes import BOOSTERS, FSW, PATIENT, SOURCE, UNLATCH, ProcessTest, run_tests

GROUP = ("239.255.76.67", 7667)
LINES_PER_SECOND = 10   # limit for the middleware's log: bridge/dds/dds_log.h
FIRST_RTPS_PORT = 7410  # first port of participants in domain 0: every second port from here on
# An RTPS header and a DATA submessage whose length points behind the packet.
BAD_RTPS = b"RTPS\x02\x01\x01\x10" + bytes(12) + b"\x15\x05\xff\x7f" + bytes(20)
# Offset close to 2^32: the next 100 bytes lie outside any buffer.
BAD_FRAGMENT = struct.pack(">IIIIHH", 0x4C433033, 1, 1000, 0xFFFFFFC0, 0, 2) + b"UNLATCH_STATE\0" + bytes(100)
PATIENCE = 15  # s for an end after SIGTERM: a hanging process would never end; some 0.7 s on an idle machine


class WireTest(ProcessTest):
    def open_socket(self):
        out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(out.close)
        return out

    def flood(self, packet, targets):
        """Sends it repeatedly until the test ends."""
        out, stopping = self.open_socket(), threading.Event()

        def run():
            while not stopping.is_set():
                for target in targets:
                    out.sendto(packet, target)
                time.sleep(0.0001)

        thread = threading.Thread(target=run)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(stopping.set)

    def terminate(self, process):
        process.send_signal(signal.SIGTERM)
        process.wait(PATIENCE)

    # --- LCM ----------------------------------------------------------------------------------------------------

    def test_a_fragment_outside_its_message_harms_nobody(self):
        logger = self.begin(UNLATCH, "log", "--transport", "lcm", "--out", self.folder / "heard")
        self.begin(FSW, "--transport", "lcm")
        self.wait_for(logger, "waits for a session")
        self.flood(BAD_FRAGMENT, [GROUP])
        report = self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", "lcm", "--pace", "lockstep", "--until", "1", *PATIENT)
        self.assertEqual(report["status"], "ok")
        self.assertGreater(report["timing"]["rejected"]["malformed"], 0)
        self.finish(logger)

    def test_a_missing_multicast_route_has_one_remedy_here_and_in_the_documents(self):
        flight = [UNLATCH, "hil", BOOSTERS, "--transport", "lcm", "--pace", "lockstep"]
        without = self.run_ok("unshare", "-n", *flight, code=3).stderr
        elsewhere = self.run_ok(*flight, "--interface", "eth1", code=3).stderr
        commands = re.search("As root, `(.*?)`", without)[1]
        self.assertIn(f"As root, `{commands.replace(' lo', ' eth1')}`", elsewhere)
        for document in ("TUTORIAL.md", "SECURITY.md"):
            self.assertIn(commands, (SOURCE / "bridge" / document).read_text())
        # On a machine with a network, whose address messages have as their sender also through the loopback interface.
        network = ("ip link set lo up && ip link add eth1 type veth peer name eth2 && ip addr add 10.77.0.1/24 dev eth1 && "
                   "ip link set eth1 up && ip link set eth2 up && ip route add default dev eth1")
        flight = " ".join(map(shlex.quote, [*flight, "--start-timeout", "0.1"]))
        before = self.run_ok("unshare", "-n", "sh", "-c", f"{network} && {flight}", code=3).stderr
        self.assertIn("leads through the interface 'eth1', not 'lo'", before)
        self.assertIn(f"As root, `{commands}`", before)
        after = self.run_ok("unshare", "-n", "sh", "-c", f"{network} && {commands} && {flight}", code=1).stderr
        self.assertIn("on the interface 'lo': this machine only", after)

    # --- the log of the middleware --------------------------------------------------------------------------------

    def test_a_flood_of_malformed_packets_is_counted_and_does_not_fill_the_log(self):
        self.begin(FSW, "--transport", "dds")
        self.flood(BAD_RTPS, [("127.0.0.1", FIRST_RTPS_PORT + 2 * i) for i in range(4)])
        begun = time.monotonic()
        result = self.run_ok(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "realtime", "--until", "3", *PATIENT,
                             "--json", "-", code=None)  # late commands may cost a requirement
        seconds = math.ceil(time.monotonic() - begun)
        report = json.loads(result.stdout)
        self.assertEqual(report["status"], "ok")
        self.assertGreater(report["timing"]["rejected"]["malformed"], 20)
        lines = [line for line in result.stderr.splitlines() if "Cyclone DDS: " in line or "malformed packet" in line]
        counts = [line for line in lines if re.search(" more lines?, not shown$", line)]  # one before the first line of a second
        self.assertLessEqual(len(lines) - len(counts), LINES_PER_SECOND * seconds)
        self.assertLessEqual(len(counts), seconds)
        self.assertLess(max(map(len, lines)), 600)  # bytes; some 290

    def open_full_pipe(self):
        """Returns the writing end of a full pipe without a reader."""
        read, write = os.pipe()
        self.addCleanup(os.close, read)
        os.set_blocking(write, False)
        try:
            while True:
                os.write(write, bytes(4096))
        except BlockingIOError:
            os.set_blocking(write, True)
        return write

    def begin_unread(self, *arguments):
        """Starts a program whose standard error is a full pipe without a reader."""
        write = self.open_full_pipe()
        process = subprocess.Popen(list(map(str, arguments)), stdout=subprocess.PIPE, stderr=write, text=True)
        os.close(write)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_a_full_standard_error_stops_neither_pace(self):
        for pace in ("lockstep", "realtime"):
            with self.subTest(pace):
                self.begin(FSW, "--transport", "dds")
                self.flood(BAD_RTPS, [("127.0.0.1", FIRST_RTPS_PORT + 2 * i) for i in range(4)])
                process = self.begin_unread(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", pace, "--until", "2",
                                            *PATIENT, "--json", "-")
                out, _ = process.communicate(timeout=60)
                report = json.loads(out)
                self.assertEqual((report["status"], report["ticks"]), ("ok", 2000))

    def test_sigterm_ends_each_program_whatever_hangs(self):
        fsw = self.begin_unread(FSW, "--transport", "dds")
        logger = self.begin_unread(UNLATCH, "log", "--transport", "dds", "--out", self.folder / "heard")
        log = self.folder / "run.log"
        simulator = self.begin_unread(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "realtime", "--until", "60", "--log", log,
                                      *PATIENT)
        self.flood(BAD_RTPS, [("127.0.0.1", FIRST_RTPS_PORT + 2 * i) for i in range(4)])
        time.sleep(3)
        for process in (fsw, logger, simulator):  # the others end with the simulator's session
            self.assertIsNone(process.poll())
            self.terminate(process)
        self.assertTrue(self.run_json(UNLATCH, "replay", log, code=None)["replay"]["agrees"])

    def test_sigterm_ends_a_report_that_nobody_reads(self):
        write = self.open_full_pipe()
        process = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", "0.1",
                             stdout=write)
        os.close(write)
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(2)
        self.terminate(process)

    # --- two simulators -------------------------------------------------------------------------------------------

    def hear_another(self, transport):
        arguments = ["hil", BOOSTERS, "--transport", transport, "--pace", "realtime", "--until", "100", *PATIENT]
        log = self.folder / "first.log"
        self.begin(FSW, "--transport", transport)
        first = self.begin(UNLATCH, *arguments, "--log", log)
        self.wait_for(first, "takes part")
        second = self.run_ok(UNLATCH, *arguments, code=1)
        self.assertIn("another simulator is here: scenario 'boosters'", second.stdout + second.stderr)
        # A second simulator with another session number, and flight software for it.
        other = self.begin(FSW, "--transport", transport, "--session", "4711")
        third = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", transport, "--pace", "lockstep", "--until", "1",
                           *PATIENT, "--session", "4711")
        self.finish(third)
        self.finish(other)
        self.wait_for(first, "another simulator is heard")
        self.end_undisturbed(first, log)

    def end_undisturbed(self, simulator, log):
        simulator.terminate()
        simulator.wait(60)
        report = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertTrue(report["replay"]["agrees"])
        self.assertFalse([notice for notice in report["notices"] if notice["name"].startswith("policy")])

    def test_two_simulators_on_dds_notice_each_other(self):
        self.hear_another("dds")

    def test_two_simulators_on_lcm_notice_each_other(self):
        self.hear_another("lcm")

    def share_a_session_number(self, transport):
        arguments = ["hil", BOOSTERS, "--transport", transport, "--pace", "realtime", "--until", "100", *PATIENT, "--session", "4711"]
        log = self.folder / "first.log"
        self.begin(FSW, "--transport", transport, "--session", "4711")
        first = self.begin(UNLATCH, *arguments, "--log", log)
        self.wait_for(first, "takes part")
        second = self.run_ok(UNLATCH, *arguments, code=1)
        self.assertIn("session 4711, which is the number of this one too", second.stdout + second.stderr)
        self.end_undisturbed(first, log)

    def test_two_simulators_of_one_session_number_on_dds_do_not_run_beside_each_other(self):
        self.share_a_session_number("dds")

    def test_two_simulators_of_one_session_number_on_lcm_do_not_run_beside_each_other(self):
        self.share_a_session_number("lcm")

    def test_flight_software_stays_with_its_session(self):
        fsw = self.begin(FSW, "--transport", "dds")
        arguments = ["hil", BOOSTERS, "--transport", "dds", "--pace", "realtime", *PATIENT]
        first = self.begin(UNLATCH, *arguments, "--until", "100")
        self.wait_for(first, "takes part")
        second = self.begin(UNLATCH, *arguments, "--until", "0.1", "--session", "4711")
        self.wait_for(fsw, "stays with session")
        second.terminate()
        first.terminate()
        self.finish(fsw)

    def test_fast_over_a_network_is_a_mistake(self):
        said = self.run_ok(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "fast", code=2).stderr
        self.assertIn("--pace", said)


if __name__ == "__main__":
    run_tests()
