#!/usr/bin/env python3
"""Verbs that can last longer than a second end within a second of Ctrl-C and of SIGTERM, with what they have. Run by ctest:

    stops_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]

The second is one of the process's processor time, so that a busy machine changes nothing.
"""
import os
import re
import signal
import subprocess
import time
from pathlib import Path

from processes import BIN, HANG, SCENARIOS, UNLATCH, ProcessTest, main

SIGNALS = (signal.SIGINT, signal.SIGTERM)
UNDER_WAY, ENOUGH = 0.3, 1.0  # s of processor time: at work; from the signal to the end
# No step is fine enough for the tolerance: the trials of --accuracy would go on for minutes.
CHAOS = """unlatch: 1
name: chaos
step: {dt: 1 ms, until: 20 s}
gravity: {uniform: [0, 0, -9.81]}
bodies:
  a: {mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, 0]}
  b: {mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [1, 0, 0.5]}
joints:
  h: {between: [ground, a], follower_point: [-0.5, 0, 0], modes: {hinge: {kind: revolute, axis: y}}}
  k: {between: [a, b], point: [0.5, 0, 0], follower_point: [0, 0, -0.5], modes: {hinge: {kind: revolute, axis: y}}}
"""

# Verbs that write a text, or read files once: they catch no signal, and end by it at once.
QUICK = {"check", "init", "import", "resample", "compile", "modes", "completion", "man", "preflight", "requirements"}
# Verbs whose end a test below looks at.
STOPPED = {"run", "campaign", "optimize", "hil", "linearize", "replay", "diff", "report", "export", "log", "watch", "telemetry", "dossier"}


def get_processor_s(process):
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class StopsTest(ProcessTest):
    def stop(self, number, *arguments, after=UNDER_WAY):
        """Sends the signal once the process has worked for `after`; returns its exit code and the processor time from then on."""
        process = self.begin(*arguments)
        deadline = time.monotonic() + HANG
        while (worked := get_processor_s(process)) < after:
            self.assertIsNone(process.poll(), f"{arguments} ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)
        process.send_signal(number)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertLess(usage.ru_utime + usage.ru_stime - worked, ENOUGH, arguments)
        return process.returncode

    def test_every_verb_is_walked_through(self):
        listed = subprocess.run([UNLATCH, "--help"], capture_output=True, text=True, check=True).stdout.partition("Subcommands:")[2]
        self.assertEqual(set(re.findall(r"^  ([a-z]+) ", listed.partition("\n\n")[0], re.MULTILINE)), QUICK | STOPPED)

    def write_chaos(self):
        scenario = self.folder / "chaos.yaml"
        scenario.write_text(CHAOS)
        return scenario

    def test_run_ends_with_the_results_so_far(self):
        for number in SIGNALS:
            result = self.folder / f"{number}.json"
            self.assertEqual(self.stop(number, UNLATCH, "run", self.write_chaos(), "--until", "1e6", "--json", result), 1)
            self.assertIn('"interrupted"', result.read_text())

    def test_a_run_that_estimates_its_accuracy_ends_with_what_it_has(self):
        scenario = self.write_chaos()
        for number in SIGNALS:
            result = self.folder / f"{number}.json"
            self.stop(number, UNLATCH, "run", scenario, "--until", "400", "--accuracy", "--json", result, after=2.0)  # a fifth is the flight itself
            self.assertTrue(result.read_text())

    def test_accuracy_ends_by_itself_where_no_step_meets_the_tolerance(self):
        result = self.run_json(UNLATCH, "run", self.write_chaos(), "--until", "5", "--accuracy", code=None)
        self.assertIn("accuracy", result)

    def test_hil_ends_with_the_results_so_far(self):
        for number in SIGNALS:
            result = self.folder / f"{number}.json"
            self.stop(number, UNLATCH, "hil", SCENARIOS / "boosters/scenario.yaml", "--transport", "inproc", "--pace", "lockstep",
                      "--until", "1e6", "--json", result)
            self.assertIn('"interrupted"', result.read_text())

    def test_replay_diff_report_and_export_end(self):
        log = self.folder / "long.log"
        self.run_ok(UNLATCH, "run", self.write_chaos(), "--until", "500", "--log", log)
        for number in SIGNALS:
            for more in (["replay", log], ["diff", log, log], ["report", log, "--out", self.folder / "r.html"],
                         ["export", log, "--format", "csv", "--out", self.folder / "e.csv"]):
                self.stop(number, UNLATCH, *more)

    def test_a_linear_model_of_a_late_state_and_a_search_for_the_step_end(self):
        scenario = self.write_chaos()
        for number in SIGNALS:
            self.stop(number, UNLATCH, "linearize", scenario, "--until", "1e6", "--at", "9e5")
            self.stop(number, UNLATCH, "run", scenario, "--until", "1e6", "--tolerance", "1e-3")

    def test_a_dossier_ends_and_writes_nothing(self):
        scenario = self.folder / "long.yaml"
        scenario.write_text(CHAOS.replace("until: 20 s", "until: 20000 s"))
        page = self.folder / "dossier.html"
        for number in SIGNALS:
            self.assertEqual(self.stop(number, UNLATCH, "dossier", scenario, "--out", page), 1)
            self.assertFalse(page.exists())

    def write_campaign(self):
        self.write_chaos()
        campaign = self.folder / "chaos-campaign.yaml"
        campaign.write_text("""unlatch_campaign: 1
name: chaos
scenario: chaos.yaml
samples: 100000
parameters:
  mass: {path: bodies.a.mass, normal: {mean: 1 kg, sigma: 0.01 kg, within: 3}}
""")
        return campaign

    def test_a_campaign_ends_with_the_samples_so_far_and_goes_on(self):
        campaign = self.write_campaign()
        for number in SIGNALS:
            out = self.folder / f"results{number}"
            self.assertEqual(self.stop(number, UNLATCH, "campaign", campaign, "--jobs", "2", "--out", out, after=1.5), 1)
            self.assertTrue((out / "summary.json").exists())

    def test_a_search_ends_with_what_it_has(self):
        problem = self.folder / "chaos-optimize.yaml"
        self.write_chaos()
        problem.write_text("""unlatch_optimize: 1
name: chaos
scenario: chaos.yaml
variables:
  mass: {path: bodies.a.mass, between: [0.5 kg, 2 kg]}
objectives: [{minimise: (mass / (1 kg) - 1.3)^2}]
method: global
budget: {runs: 100000}
""")
        for number in SIGNALS:
            self.stop(number, UNLATCH, "optimize", problem, "--out", self.folder / f"search{number}.json", after=1.5)

    def test_listeners_and_flight_software_end(self):
        for number in SIGNALS:
            for arguments in ((UNLATCH, "watch", "--transport", "udp"), (UNLATCH, "log", "--transport", "udp", "--out", self.folder / "l.log"),
                              (UNLATCH, "telemetry", "--transport", "udp", "--live", "127.0.0.1:0"),
                              (BIN / "unlatch-fsw", "--transport", "udp")):
                process = self.begin(*arguments)
                time.sleep(0.7)
                process.send_signal(number)
                process.wait(10)


if __name__ == "__main__":
    main()
