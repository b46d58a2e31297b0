#!/usr/bin/env python3
"""Sessions over a serial line, with real processes at both ends of a pair of pseudo-terminals:

    uart_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import random
import signal
import subprocess
import time

from processes import BOOSTERS, FSW, HANG, PATIENT, UNLATCH, ProcessTest, run_tests
from serial_cable import SerialCable

UNTIL = "0.4"  # s; commands and events are in it
SEED = 20


class UartTest(ProcessTest):
    def connect(self, disturb=None):
        cable = SerialCable(disturb)
        self.addCleanup(cable.close)
        return cable

    def name(self, cable, end, baud=4000000):
        return f"uart:{cable.ends[end]},{baud}"

    def session(self, transport, *options):
        until = [] if "--until" in options else ["--until", UNTIL]
        return self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", transport, "--pace", "lockstep", *until, *PATIENT, *options,
                             code=None)

    def fly(self, cable, *options, baud=4000000):
        self.begin(FSW, "--transport", self.name(cable, 1, baud))
        return self.session(self.name(cable, 0, baud), *options)

    def test_a_serial_line_flies_the_bits_of_the_other_transports_and_replays(self):
        cable, log = self.connect(), self.folder / "uart.log"
        over_uart = self.fly(cable, "--log", log)
        self.assertEqual(over_uart["status"], "ok")
        self.assertGreater(cable.carried, 10000)
        self.begin(FSW, "--transport", "dds")
        self.assertEqual(over_uart["hash"], self.session("dds")["hash"])
        self.assertEqual(over_uart["hash"], self.session("inproc")["hash"])
        again = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertTrue(again["replay"]["agrees"])
        self.assertEqual(again["hash"], over_uart["hash"])

    def test_a_noisy_line_changes_no_bit(self):
        """Bits flip, bytes are lost, and noise comes between: frames are lost, and the protocol sends them again."""
        draw = random.Random(SEED)

        def disturb(data):
            data = bytearray(data)
            if data and draw.random() < 0.03:
                data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
            if data and draw.random() < 0.03:
                del data[draw.randrange(len(data))]
            if draw.random() < 0.03:
                data[0:0] = bytes(draw.randrange(256) for _ in range(draw.randrange(1, 40)))
            if draw.random() < 0.01:
                data[0:0] = b"UNL1" + bytes(8) + b"\0\4\x0f\xff"  # claims to be a long State
            return bytes(data)

        short = ["--until", "0.1"]
        noisy = self.fly(self.connect(disturb), *short)
        self.assertEqual(noisy["status"], "ok", f"seed {SEED}")
        self.assertEqual(noisy["hash"], self.session("inproc", *short)["hash"])
        self.assertGreater(noisy["timing"]["resent"], 0)

    def test_either_end_may_start_first_and_a_slow_line_takes_its_time(self):
        cable = self.connect()
        simulator = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", self.name(cable, 0, 115200), "--pace", "lockstep", "--until", "0.02",
                               *PATIENT, "--json", self.folder / "slow.json")
        time.sleep(0.5)
        self.begin(FSW, "--transport", self.name(cable, 1, 115200))
        self.finish(simulator, code=None)
        self.assertIn('"status": "ok"', (self.folder / "slow.json").read_text())

    def test_killed_flight_software_is_started_again_and_the_session_goes_on(self):
        cable, log, result = self.connect(), self.folder / "killed.log", self.folder / "killed.json"
        first = self.begin(FSW, "--transport", self.name(cable, 1))
        simulator = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", self.name(cable, 0), "--pace", "lockstep", "--until", "3",
                               "--set", "flight_software.timeout=1", "--set", "flight_software.policy=pause", "--log", log, "--json", result)
        self.wait_for(simulator, "takes part")
        time.sleep(0.3)
        first.kill()
        first.wait()
        self.wait_for(simulator, "policy 'pause'")
        self.begin(FSW, "--transport", self.name(cable, 1))
        self.finish(simulator, code=None)
        self.assertIn('"status": "ok"', result.read_text())
        self.assertTrue(self.run_json(UNLATCH, "replay", log, code=None)["replay"]["agrees"])

    def test_a_killed_simulator_leaves_the_line_to_the_next_one(self):
        cable = self.connect()
        self.begin(FSW, "--transport", self.name(cable, 1))
        first = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", self.name(cable, 0), "--pace", "lockstep", "--until", "60", *PATIENT)
        self.wait_for(first, "takes part")
        first.send_signal(signal.SIGKILL)
        first.wait()
        self.assertEqual(self.fly(cable)["hash"], self.session("inproc")["hash"])

    def test_a_port_that_cannot_be_opened_is_named_with_what_mends_it(self):
        for name, text in (("uart:/dev/null,115200", "it is no serial port"), ("uart:/none/tty", "ls /dev/tty"),
                           (f"uart:{self.connect().ends[0]},12345", "12345 is no rate"), ("uart:", "write it like uart:/dev/ttyUSB0,115200"),
                           ("uart:/dev/ttyS0,fast", "write it like uart:/dev/ttyUSB0,115200")):
            done = subprocess.run([FSW, "--transport", name], capture_output=True, text=True, timeout=HANG)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(text, done.stderr, name)


if __name__ == "__main__":
    run_tests()
