#!/usr/bin/env python3
"""Sessions between two hosts whose network misbehaves. The hosts are namespaces that the test makes itself. Run by ctest in a
network namespace of its own:

    network_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import os
import time

from network import BadLine, Cable
from processes import BOOSTERS, FSW, UNLATCH, ProcessTest, run_tests

URL = ["--lcm-url", "udpm://239.255.76.67:7667?ttl=1"]


class NetworkTest(ProcessTest):
    def join(self, network):
        self.addCleanup(network.close)
        return network

    def options(self, host, transport):
        return ["--transport", transport, "--interface", host.interface, *(URL if transport == "lcm" else [])]

    def begin_session(self, network, transport, *arguments):
        sim, fsw = network.hosts
        self.begin(*fsw.inside, FSW, *self.options(fsw, transport))
        return self.begin(*sim.inside, UNLATCH, "hil", BOOSTERS, *self.options(sim, transport), "--pace", "lockstep",
                          *arguments)

    def calc_hash(self, until):
        return self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", until)["hash"]

    def get_report(self, log, code=0):
        return self.run_json(UNLATCH, "replay", log, code=code)

    # --- partitions ---------------------------------------------------------------------------------------------

    def pull_the_cable(self, transport, side):
        """The policy pause acts; after the repair the session continues with the bits of an undisturbed one."""
        network = self.join(Cable())
        log = self.folder / "run.log"
        until = "16"  # end of lockstep: later than the second interruption of the cable, even on a fast machine
        simulator = self.begin_session(network, transport, "--until", until, "--set", "flight_software.timeout=0.3", "--set",
                                       "flight_software.policy=pause", "--log", log)
        self.wait_for(simulator, "takes part")
        for _ in range(2):
            time.sleep(0.1)
            pauses = simulator.said.read_text().count("policy 'pause'")
            network.hosts[side].down()
            while simulator.said.read_text().count("policy 'pause'") == pauses:
                self.assertIsNone(simulator.poll(), simulator.said.read_text()[-2000:])
                time.sleep(0.01)
            time.sleep(0.5)
            network.hosts[side].up()
            while simulator.said.read_text().count("is back") == pauses:
                self.assertIsNone(simulator.poll(), simulator.said.read_text()[-2000:])
                time.sleep(0.01)
        self.finish(simulator)
        report = self.get_report(log)
        self.assertEqual(report["status"], "ok")
        self.assertTrue(report["replay"]["agrees"])
        self.assertEqual(report["hash"], self.calc_hash(until))

    def test_dds_survives_a_partition_on_the_side_of_the_simulator(self):
        self.pull_the_cable("dds", 0)

    def test_lcm_survives_a_partition_on_the_side_of_the_flight_software(self):
        self.pull_the_cable("lcm", 1)

    def test_a_partition_without_healing_ends_in_the_policy_hold(self):
        network = self.join(Cable())
        log = self.folder / "run.log"
        simulator = self.begin_session(network, "dds", "--until", "12", "--set", "flight_software.timeout=0.3", "--set",
                                       "flight_software.policy=hold", "--log", log)
        self.wait_for(simulator, "takes part")
        time.sleep(0.1)
        network.hosts[1].down()
        said = self.finish(simulator, code=None)  # the distance that is kept depends on the time of the interruption
        self.assertIn("policy 'hold'", said)
        report = self.get_report(log, code=None)
        self.assertEqual(report["status"], "ok")
        self.assertTrue(report["replay"]["agrees"])
        self.assertEqual([notice["name"] for notice in report["notices"]], ["participant.joined", "policy.hold"])

    # --- a bad line ---------------------------------------------------------------------------------------------

    def fly_over_a_bad_line(self, transport):
        if not os.path.exists("/dev/net/tun"):
            self.skipTest("this machine has no TAP devices")
        seed = int.from_bytes(os.urandom(4), "big")
        print(f"seed {seed}")
        network = self.join(BadLine(seed, loss=0.03, duplicates=0.03, delay_s=0.002))
        log = self.folder / "run.log"
        simulator = self.begin_session(network, transport, "--until", "0.3", "--set", "flight_software.timeout=30", "--log",
                                       log)
        self.finish(simulator)
        print(f"{network.forwarded} frames forwarded, {network.lost} lost, {network.doubled} doubled, "
              f"{network.overtaken} overtaken")
        self.assertGreater(min(network.lost, network.doubled, network.overtaken), 5)
        report = self.get_report(log)
        self.assertEqual(report["status"], "ok")
        self.assertTrue(report["replay"]["agrees"])
        self.assertEqual(report["hash"], self.calc_hash("0.3"))

    def test_dds_flies_the_same_bits_over_a_line_that_loses_delays_reorders_and_duplicates(self):
        self.fly_over_a_bad_line("dds")

    def test_lcm_flies_the_same_bits_over_a_line_that_loses_delays_reorders_and_duplicates(self):
        self.fly_over_a_bad_line("lcm")


if __name__ == "__main__":
    run_tests()
