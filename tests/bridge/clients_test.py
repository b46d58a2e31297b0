#!/usr/bin/env python3
"""Clients that use only the IDL or the LCM types, in sessions with the real simulator. Run by ctest in a
separate network namespace:

    clients_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import os
import re
import shutil
import struct

import yaml

from processes import BIN, BOOSTERS, PATIENT, PROBE, SOURCE, UNLATCH, ProcessTest, run_tests

EXAMPLES = SOURCE / "bridge/examples"
SATELLITE = EXAMPLES / "first/satellite.yaml"
LOSSY = SOURCE / "hil/scenarios/boosters/faults/lossy-line.yaml"
LISTEN = EXAMPLES / "python/listen.py"
DDS_TYPES = BIN.parent / "bridge/examples/libexample_python_dds_types.so"
PYTHON_TYPES = BIN.parent / "bridge/examples/python_types"
# Thrust of 5000 N on 100 kg from 0.1 to 0.3 s, free until 0.5 s: 1 m + 10 m/s * 0.2 s.
FLOWN = "x = 3.000000 m"
# The same probe, whose thrust follows from a table over its speed; the pilot's channel scales the table.
TABLE = """unlatch: 1
name: probe
step: {dt: 0.001, until: 0.5}
bodies:
  probe: {mass: 100, inertia: [10, 20, 25]}
channels:
  throttle: {initial: 0, range: [0, 1], safe: 0}
quantities:
  speed: {velocity: {body: probe, component: x}}
tables:
  force: {axes: {speed: {of: speed, at: [-5, 20], unit: m/s}}, values: [5500, 3000], unit: N, scale_channel: throttle}
elements:
  engine: {type: thrust, body: probe, direction: [1, 0, 0], profile: {expression: force}}
sensors:
  gyro: {type: rate, body: probe}
flight_software: {required: [pilot], timeout: 5, policy: abort}
"""


def read_log(path):
    """Returns (channel, bytes) of the events of an LCM log."""
    events = []
    with open(path, "rb") as log:
        while header := log.read(28):
            _magic, _number, _time, channel_length, data_length = struct.unpack(">IqqII", header)
            events.append((log.read(channel_length).decode(), log.read(data_length)))
    return events


class ClientsTest(ProcessTest):
    def fly(self, transport, pilot):
        process = self.begin(*pilot)
        report = self.run_json(UNLATCH, "hil", PROBE, "--transport", transport, "--pace", "lockstep")
        self.assertIn(FLOWN, self.finish(process))
        self.assertEqual(report["status"], "ok")
        self.assertTrue(report["replay"]["agrees"])
        self.assertAlmostEqual(report["samples"][-1]["bodies"]["probe"]["p"][0], 3, places=9)  # rounding of 500 steps
        return report

    def test_pilots_over_dds_lcm_and_udp_fly_the_same_bits(self):
        python = ["/usr/bin/env", "python3", EXAMPLES / "python/dds.py", EXAMPLES.parent / "schema/unlatch.idl", DDS_TYPES]
        reports = [self.fly("dds", [BIN / "example_pilot_c"]), self.fly("dds", python), self.fly("lcm", [BIN / "example_pilot_cpp"]),
                   self.fly("udp", [BIN / "example_pilot_udp"])]
        self.assertEqual(len({report["hash"] for report in reports}), 1)

    # m dv/dt = 5000 N - 100 kg/s v from 0.1 to 0.3 s.
    def test_a_commanded_channel_scales_a_table_over_dds_lcm_and_udp_with_the_same_bits(self):
        scenario, found = self.folder / "table.yaml", set()
        scenario.write_text(TABLE)
        for transport, pilot in (("dds", "example_pilot_c"), ("lcm", "example_pilot_cpp"), ("udp", "example_pilot_udp")):
            process, log = self.begin(BIN / pilot), self.folder / f"{transport}.log"
            report = self.run_json(UNLATCH, "hil", scenario, "--transport", transport, "--pace", "lockstep", "--log", log)
            self.finish(process)
            self.assertEqual(report["status"], "ok")
            body = report["samples"][-1]["bodies"]["probe"]
            speed = 50 * (1 - math.exp(-0.2))
            self.assertAlmostEqual(body["v"][0], speed, places=9)
            self.assertAlmostEqual(body["p"][0], 50 * (0.2 - (1 - math.exp(-0.2))) + 0.2 * speed, places=9)
            again = self.run_json(UNLATCH, "replay", log)
            self.assertTrue(again["replay"]["agrees"])
            found |= {report["hash"], again["hash"]}
        self.assertEqual(len(found), 1)

    def test_the_s_function_flies_the_pilots_bits_and_names_what_it_does_not_find(self):
        wanted = self.fly("udp", [BIN / "example_pilot_udp"])["hash"]
        # The host commands the throttle at each tick, the pilot only when it changes: the values at each tick are equal.
        host = self.begin(BIN / "sfunction_host")
        report = self.run_json(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep")
        self.assertIn("stopped at 0.500 s", self.finish(host))
        self.assertEqual(report["hash"], wanted)
        host = self.begin(BIN / "sfunction_host", "throtle")
        self.begin(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep")
        self.assertEqual(host.wait(30), 1)

    def test_components_for_cfs_fprime_and_ros_fly_the_pilots_bits(self):
        wanted = self.fly("udp", [BIN / "example_pilot_udp"])["hash"]
        for stack in ("cfs", "fprime", "ros2"):
            host = self.begin(BIN / f"stack_{stack}")
            report = self.run_json(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep")
            self.assertIn("the session ended at tick 500", self.finish(host), stack)
            self.assertEqual(report["hash"], wanted, stack)

    def test_a_cfs_application_that_cannot_start_closes_no_descriptor_of_others(self):
        with open("/dev/null") as empty:
            self.finish(self.begin(BIN / "stack_cfs", "fail", stdin=empty))

    def test_a_tick_of_the_cfs_application_ends_in_time_though_packets_of_earlier_ticks_come(self):
        host = self.begin(BIN / "stack_cfs", "stale")
        report = self.run_json(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep", *PATIENT)
        said = self.finish(host, code=1)  # its error is reported
        self.assertEqual(said.count("tick 5: no last command within 1000 ms"), 1)
        self.assertIn("the session ended at tick 500", said)
        self.assertEqual(report["hash"], self.fly("udp", [BIN / "example_pilot_udp"])["hash"])

    def test_the_ros_node_on_fast_dds_is_flown_by_a_controller_on_cyclone_dds(self):
        """Two middlewares of ROS 2 with the names, types and qualities of service that ROS gives them; each has its own encoder."""
        if not (BIN / "stack_ros2_wire").exists():
            self.skipTest("Fast DDS is missing: tools/setup test")
        node, controller = self.begin(BIN / "stack_ros2_wire"), self.begin(BIN / "stack_ros2_controller")
        for topic in ("/clock", "/tf", "/unlatch/sensors", "/unlatch/command"):
            self.wait_for(node, f"{topic} is matched")
        self.wait_for(controller, "everything is matched")
        report = self.run_json(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep", *PATIENT)
        self.assertIn("the session ended at tick 500", self.finish(node))
        self.assertIn("controller: 500 states, clock 0.499 s, x = 2.990000 m", self.finish(controller))
        self.assertEqual(report["hash"], self.fly("udp", [BIN / "example_pilot_udp"])["hash"])

    def test_the_fast_dds_example_flies_the_pilots_bits(self):
        """Long, because it is built here: fastddsgen makes its types, so that it needs a Java."""
        if not shutil.which("fastddsgen"):
            self.skipTest("fastddsgen is missing: tools/setup long")
        said = self.run_ok(EXAMPLES / "fastdds/run", BIN).stdout
        self.assertIn(self.fly("udp", [BIN / "example_pilot_udp"])["hash"], said)

    def test_the_udp_participant_answers_states_that_are_resent(self):
        """A line that loses and repeats states, commands and answers changes no bit."""
        clean = self.fly("udp", [BIN / "example_pilot_udp"])
        pilot = self.begin(BIN / "example_pilot_udp")
        lossy = self.run_json(UNLATCH, "hil", PROBE, "--transport", "udp", "--pace", "lockstep", "--faults", LOSSY)
        self.assertIn(FLOWN, self.finish(pilot))
        self.assertEqual(lossy["hash"], clean["hash"])
        self.assertGreater(lossy["timing"]["resent"], 20)

    def leave_with_security(self, times):
        """Repeated, because the result depends on the shutdown of Cyclone's plugins at the end of the process."""
        keys = self.folder / "keys"
        self.run_ok(SOURCE / "bridge/security/make-keys", keys)
        def plugin(element, name, functions, files):
            texts = "".join(f"<{item}>file:{keys}/fsw/{file}</{item}>" for item, file in files.items())
            return (f'<{element}><Library path="dds_security_{name}" initFunction="init_{functions}" '
                    f'finalizeFunction="finalize_{functions}"/>{texts}</{element}>')

        network = (
            '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery><Security>'
            + plugin("Authentication", "auth", "authentication",
                     {"IdentityCertificate": "identity.pem", "IdentityCA": "ca.pem", "PrivateKey": "key.pem"})
            + plugin("Cryptographic", "crypto", "crypto", {})
            + plugin("AccessControl", "ac", "access_control",
                     {"PermissionsCA": "ca.pem", "Governance": "governance.p7s", "Permissions": "permissions.p7s"})
            + "</Security></Domain></CycloneDDS>")
        for _ in range(times):
            pilot = self.begin(BIN / "example_pilot_c", env={**os.environ, "CYCLONEDDS_URI": network})
            self.run_ok(UNLATCH, "hil", PROBE, "--transport", "dds", "--pace", "lockstep", "--security", keys / "sim",
                        "--set", "flight_software.timeout=30")
            self.assertIn(FLOWN, self.finish(pilot))

    def test_the_c99_pilot_leaves_in_order_with_security(self):
        self.leave_with_security(8)

    def test_the_c99_pilot_leaves_in_order_forty_times_with_security(self):
        self.leave_with_security(40)

    def test_the_page_for_clients_has_every_field_and_every_number(self):
        definition = yaml.safe_load((SOURCE / "bridge/schema/messages.yaml").read_text())
        page = (EXAMPLES.parent / "CLIENTS.md").read_text()
        for name, message in definition["messages"].items():
            listed = re.search(rf"^\*\*{name}\*\*: (.*)\.$", page, re.M)[1]
            self.assertEqual([field.split(" ×")[0] for field in listed.split(", ")], [field["name"] for field in message["fields"]])
        for name, numbers in definition["enums"].items():
            row = re.search(rf"^\| {name} \|.*\| (.*) \|$", page, re.M)[1]
            self.assertEqual(row, ", ".join(f"{number} {value}" for value, number in numbers.items()))

    def test_python_reads_lcm_bytes(self):
        listener = self.begin("/usr/bin/env", "python3", LISTEN, PYTHON_TYPES)
        self.wait_for(listener, "listening")
        report = self.fly("lcm", [BIN / "example_pilot_cpp"])
        said = self.finish(listener)
        self.assertIn("scenario probe", said)
        end = re.search(r"ended at tick 500: x = (\S+); (\d+) states", said)
        self.assertEqual(float(end[1]), report["samples"][-1]["bodies"]["probe"]["p"][0], "not the same bits")
        self.assertGreater(int(end[2]), 50)  # a slow listener may miss some

    def test_python_flies_the_tutorials_satellite_over_lcm_and_udp_to_the_hash_of_cpp(self):
        hashes = set()
        python = ["/usr/bin/env", "python3"]
        for transport, pilot in (("lcm", [BIN / "example_first"]), ("lcm", [*python, EXAMPLES / "python/fsw.py", PYTHON_TYPES]),
                                 ("udp", [*python, EXAMPLES / "udp/fsw.py", PYTHON_TYPES])):
            process = self.begin(*pilot)
            report = self.run_json(UNLATCH, "hil", SATELLITE, "--transport", transport, "--pace", "lockstep")
            self.finish(process)
            self.assertEqual(report["status"], "ok")
            self.assertLess(abs(report["samples"][-1]["bodies"]["satellite"]["w"][2]), 1e-4)  # rad/s: it has stopped
            hashes.add(report["hash"])
        self.assertEqual(len(hashes), 1)

    def test_a_client_of_the_standard_library_flies_the_boosters_to_the_hash_of_the_reference_flight_software(self):
        boosters = [UNLATCH, "hil", BOOSTERS, "--pace", "lockstep", "--until", "2", "--transport"]
        wanted = self.run_json(*boosters, "inproc", code=None)
        process = self.begin("/usr/bin/env", "python3", EXAMPLES / "udp/boosters.py")
        report = self.run_json(*boosters, "udp", "--set", "flight_software.timeout=30", code=None)
        self.assertIn("4 contacts", self.finish(process))
        self.assertEqual((report["status"], report["hash"]), ("ok", wanted["hash"]))
        self.assertEqual(sum(report["timing"]["rejected"].values()), 0)

    def hear_another(self, transport, pilot, scenario, seconds):
        """A second simulator introduces itself while the first flies."""
        fsw = self.begin(*pilot)
        common = ["--transport", transport, "--pace", "realtime", "--set", "flight_software.timeout=30",
                  "--set", "flight_software.require.late=100 %"]  # on a busy machine
        first = self.begin(UNLATCH, "hil", scenario, *common, "--until", seconds, "--json", self.folder / "first.json")
        self.wait_for(first, "takes part")
        second = self.begin(UNLATCH, "hil", scenario, *common, "--session", "4711", "--start-timeout", "60")
        self.wait_for(fsw, "another simulator is heard")
        self.finish(first)
        second.terminate()
        said = self.finish(fsw)
        self.assertEqual(said.count("another simulator is heard"), 1)
        report = json.loads((self.folder / "first.json").read_text())
        self.assertEqual(report["status"], "ok")
        self.assertEqual([notice["name"] for notice in report["notices"] if notice["name"].startswith("policy")], [])

    def test_the_example_over_dds_stays_with_its_session(self):
        self.hear_another("dds", [BIN / "example_pilot_c"], PROBE, 3)

    def test_the_examples_over_lcm_stay_with_their_session(self):
        self.hear_another("lcm", [BIN / "example_pilot_cpp"], PROBE, 3)
        for pilot in ([BIN / "example_first"], ["/usr/bin/env", "python3", EXAMPLES / "python/fsw.py", PYTHON_TYPES]):
            self.hear_another("lcm", pilot, SATELLITE, 3)

    def test_lcm_logger_records_and_lcm_logplayer_plays(self):
        recorded, heard = self.folder / "recorded.lcm", self.folder / "heard.lcm"
        logger = self.begin("lcm-logger", "--force", recorded)
        self.wait_for(logger, "Opening log file")
        report = self.fly("lcm", [BIN / "example_pilot_cpp"])
        logger.terminate()  # the logger writes its remaining events, then ends
        logger.wait()
        said = self.run_ok("/usr/bin/env", "python3", LISTEN, PYTHON_TYPES, recorded).stdout
        self.assertIn(f"x = {report['samples'][-1]['bodies']['probe']['p'][0]!r};", said)

        listener = self.begin(UNLATCH, "log", "--transport", "lcm", "--out", heard)
        self.wait_for(listener, "waits for a session")
        self.run_ok("lcm-logplayer", "--speed=0.2", recorded)  # slowly, so that a busy machine keeps up
        self.finish(listener)
        played, (header, *arrived) = read_log(recorded), read_log(heard)
        self.assertEqual(header[0], "UNLATCH_HEARD")
        description = json.loads(header[1])
        self.assertEqual((description["scenario"], description["transport"], description["ended"]), ("probe", "lcm", True))
        self.assertEqual(description["topics"], {channel: sum(name == channel for name, _ in arrived) for channel, _ in arrived})
        # A busy machine may lose some messages; none may change, and those of one channel keep their order.
        self.assertGreater(len(arrived), len(played) // 2)
        for channel in {channel for channel, _ in arrived}:
            remaining = iter([data for name, data in played if name == channel])
            self.assertTrue(all(data in remaining for name, data in arrived if name == channel), f"{channel}: not as recorded")


if __name__ == "__main__":
    run_tests()
