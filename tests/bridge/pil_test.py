#!/usr/bin/env python3
"""Processor in the loop: programs of bridge/target on processors that QEMU emulates, with real processes at the other end of their serial ports.

    pil_test.py BIN_FOLDER SOURCE_FOLDER BUILD_FOLDER [unittest options]

BUILD_FOLDER keeps the programs for the targets. A fact whose compiler or emulator is missing is skipped.
"""
import importlib.machinery
import importlib.util
import random
import re
import signal
import sys
import time
from pathlib import Path

from processes import BOOSTERS, FSW, PATIENT, SOURCE, UNLATCH, ProcessTest, run_tests
from serial_cable import SerialCable

BUILD = Path(sys.argv.pop(3))
UNTIL = "0.6"  # s: throttle, verniers, rudders, ties, cut-off, contacts are in it
SHORT = "0.2"
SEED = 48
SLOW = 600  # s, for a build under load

loader = importlib.machinery.SourceFileLoader("pil", str(SOURCE / "tools/pil"))
sys.dont_write_bytecode = True
pil = importlib.util.module_from_spec(importlib.util.spec_from_loader("pil", loader))
loader.exec_module(pil)


class ProcessorInTheLoopTest(ProcessTest):
    def build(self, port, until=UNTIL):
        missing = pil.find_missing(port)
        if missing:
            self.skipTest(f"no {missing} (tools/setup test)")
        folder = BUILD / port
        plan, session = pil.compile_images(UNLATCH, BOOSTERS, until, folder)
        return pil.build(port, plan, session, folder / "build")

    def connect(self, disturb=None):
        cable = SerialCable(disturb)
        self.addCleanup(cable.close)
        return cable

    def switch_on(self, port, program, cable):
        line = ["-chardev", f"serial,id=line,path={cable.ends[0]}", "-serial", "chardev:line"]
        return self.begin(*pil.emulate(port, program, line))

    def begin_fsw(self, cable):
        return self.begin(FSW, "--transport", f"uart:{cable.ends[1]},{pil.BAUD['simulator']}")

    def read_reference(self, until, transport):
        """The hashes of a session on this computer."""
        log = self.folder / f"{transport}.log"
        if transport != "inproc":
            self.begin(FSW, "--transport", transport)
        self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", transport, "--pace", "lockstep", "--until", until, *PATIENT, "--log", log, code=None)
        hashes = pil.list_hashes(UNLATCH, log)
        self.assertEqual(len(hashes), round(float(until) * 10))
        return hashes

    def finish_board(self, board):
        board.wait(SLOW)
        said = board.said.read_text()
        self.assertEqual(board.returncode, 0, said)
        return said

    def check_simulator(self, port, transport="inproc"):
        program = self.build(port) / "simulator"
        cable = self.connect()
        board = self.switch_on(port, program, cable)
        software = self.begin_fsw(cable)
        said = self.finish_board(board)
        self.finish(software)
        self.assertEqual(pil.read_hashes(said), self.read_reference(UNTIL, transport))

    def test_a_simulator_on_a_cortex_m7_flies_the_hashes_of_dds(self):
        self.check_simulator("mps2-an500", "dds")

    def test_a_simulator_on_a_cortex_a53_flies_the_same_hashes(self):
        self.check_simulator("cortex-a53")

    def test_a_simulator_on_riscv64_flies_the_same_hashes(self):
        self.check_simulator("riscv64")

    def test_a_noisy_line_to_a_cortex_m7_changes_no_bit(self):
        program = self.build("mps2-an500", SHORT) / "simulator"
        draw = random.Random(SEED)

        def disturb(data):
            data = bytearray(data)
            if data and draw.random() < 0.002:
                data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
            if data and draw.random() < 0.002:
                del data[draw.randrange(len(data))]
            if draw.random() < 0.002:
                data[0:0] = bytes(draw.randrange(256) for _ in range(draw.randrange(1, 40)))
            return bytes(data)

        cable = self.connect(disturb)
        board = self.switch_on("mps2-an500", program, cable)
        self.begin_fsw(cable)
        said = self.finish_board(board)
        self.assertEqual(pil.read_hashes(said), self.read_reference(SHORT, "inproc"), f"seed {SEED}")
        self.assertGreater(int(re.search(r"# resent (\d+)", said)[1]), 0)

    def test_either_end_is_killed_and_stopped_and_the_hashes_are_the_same(self):
        program = self.build("mps2-an500", SHORT) / "simulator"
        cable = self.connect()
        first = self.switch_on("mps2-an500", program, cable)
        software = self.begin_fsw(cable)
        self.wait_for(first, "takes part from tick 0")
        first.kill()  # a board that loses its power; flight software notices that its simulator is gone
        first.wait()
        board = self.switch_on("mps2-an500", program, cable)
        self.wait_for(board, "takes part from tick 0")
        software.kill()  # before it has commanded anything
        software.wait()
        software = self.begin_fsw(cable)
        self.wait_for(board, "takes part from tick 0")
        for process in (software, board):  # for longer than the scenario's timeout
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.5)
            process.send_signal(signal.SIGCONT)
        said = self.finish_board(board)
        self.assertEqual(said.count("takes part"), 2, said)
        self.assertEqual(pil.read_hashes(said), self.read_reference(SHORT, "inproc"))


if __name__ == "__main__":
    run_tests()
