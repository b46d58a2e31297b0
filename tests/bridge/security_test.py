#!/usr/bin/env python3
"""DDS Security and the destinations of messages, with real processes and a temporary certificate authority. Run by ctest in a network namespace of
its own:

    security_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import select
import socket
import subprocess
import threading
import time

from processes import BOOSTERS, FSW, PATIENT, SOURCE, UNLATCH, ProcessTest, run_tests

MAKE_KEYS = SOURCE / "bridge/security/make-keys"
ALL_PACKETS = 0x0003
# Content of an open session: a channel's name and the scenario's, in messages; the names of types, in discovery. (Names of topics
# are in the permissions, which each side shows the other before they have a common key.)
SECRETS = [b"nozzle1\0", b"boosters\0", b"unlatch::State"]


class Sniffer:
    """Captures every byte on the loopback interface."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PACKETS))
        self.socket.bind(("lo", 0))
        self.seen = set()
        self.packets = 0
        self.stopping = False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.stopping:
            if not select.select([self.socket], [], [], 0.05)[0]:
                continue
            packet = self.socket.recv(65536)
            self.packets += 1
            self.seen.update(secret for secret in SECRETS if secret in packet)

    def stop(self):
        self.stopping = True
        self.thread.join()
        self.socket.close()


class SecurityTest(ProcessTest):
    def setUp(self):
        super().setUp()
        self.keys = self.folder / "keys"
        self.run_ok(MAKE_KEYS, self.keys)

    def hil(self, *arguments):
        return [UNLATCH, "hil", BOOSTERS, "--transport", "dds", *arguments]

    def test_a_secured_session_gives_the_same_bits_and_nothing_in_clear(self):
        hashes = []
        for secured in (False, True):
            def identity(name):
                return ["--security", self.keys / name] if secured else []

            heard = self.folder / f"heard{secured}"
            sniffer = Sniffer()
            self.addCleanup(sniffer.stop)
            logger = self.begin(UNLATCH, "log", "--transport", "dds", "--out", heard, *identity("log"))
            self.wait_for(logger, "waits for a session")
            self.begin(FSW, "--transport", "dds", *identity("fsw"))
            report = self.run_json(*self.hil("--pace", "lockstep", "--until", "4", *PATIENT, *identity("sim")))
            self.finish(logger)
            sniffer.stop()
            hashes.append(report["hash"])
            self.assertGreater(heard.read_bytes().count(b"UNLATCH_STATE"), 50)
            self.assertGreater(sniffer.packets, 500)
            self.assertEqual(sniffer.seen, set() if secured else set(SECRETS))
        self.assertEqual(hashes[0], hashes[1])

    def test_strangers_neither_hear_nor_command(self):
        others = self.folder / "others"
        self.run_ok(MAKE_KEYS, others)
        intruders = {
            "no security": [],
            "another authority": ["--security", others / "log"],
        }
        listeners = [self.begin(UNLATCH, "log", "--transport", "dds", "--out", self.folder / f"heard{i}", *arguments)
                     for i, arguments in enumerate(intruders.values())]
        for listener in listeners:
            self.wait_for(listener, "waits for a session")
        # Flight software without an identity, or with one of another authority: the simulator ignores it.
        strangers = [self.begin(FSW, "--transport", "dds"),
                     self.begin(FSW, "--transport", "dds", "--security", others / "fsw")]
        said = self.run_ok(*self.hil("--pace", "lockstep", "--start-timeout", "3", "--security", self.keys / "sim"), code=1)
        self.assertIn("no answer from the flight software", said.stdout)
        # With the right flight software the session continues, and the others have received none of it. In lockstep, since late
        # commands on a busy machine would cost a requirement in real time.
        self.begin(FSW, "--transport", "dds", "--security", self.keys / "fsw")
        self.run_ok(*self.hil("--pace", "lockstep", "--until", "4", *PATIENT, "--security", self.keys / "sim"))
        time.sleep(1)  # for what might still arrive
        for process in listeners:
            self.assertIsNone(process.poll(), "it has heard a session to its end")
            process.terminate()
            self.assertIn("no session was found", self.finish(process, code=1))
        for process in strangers:
            self.assertIsNone(process.poll(), "it has taken part")

    def test_nobody_may_say_what_his_role_does_not(self):
        """An observer's identity does not allow commands, and flight software's does not allow to act as the simulator."""
        result = self.run_ok(FSW, "--transport", "dds", "--security", self.keys / "log", code=3)
        self.assertIn("does the identity in", result.stderr)
        self.run_ok(*self.hil("--pace", "lockstep", "--security", self.keys / "fsw"), code=3)

    def test_a_missing_key_is_named(self):
        (self.keys / "sim/key.pem").unlink()
        result = self.run_ok(*self.hil("--pace", "lockstep", "--security", self.keys / "sim"), code=3)
        self.assertIn("sim/key.pem", result.stderr)

    def test_programs_say_where_their_messages_go(self):
        def start(*arguments, code=1):
            return self.run_ok(FSW, "--patience", "0.1", *arguments, code=code).stderr

        self.assertIn("interface 'lo': this machine only; every process there may", start("--transport", "dds"))
        self.assertIn("only whom the authority of", start("--transport", "dds", "--security", self.keys / "fsw"))
        self.assertIn("interface 'lo': this machine only; every process on it may", start("--transport", "lcm"))
        self.assertIn("LCM has no security", start("--transport", "lcm", "--security", self.keys / "fsw", code=3))
        # A multicast route that leads off this machine: not used unless requested.
        for line in ("link add out type veth peer name far", "addr add 10.77.1.1/24 dev out", "link set out up",
                     "link set far up", "route replace 224.0.0.0/4 dev out"):
            subprocess.run(["ip", *line.split()], check=True)
        self.addCleanup(subprocess.run, "ip route replace 224.0.0.0/4 dev lo; ip link del out", shell=True)
        refused = start("--transport", "lcm", code=3)
        self.assertIn("leads through the interface 'out', not 'lo'", refused)
        self.assertIn("ip route replace", refused)
        self.assertIn("everyone there may command; LCM has no access control",
                      start("--transport", "lcm", "--interface", "out"))


if __name__ == "__main__":
    run_tests()
