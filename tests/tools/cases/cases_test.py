#!/usr/bin/env python3
"""Inputs of users that once gave a wrong number with status ok, or a verdict without grounds, each with what is right. The files
beside this one are theirs. Run by ctest:

    cases_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import csv
import json
import math
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

from processes import BIN, HANG, SANITIZED, UNLATCH, ProcessTest, main

HERE = Path(__file__).resolve().parent
PACKAGE = BIN.parent / "python"
OBC = BIN / "cases_obc"

TIP_OFF = 0.05247  # rad/s, with 64 to 1024 sub-steps; with one it was 0.0326
BOX_TURN = 0.551288  # rad, of parts of 1/64 of a step, at 1 ms and at 0.25 ms; those that contacts choose are off by 1.8e-3
BOX_TURN_ERROR = 1e-5
TIP_OFF_ERROR = 5e-4  # of the sub-steps chosen by the contact: 1 % of the value; the limit is 0.0349


class CasesTest(ProcessTest):
    def setUp(self):
        super().setUp()
        for file in HERE.glob("*.yaml"):
            shutil.copy(file, self.folder)

    def change(self, file, *replacements):
        path = self.folder / file
        text = path.read_text()
        for old, new in replacements:
            self.assertEqual(text.count(old), 1, old)
            text = text.replace(old, new)
        path.write_text(text)
        return path

    def run_python(self, program, *arguments, code=0):
        if SANITIZED or not PACKAGE.exists():
            self.skipTest("no Python package in this build")
        (self.folder / "program.py").write_text(program)
        done = subprocess.run([sys.executable, "program.py", *arguments], cwd=self.folder, capture_output=True, text=True, timeout=HANG,
                              env={**os.environ, "PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout, done.stderr

    # --- Contacts between two steps ---------------------------------------------------------------------------------

    def test_a_tip_off_between_rails_is_never_met_with_too_few_sub_steps(self):
        tip = self.folder / "tip.yaml"
        report = self.run_json(UNLATCH, "run", tip, code=1)
        self.assertEqual((report["status"], report["verdict"][0]["met"], report["verdict"][0]["resolved"]), ("ok", False, True))
        self.assertAlmostEqual(report["verdict"][0]["value"], TIP_OFF, delta=TIP_OFF_ERROR)
        for substeps in 1, 2, 4, 8, 16, 32:
            said = self.run_json(UNLATCH, "run", tip, "--set", f"step.contact_substeps={substeps}", code=1)
            verdict = said["verdict"][0]
            self.assertFalse(verdict["met"], substeps)
            if verdict["resolved"]:
                self.assertAlmostEqual(verdict["value"], TIP_OFF, delta=TIP_OFF_ERROR, msg=f"{substeps} sub-steps")
            else:
                self.assertEqual(said["status"], "unresolved")

    def test_a_campaign_between_rails_counts_what_is_not_resolved(self):
        campaign = self.change("tip-campaign.yaml", ("samples: 300", "samples: 60"))
        coarse = self.run_json(UNLATCH, "campaign", campaign, "--out", self.folder / "coarse", "--set", "step.contact_substeps=1", code=1)
        self.assertEqual(coarse["statuses"]["unresolved"], 60)
        self.assertEqual(coarse["requirements"][0]["unresolved"], 60)
        self.assertEqual(coarse["any_requirement"]["probability"], [0, 1])
        fine = self.run_json(UNLATCH, "campaign", campaign, "--out", self.folder / "fine", code=1)
        self.assertEqual(fine["statuses"].get("unresolved", 0), 0)
        # 0.79 to 0.87 by 300 samples at 64 sub-steps.
        low, high = fine["requirements"][0]["probability"]
        self.assertLess(low, 0.87)
        self.assertGreater(high, 0.79)
        self.assertGreater(fine["requirements"][0]["failed"], 0.64 * 60)

    def test_an_error_of_the_parts_that_contacts_choose_is_seen_by_accuracy_and_tolerance(self):
        box = self.folder / "box.yaml"

        def get_turn(report):
            w, _, _, z = report["samples"][-1]["bodies"]["box"]["q"]
            return 2 * math.atan2(z, w)

        # Parts that are 16 times as fine, and as fine again with half the step.
        finest = self.run_json(UNLATCH, "run", box, "--set", "step.contact_refinement=16")
        self.assertAlmostEqual(get_turn(finest), BOX_TURN, delta=BOX_TURN_ERROR)
        report = self.run_json(UNLATCH, "run", box, "--accuracy", "1e-3", code=None)
        error = abs(report["samples"][-1]["bodies"]["box"]["q"][3] - math.sin(BOX_TURN / 2))
        estimate = next(e for e in report["accuracy"] if e["what"] == "final attitude of box z")
        self.assertGreater(estimate["error"], 0.8 * error)

    # --- Studies -----------------------------------------------------------------------------------------------------

    def test_an_even_dependence_is_seen_by_the_sensitivities_of_any_sampling(self):
        campaign = self.change("sat-campaign.yaml", ("samples: 2000", "samples: 500"))
        short = ["--set", "step.until=0.4", "--set", "step.dt=2 ms"]
        summary = self.run_json(UNLATCH, "campaign", campaign, "--out", self.folder / "given", *short, code=1)
        given = next(c for c in summary["columns"] if c["name"] == "tipoff")["sensitivity"]
        inputs = [column["name"] for column in summary["inputs"]]
        first = dict(zip(inputs, given["first_order"]))
        rank = dict(zip(inputs, given["spearman"]))
        text = self.run_ok(UNLATCH, "campaign", campaign, "--out", self.folder / "given", "--resume", *short, code=1).stdout
        self.assertRegex(text, r"Influences: parts .*\n  tipoff +d[yz] [\d.]+ \(.*, d[yz] [\d.]+ \(.*; chance reaches 0\.\d+")
        pairs = self.change("sat-saltelli.yaml", ("samples: 2304", "samples: 576"), ("until: 0.4 s", "until: 0.4 s, step.dt: 2 ms"))
        saltelli = self.run_json(UNLATCH, "campaign", pairs, "--out", self.folder / "saltelli", code=1)
        text = self.run_ok(UNLATCH, "campaign", pairs, "--out", self.folder / "saltelli", "--resume", code=1).stdout
        self.assertRegex(text, r"Influences: Sobol' totals.*\n  tipoff +d[yz] [\d.]+ \(.*, d[yz] [\d.]+ \(")
        design = next(c for c in saltelli["columns"] if c["name"] == "tipoff")["sensitivity"]["sobol"]
        total = dict(zip([column["name"] for column in saltelli["inputs"]], design))
        for axis in "dy", "dz":
            self.assertLess(abs(rank[axis]), 0.1)  # blind
            self.assertGreater(first[axis]["interval"][0], given["significant"])
            self.assertGreater(first[axis]["index"], 0.15)
            self.assertLess(first[axis]["interval"][0], total[axis]["total"])  # first order is a part of the total
            self.assertGreater(total[axis]["total"], 0.3)

    # With 64 samples it said that there is no design; with 512 it found 11.25 J.
    def test_a_search_with_64_samples_finds_what_one_with_512_finds(self):
        problem = self.change("sat-springs.yaml", ("budget: {runs: 60, seconds: 200}", "budget: {runs: 60}"),
                              ("scenario: sat.yaml", "set: {step.until: 0.4 s}\nscenario: sat.yaml"))
        done = subprocess.run([UNLATCH, "optimize", problem, "--out", self.folder / "o"], capture_output=True, text=True)
        result = json.loads((self.folder / "o/result.json").read_text())
        self.assertIn(result["status"], ("optimal", "budget"), done.stdout)
        self.assertEqual(result["verification"]["dispersed"][0]["verdict"], "confirmed")
        self.assertAlmostEqual(result["objectives"][0]["value"] / 11.25, 1, delta=0.02)
        self.assertGreater(result["samples"], 64)

    # Ten runs are too few to find a design: that is said of the budget, not of the problem.
    def test_a_search_with_few_samples_and_runs_denies_nothing(self):
        problem = self.change("sat-springs.yaml", ("budget: {runs: 60, seconds: 200}", "budget: {runs: 5}"), ("samples: 64", "samples: 16, checks: 64, most: 16"),
                              ("scenario: sat.yaml", "set: {step.until: 0.4 s, step.dt: 5 ms}\nscenario: sat.yaml"))
        done = subprocess.run([UNLATCH, "optimize", problem, "--out", self.folder / "o"], capture_output=True, text=True)
        result = json.loads((self.folder / "o/result.json").read_text())
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(result["status"], ("undecided", "not-found"), done.stdout)

    def test_two_wildcards_of_one_parameter_give_different_names(self):
        said = self.run_ok(UNLATCH, "check", self.folder / "fairing-equal.yaml", code=2).stderr
        self.assertIn("no parameter 'preload:l'", said)
        self.assertIn("preload:low_l, preload:low_r, preload:high_l, preload:high_r", said)
        path = self.change("fairing-equal.yaml", ('"preload:l"', '"preload:low_l"'))
        self.run_json(UNLATCH, "check", path)

    def test_a_table_with_two_wildcards_is_read_whole(self):
        campaign = self.change("fairing-campaign.yaml", ("samples: 2000", "samples: 12"))
        out = self.folder / "out"
        self.run_ok(UNLATCH, "campaign", campaign, "--out", out, "--set", "step.until=0.3", code=1)
        with open(out / "samples.csv", newline="", encoding="utf-8") as file:
            header = next(csv.reader(file))
        self.assertEqual(len(set(header)), len(header))
        said, _ = self.run_python("import sys, unlatch\nprint(len(unlatch.read_table(sys.argv[1])))\n", str(out / "samples.csv"))
        self.assertEqual(int(said), len(header))

    # --- One run -----------------------------------------------------------------------------------------------------

    def test_halves_that_part_from_each_other_have_not_left_their_stage(self):
        said = self.run_ok(UNLATCH, "run", self.folder / "fairing.yaml").stdout
        self.assertNotIn("longer than", said)
        report = self.run_json(UNLATCH, "run", self.folder / "fairing.yaml")
        released = {tuple(s["pair"]): s["release"] for s in report["separations"] if not s["still_joined"]}
        self.assertAlmostEqual(released["stage", "half1"], released["stage", "half2"], delta=1e-6)  # both hinges let go at 60 deg
        self.assertGreater(released["stage", "half1"], 1.7)
        unzipped = [s for s in report["separations"] if s["still_joined"]]
        self.assertEqual([(s["release"], len(s["springs"])) for s in unzipped], [(0.1, 4)])

    def test_a_pusher_without_a_direction_is_a_finding_of_check_and_of_the_run(self):
        path = self.change("sat.yaml", ("        guide: [1, 0, 0]\n", ""))
        warned = self.run_json(UNLATCH, "check", path)["warnings"]
        self.assertEqual(len([w for w in warned if "coincide" in w["text"]]), 4)
        report = self.run_json(UNLATCH, "run", path, code=1)
        self.assertEqual(report["status"], "unresolved")
        self.assertEqual(report["warnings"], warned)
        self.assertFalse(any(verdict["met"] or verdict["resolved"] for verdict in report["verdict"]))

    # --- Sessions ----------------------------------------------------------------------------------------------------

    def fly(self, *options, obc=(), code=0, kill=None):
        """Flies the bench with its own flight software over UDP. `kill`: after so many seconds of wall time."""
        self.log = self.folder / "bench.log"
        simulator = subprocess.Popen([UNLATCH, "hil", self.folder / "bench.yaml", "--transport", "udp", "--log", self.log, "--json", "-", *options],
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        software = self.begin(OBC, *obc)
        if kill is not None:
            while not self.log.exists():
                time.sleep(0.01)
            time.sleep(kill)
            software.kill()
        said, errors = simulator.communicate(timeout=HANG)
        if code is not None:
            self.assertEqual(simulator.returncode, code, errors)
        return json.loads(said)

    def test_sensors_are_shown_as_flight_software_received_them(self):
        self.change("bench-faults.yaml", ("  - freeze: obc\n    ticks: [2000, 2100]\n", ""))  # a frozen computer costs its time-out
        report = self.fly("--pace", "lockstep", "--faults", self.folder / "bench-faults.yaml", "--set", "flight_software.timeout=30", code=None)
        out = self.folder / "bench.csv"
        self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", out)
        with open(out, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        true, got = ([float(row[f"{kind}.gap [m]"]) for row in rows] for kind in ("sensor", "received"))
        self.assertEqual(len(set(got[1000:2001])), 1)  # stuck from 5 to 10 s
        self.assertGreater(true[2000] - true[1000], 2)
        self.assertEqual((got[999], got[2001]), (true[999], true[2001]))
        bias = [float(row["received.gyro.x [rad/s]"]) - float(row["sensor.gyro.x [rad/s]"]) for row in rows]
        self.assertAlmostEqual(bias[1000], 0.0087, delta=1e-15)
        self.assertEqual((bias[499], bias[1501]), (0, 0))
        recorded = {event["name"] for event in report["session_events"]}
        self.assertLessEqual({"fault.stick", "fault.bias", "fault.jam"}, recorded)
        program = ("import json, sys, unlatch\n"
                   "table = unlatch.read_recording(sys.argv[1])\n"
                   "print(json.dumps([list(table[name]) for name in ('received.gap', 'sensor.gap', 'received.gyro.x')]))\n")
        said, _ = self.run_python(program, str(self.log))
        self.assertEqual(json.loads(said), [got, true, [float(row["received.gyro.x [rad/s]"]) for row in rows]])

    def test_flight_software_that_is_killed_fails_a_session_whose_policy_goes_on(self):
        junit = self.folder / "out.xml"
        report = self.fly("--pace", "realtime", "--until", "3", "--junit", junit, "--set", "requirements=[]", code=1, kill=1)
        self.assertIn("policy.safe", [event["name"] for event in report["session_events"]])
        limits = {limit["id"]: limit["met"] for limit in report["session_limits"]}
        limits.pop("flight_software.overruns", None)  # on a busy machine ticks overrun; without a limit they are listed only
        limits.pop("flight_software.late", None)  # on a busy machine commands are late
        self.assertEqual(limits, {"flight_software.lost": False, "flight_software.refused": True})
        cases = {case.get("name"): case for case in ElementTree.parse(junit).iter("testcase")}
        self.assertIsNotNone(cases["flight_software.lost"].find("failure"))

    def test_late_answers_are_in_the_histogram(self):
        report = self.fly("--pace", "realtime", "--until", "3", "--set", "requirements=[]", obc=("slow",), code=None)
        timing = report["timing"]
        states = 600  # of 5 ms; each third is answered 8 ms later
        self.assertGreater(timing["late_answers"], 0.9 * states / 3)
        self.assertGreater(timing["round_trip_ns"]["count"], 0.9 * states)
        late = sum(count for at, count in timing["round_trip_ns"]["histogram"] if at > 5_000_000)
        self.assertGreater(late, 0.9 * states / 3)
        self.assertGreater(timing["round_trip_ns"]["p90"], 8_000_000)

    def test_late_commands_beyond_one_percent_fail_a_session_unless_that_is_the_test(self):
        flight = ("--pace", "realtime", "--until", "3", "--set", "requirements=[]")
        junit = self.folder / "late.xml"
        report = self.fly(*flight, "--junit", junit, obc=("slow",), code=1)
        limit = next(limit for limit in report["session_limits"] if limit["id"] == "flight_software.late")
        self.assertGreater(limit["value"], 0.3)  # from 1.5 s on three commands of each third tick
        self.assertEqual((limit["at_most"], limit["met"]), (0.01, False))
        cases = {case.get("name"): case for case in ElementTree.parse(junit).iter("testcase")}
        self.assertIsNotNone(cases["flight_software.late"].find("failure"))
        again = self.run_ok(UNLATCH, "replay", self.log, code=1).stdout
        self.assertRegex(again, r"flight_software.late +not met +late commands, as a part of the ticks: 0\.\d+, at most 0.01")
        allowed = self.fly(*flight, "--set", "flight_software.require.late=1", obc=("slow",))  # no limit: the machine may be busy
        self.assertTrue(next(limit for limit in allowed["session_limits"] if limit["id"] == "flight_software.late")["met"])

    # --- Python ------------------------------------------------------------------------------------------------------

    def test_a_batch_names_its_samples_without_results(self):
        said, errors = self.run_python(
            "import unlatch\n"
            "with unlatch.Batch('sat.yaml', {'step.until': 0.4}, judge=True) as b:\n"
            "    b.add({'constants.dy': 0.001}); b.add({'constants.f1': 1.01}); b.add({'constants.dy': '1 mm'}); b.add({'bodies.xx.mass': 3})\n"
            "    b.run()\n"
            "    print(list(b.ok), [bool(b.why(i)) for i in range(4)], b.values['tipoff'][0] == b.values['tipoff'][2])\n")
        self.assertEqual(said, "[True, True, True, False] [False, False, False, True] True\n")  # 0.001 is 1 mm: the constant keeps its unit
        self.assertIn("SampleWarning: 1 of 4 samples have no results: sample 3", errors)

    def test_errors_come_out_of_other_processes(self):
        program = ("import concurrent.futures as futures, multiprocessing, sys, unlatch\n"
                   "def one(mass):\n"
                   "    with unlatch.load('sat.yaml', {'bodies.satellite.mass': mass, 'step.until': '0.2 s'}, judge=True) as sim:\n"
                   "        sim.run()\n"
                   "        return sim.tick\n"
                   "def bad(mass):\n"
                   "    return unlatch.load('sat.yaml', {'bodies.satelite.mass': mass})\n"
                   "if __name__ == '__main__':\n"
                   "    multiprocessing.set_start_method(sys.argv[1])\n"
                   "    with multiprocessing.Pool(2) as pool:\n"
                   "        print(pool.map(one, [110, 120, 130]))\n"
                   "        try: pool.apply_async(bad, (3,)).get(timeout=60)\n"
                   "        except unlatch.ScenarioError as error: print('pool', error)\n"
                   "        try: pool.map(bad, [1, 2])\n"
                   "        except unlatch.ScenarioError as error: print('map', error)\n"
                   "    with futures.ProcessPoolExecutor(2) as pool:\n"
                   "        try: pool.submit(bad, 3).result(timeout=60)\n"
                   "        except unlatch.ScenarioError as error: print('futures', error)\n")
        for method in "fork", "spawn", "forkserver":
            said, _ = self.run_python(program, method)
            self.assertIn("[200, 200, 200]", said)
            for kind in "pool", "map", "futures":
                self.assertRegex(said, rf"(?m)^{kind} .*satelite", method)

    def test_ctrl_c_stops_a_batch_that_can_go_on(self):
        program = ("import os, signal, threading, time, unlatch\n"
                   "batch = unlatch.Batch('sat.yaml', {'step.until': '60 s'})\n"
                   "for i in range(SAMPLES): batch.add({})\n"
                   "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
                   "begin = time.monotonic()\n"
                   "try:\n"
                   "    batch.run()\n"
                   "    print('ran through')\n"
                   "except KeyboardInterrupt:\n"
                   "    print('stopped', time.monotonic() - begin < 30, batch.ok.sum() < len(batch.ok))\n"
                   "    batch.run(until=0.01)\n"
                   "    print('went on')\n")
        said, _ = self.run_python(program.replace("SAMPLES", "400"))
        self.assertIn("stopped True True", said)


if __name__ == "__main__":
    main()
