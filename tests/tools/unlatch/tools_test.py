#!/usr/bin/env python3
"""Facts about the executables, with real processes. Run by ctest in a network namespace of its own:

    tools_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import json
import signal
import subprocess
import time
from pathlib import Path
from xml.etree import ElementTree

from processes import BOOSTERS, FSW, HANG, PATIENT, REFERENCE, SCENARIOS, UNLATCH, ProcessTest, call, main

DEAD_NOZZLE = str(SCENARIOS / "boosters/dead-nozzle.yaml")


class ToolsTest(ProcessTest):
    def run_over(self, transport, *arguments, code=0, scenario=BOOSTERS):
        """Runs a session with the flight software as a separate process, unless the transport is inproc."""
        if transport != "inproc":
            self.begin(FSW, "--transport", transport)
        return self.run_json(UNLATCH, "hil", scenario, "--transport", transport, *arguments, code=code)

    # --- check and run ------------------------------------------------------------------------------------------

    def test_check_prints_the_plan(self):
        text = self.run_ok(UNLATCH, "check", BOOSTERS).stdout
        for part in ["booster4", "slider", "y z rot_x rot_z", "Elimination order", "bytes", "is valid"]:
            self.assertIn(part, text)
        array = self.run_ok(UNLATCH, "check", SCENARIOS / "array/reference.yaml").stdout
        self.assertIn("h*omega", array)

    def test_check_bounds_what_a_step_costs(self):
        text = self.run_ok(UNLATCH, "check", REFERENCE, "--cost", "cortex-m7", "--cycles", "2", "--clock", "400").stdout
        for part in ["Most that a step costs on cortex-m7", "integrations: stages", "events", "all limits reached", "at 400 MHz", "the watchdog"]:
            self.assertIn(part, text)
        cost = self.run_json(UNLATCH, "check", REFERENCE, "--cost", "cortex-m7", "--cycles", "2", "--clock", "400")["cost"]
        self.assertEqual(cost["unmeasured"], [])
        self.assertAlmostEqual(sum(phase["instructions"] for phase in cost["phases"]), cost["most"]["instructions"], delta=1e-6 * cost["most"]["instructions"])
        self.assertLess(cost["smooth"]["instructions"], cost["most"]["instructions"])
        self.assertAlmostEqual(cost["smooth"]["time"], 2 * cost["smooth"]["instructions"] / 400e6)
        refused = self.run_ok(UNLATCH, "check", REFERENCE, "--cost", "vax", code=2)
        self.assertIn("x86-64", refused.stderr)

    def test_every_mistake_has_file_and_line(self):
        text = Path(REFERENCE).read_text().replace("mass: 98500", "mass: -1").replace("mode: hinge", "mode: hnge", 1)
        bad = self.folder / "bad.yaml"
        bad.write_text(text)
        lines = text.splitlines()
        wrong = [1 + next(i for i, line in enumerate(lines) if part in line) for part in ("mass: -1", "mode: hnge")]
        for command in (["check"], ["run", "--json", self.folder / "r.json", "--log", self.folder / "r.log"]):
            result = self.run_ok(UNLATCH, command[0], bad, *command[1:], code=2)
            self.assertRegex(result.stderr, rf"bad\.yaml:{wrong[0]}:\d+: ")
            self.assertRegex(result.stderr, rf"bad\.yaml:{wrong[1]}:\d+: ")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["bad.yaml"], "nothing half-written")

    def test_usage_errors_exit_2(self):
        for arguments in (
            [],
            ["fly"],
            ["run"],
            ["run", REFERENCE, "--bogus"],
            ["run", REFERENCE, "--until", "-1"],
            ["run", REFERENCE, "--sample", "99"],
            ["run", REFERENCE, "--set", "bodies.nobody.mass=1"],
            ["run", self.folder / "missing.yaml"],
            ["hil", BOOSTERS, "--transport", "pigeon", "--pace", "fast"],
            ["hil", BOOSTERS, "--transport", "inproc"],
            ["replay", self.folder / "missing.log"],
            ["replay", REFERENCE],
            ["log", "--transport", "inproc", "--out", self.folder / "x"],
        ):
            result = self.run_ok(UNLATCH, *arguments, code=2)
            self.assertEqual(result.stdout, "")
            self.assertNotEqual(result.stderr.strip(), "")
        self.run_ok(FSW, "--transport", "inproc", code=2)

    def test_help_teaches_with_an_example(self):
        for command in ("check", "run", "hil", "replay", "log"):
            self.assertIn("Example", self.run_ok(UNLATCH, command, "--help").stdout)
        self.assertIn("Example", self.run_ok(FSW, "--help").stdout)

    def test_json_on_standard_output_is_alone(self):
        result = self.run_ok(UNLATCH, "run", REFERENCE, "--json", "-", "--sample", "0,0.5,1.00049,2")
        report = json.loads(result.stdout)
        self.assertEqual(report["schema"], 1)
        self.assertEqual((report["scenario"], report["status"], report["dt"], report["ticks"]),
                         ("boosters", "ok", 0.001, 2000))
        self.assertRegex(report["hash"], r"^[0-9a-f]{16}$")
        self.assertEqual([sample["t"] for sample in report["samples"]], [0, 0.5, 1.0, 2.0])
        self.assertIn("not on a tick", result.stderr)
        self.assertIn("Events", result.stderr)
        first, last = report["samples"][0], report["samples"][-1]
        nose = first["reactions"]["nose1"]
        self.assertEqual((nose["mode"], nose["rows"]), ("hinge", ["x", "y", "z", "rot_x", "rot_z"]))
        self.assertEqual(len(nose["lambda"]), 5)
        self.assertEqual(last["reactions"]["nose1"], {"mode": "free", "rows": [], "lambda": []})
        self.assertEqual(sorted(last["bodies"]["core"]), ["a", "alpha", "modal", "p", "q", "v", "w"])
        self.assertEqual(len([e for e in report["events"] if e["name"] == "liftoff"]), 4)
        self.assertEqual(len(report["clearance"]), 4)
        self.assertTrue(report["audit"])
        self.assertEqual(report["timing"]["step_ns"]["count"], 2000)

    def test_files_that_cannot_be_written_exit_3(self):
        nowhere = self.folder / "no/such/folder/file"
        for option in ("--json", "--log"):
            result = self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.01", option, nowhere, code=3)
            self.assertIn(str(nowhere), result.stderr)
        if Path("/dev/full").exists():
            self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.01", "--json", "/dev/full", code=3)
            self.run_ok(UNLATCH, "run", REFERENCE, "--until", "0.01", "--log", "/dev/full", code=3)

    def test_a_run_replays(self):
        log = self.folder / "run.log"
        report = self.run_json(UNLATCH, "run", REFERENCE, "--log", log, "--until", "1", "--dt", "0.002",
                               "--set", "bodies.core.mass=99000")
        again = self.run_json(UNLATCH, "replay", log)
        self.assertEqual(again["replay"], {"ticks_compared": 501, "agrees": True})
        self.assertEqual((again["hash"], again["events"], again["samples"]),
                         (report["hash"], report["events"], report["samples"]))

    # --- in the loop --------------------------------------------------------------------------------------------

    def test_lockstep_gives_the_same_bits_over_every_transport(self):
        reports = [self.run_over(transport, "--pace", "lockstep", "--until", "1.5", *PATIENT)
                   for transport in ("inproc", "dds", "lcm", "udp")]
        self.assertEqual(len({report["hash"] for report in reports}), 1)
        for report in reports:
            self.assertTrue(report["replay"]["agrees"])
            names = {event["name"] for event in report["events"]}
            self.assertEqual(names, {"ties_cut", "cutoff", "release", "contact", "nozzle", "liftoff"})

    def test_a_dead_contact_keeps_its_nozzle_shut_and_its_nose_on_the_core(self):
        report = self.run_over("inproc", "--pace", "lockstep", "--until", "3", *PATIENT, scenario=DEAD_NOZZLE,
                               code=1)  # the safe distance is not kept
        self.assertEqual([entry["id"] for entry in report["verdict"] if not entry["met"]], ["distance1"])
        times = {(e["name"], e["subject"]): e["t"] for e in report["events"]}
        self.assertNotIn(("contact", "booster1"), times)
        self.assertNotIn(("nozzle", "booster1"), times)
        self.assertIn(("nozzle", "booster2"), times)
        self.assertGreater(times["liftoff", "booster1"], times["liftoff", "booster2"] + 0.1)
        text = self.run_ok(UNLATCH, "hil", DEAD_NOZZLE, "--transport", "inproc", "--pace", "lockstep", "--until", "3",
                           *PATIENT, code=1).stdout
        self.assertIn("1 of 4 requirements is not met", text)
        self.assertIn("booster1 stayed on core", text)
        self.assertIn("core and booster1 touch", text)

    def test_realtime_is_heard_by_a_logger_and_replays(self):
        log, heard = self.folder / "run.log", self.folder / "heard.log"
        logger = self.begin(UNLATCH, "log", "--transport", "dds", "--out", heard)
        report = self.run_over("dds", "--pace", "realtime", "--until", "1.5", "--log", log, *PATIENT,
                               code=None)  # late commands may cost a requirement
        self.assertEqual(report["status"], "ok")
        self.assertEqual(logger.wait(HANG), 0)
        self.assertGreater(heard.read_bytes().count(b"UNLATCH_STATE"), 100)
        said = json.loads(heard.read_bytes().split(b"UNLATCH_HEARD", 1)[1][:8192])
        self.assertEqual((said["transport"], said["ended"], said["pace"]), ("dds", True, "realtime"))
        self.assertGreater(said["topics"]["UNLATCH_STATE"], 100)
        self.assertTrue(said["scenario"] and said["participants"] and said["program"].startswith("unlatch "))
        again = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertTrue(again["replay"]["agrees"])
        self.assertEqual(again["hash"], report["hash"])
        result = self.run_ok(UNLATCH, "replay", heard, code=2)
        self.assertIn("not a recording", result.stderr)

    # --- faults on purpose --------------------------------------------------------------------------------------

    def run_with_faults(self, transport, name, *arguments, until="3", code=0):
        log = self.folder / f"{name}-{transport}.log"
        report = self.run_over(transport, "--pace", "lockstep", "--until", until, "--log", log, "--faults",
                               SCENARIOS / f"boosters/faults/{name}.yaml", *arguments, code=code)
        again = self.run_json(UNLATCH, "replay", log, code=code)  # without the script
        self.assertTrue(again["replay"]["agrees"])
        self.assertEqual((again["hash"], again["notices"]), (report["hash"], report["notices"]))
        return report

    def test_a_lossy_line_changes_no_bit_over_any_transport(self):
        good = self.run_over("inproc", "--pace", "lockstep", "--until", "1", *PATIENT)
        for transport in ("inproc", "dds", "lcm", "udp"):
            report = self.run_with_faults(transport, "lossy-line", *PATIENT, until="1")
            self.assertEqual(report["hash"], good["hash"])
            self.assertGreater(report["timing"]["resent"], 50)

    def test_a_stuck_contact_and_a_jammed_nozzle_keep_the_nose_on_the_core(self):
        for name in ("stuck-contact", "jammed-nozzle"):
            report = self.run_with_faults("inproc", name, *PATIENT, code=1)  # the nose strikes the core
            times = {(e["name"], e["subject"]): e["t"] for e in report["events"]}
            self.assertIn(("contact", "booster1"), times)
            self.assertNotIn(("nozzle", "booster1"), times)
            self.assertIn(("nozzle", "booster2"), times)
            self.assertIn({"t": 0.0, "name": "fault." + ("stick" if "contact" in name else "jam"),
                           "subject": "kr1" if "contact" in name else "nozzle1"}, report["notices"])

    def test_a_frozen_computer_comes_back_at_its_tick_the_same_way_every_time(self):
        patience = ["--set", "flight_software.timeout=1", "--set", "flight_software.require={lost: 1}"]
        reports = [self.run_with_faults(transport, "frozen-computer", *patience) for transport in ("inproc", "dds")]
        self.assertEqual(len({report["hash"] for report in reports}), 1)
        names = [n["name"] for n in reports[0]["notices"]]
        self.assertEqual(names, ["participant.joined", "fault.freeze", "policy.hold", "fault.freeze.end",
                                 "participant.resumed"])
        self.assertNotIn("ties_cut", {event["name"] for event in reports[0]["events"]})

    def test_a_mistake_in_a_fault_script_has_file_and_line(self):
        script = self.folder / "bad.yaml"
        script.write_text("unlatch_faults: 1\nfaults:\n  - stick: kr9\n    ticks: [3, 1]\n")
        result = self.run_ok(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--faults", script,
                             code=2)
        self.assertRegex(result.stderr, r"bad\.yaml:3:\d+: unknown sensor 'kr9'; did you mean 'kr")
        self.assertRegex(result.stderr, r"bad\.yaml:4:\d+: these ticks end before they begin")

    # --- one flight software more, or one less ------------------------------------------------------------------

    def test_a_second_computer_of_one_name_is_named_and_a_killed_one_can_be_started_again(self):
        first = self.begin(FSW, "--transport", "dds")
        simulator = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "realtime", "--until", "60",
                               "--set", "flight_software.timeout=1", stderr=subprocess.PIPE)

        def read_until(words):
            said = ""
            while words not in said:
                line = simulator.stderr.readline()
                self.assertNotEqual(line, "", said)
                said += line

        read_until("takes part")
        self.begin(FSW, "--transport", "dds")
        read_until("a second flight software named 'fsw' asks to take part and is refused")
        first.kill()
        read_until("policy 'hold' is applied")
        read_until("was started again and takes part")  # the second one replaces the first
        simulator.send_signal(signal.SIGINT)

    def kill_flight_software(self, policy, pace, code):
        """Kills it with SIGKILL mid-run; returns the report and the text for people."""
        log = self.folder / f"{policy}-{pace}.log"
        result_file = self.folder / f"{policy}-{pace}.json"
        fsw = self.begin(FSW, "--transport", "dds")
        simulator = self.begin(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", pace, "--until", "30",
                               "--set", "flight_software.timeout=0.5", "--set", f"flight_software.policy={policy}",
                               "--log", log, "--json", result_file, stderr=subprocess.PIPE)
        said = ""
        while "takes part" not in said:
            line = simulator.stderr.readline()
            self.assertNotEqual(line, "", said)
            said += line
        time.sleep(0.3)
        fsw.kill()
        if code is None:
            return simulator, log, said
        said += simulator.communicate(timeout=HANG)[1]
        self.assertIn(simulator.returncode, (code, 1), said[-2000:])  # the distance that is kept depends on the time of the kill
        again = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertTrue(again["replay"]["agrees"])
        report = json.loads(result_file.read_text())
        self.assertEqual(again["notices"], report["notices"])
        self.assertEqual(again["hash"], report["hash"])
        return report, said

    def test_killed_flight_software_ends_in_the_policy_hold(self):
        report, said = self.kill_flight_software("hold", "lockstep", 0)
        self.assertEqual([n["name"] for n in report["notices"]], ["participant.joined", "policy.hold"])
        self.assertEqual((report["status"], report["ticks"]), ("ok", 30000))
        self.assertIn("has not answered for 0.5", said)
        self.assertEqual([(limit["id"], limit["value"], limit["at_most"], limit["met"]) for limit in report["session_limits"]],
                         [("flight_software.lost", 1, 0, False), ("flight_software.refused", 0, 0, True),
                          ("flight_software.late", 0, 0.01, True)])

    def test_a_run_that_lost_its_flight_software_is_failed_unless_that_is_the_test(self):
        self.kill_flight_software("safe", "lockstep", 1)
        log = self.folder / "safe-lockstep.log"
        junit = self.folder / "lost.xml"
        result = call(UNLATCH, "replay", log, "--junit", junit)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("flight_software.lost      not met  times that a required participant was lost: 1, at most 0", result.stdout)
        case = next(case for case in ElementTree.parse(junit).iter("testcase") if case.get("name") == "flight_software.lost")
        self.assertEqual(case.find("failure").get("type"), "not met")

    # The reference flight software throttles to 0.84; of this channel that is out of range.
    def test_a_run_whose_commands_were_refused_is_failed_unless_that_is_the_test(self):
        log, junit = self.folder / "refused.log", self.folder / "refused.xml"
        command = (UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", "0.3",
                   "--set", "channels.throttle1={range: [0.9, 1], initial: 1, safe: 0.95}", "--log", log)
        report = self.run_json(*command, "--junit", junit, code=1)
        limits = {limit["id"]: limit for limit in report["session_limits"]}
        refused = report["timing"]["rejected"]["out_of_range"]
        self.assertGreater(refused, 0)
        self.assertEqual(limits["flight_software.refused"]["value"], refused)
        self.assertEqual((limits["flight_software.refused"]["at_most"], limits["flight_software.refused"]["met"]), (0, False))
        case = next(case for case in ElementTree.parse(junit).iter("testcase") if case.get("name") == "flight_software.refused")
        self.assertEqual(case.find("failure").get("message"), f"commands that were refused: {refused}, at most 0")
        again = self.run_json(UNLATCH, "replay", log, code=1)
        self.assertEqual(again["session_limits"], report["session_limits"])
        page = self.folder / "refused.html"
        self.run_ok(UNLATCH, "report", log, "--out", page, code=None)
        self.assertIn("flight_software.refused", page.read_text())
        for limit in f"require={{refused: {refused}}}", f"require.refused={refused}":
            allowed = self.run_json(*command, "--set", f"flight_software.{limit}", code=None)
            self.assertEqual([limit["met"] for limit in allowed["session_limits"]], [True, True, True])

    def test_killed_flight_software_ends_in_the_policy_abort(self):
        report, said = self.kill_flight_software("abort", "realtime", 1)
        self.assertEqual(report["status"], "aborted")
        self.assertEqual(report["notices"][-1]["name"], "policy.abort")
        self.assertIn("policy 'abort' is applied", said)

    def test_a_paused_run_can_be_interrupted_and_its_recording_replays(self):
        simulator, log, said = self.kill_flight_software("pause", "realtime", None)
        while "policy 'pause'" not in said:
            line = simulator.stderr.readline()
            self.assertNotEqual(line, "", said)
            said += line
        simulator.send_signal(signal.SIGINT)
        simulator.communicate(timeout=HANG)
        self.assertEqual(simulator.returncode, 1)
        again = self.run_json(UNLATCH, "replay", log, code=None)
        self.assertEqual((again["status"], again["message"]), ("aborted", "interrupted"))
        self.assertTrue(again["replay"]["agrees"])

    def test_flight_software_that_never_comes_is_named(self):
        result = self.run_ok(UNLATCH, "hil", BOOSTERS, "--transport", "dds", "--pace", "lockstep", "--start-timeout",
                             "0.3", code=1)
        self.assertIn("no answer from the flight software 'fsw'", result.stdout)

    def test_flight_software_refuses_a_vehicle_that_it_does_not_know(self):
        report = self.run_over("dds", "--pace", "lockstep", scenario=self.write_strange_vehicle(), code=1)
        self.assertEqual(report["status"], "aborted")
        self.assertIn("lacks channel verniers", report["message"])

    def write_strange_vehicle(self):
        path = self.folder / "strange.yaml"
        path.write_text("unlatch: 1\nname: strange\nstep: {dt: 0.001, until: 1}\n"
                        "bodies:\n  core: {mass: 1, inertia: [1, 1, 1]}\n"
                        "channels:\n  warp: {initial: 0, range: [0, 1]}\n"
                        "elements:\n  engine: {type: thrust, body: core, direction: [1, 0, 0], profile: 1, channel: warp}\n"
                        "flight_software: {required: [fsw]}\n")
        return path

    def test_flight_software_gives_up_without_a_simulator(self):
        result = self.run_ok(FSW, "--transport", "dds", "--patience", "0.3", code=1)
        self.assertIn("no simulator was found", result.stderr)


if __name__ == "__main__":
    main()
