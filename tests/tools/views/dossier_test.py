#!/usr/bin/env python3
"""`unlatch dossier` as users run it, and its page in a real browser without a network:

    dossier_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from browser import CHROMIUM, Browser
from processes import SOURCE, UNLATCH, ProcessTest, call, main

HOSTILE = "</script><script>window.struck = 1</script><!-- <img src=x onerror='window.struck = 2'>"
SCENARIO = """unlatch: 1
name: pass
title: Two that pass
step: {dt: 1 ms, until: 1}
constants: {gap: 1 m}
bodies:
  still: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.25}}]}
  moving: {mass: 2 kg, inertia: [1, 1, 1], position: [-1.2345678, gap, 0], velocity: [2, 0, 0], shape: [{sphere: {radius: 0.5}}]}
elements:
  spring: {type: spring, between: [still, moving], stiffness: 0.3 N/m, free_length: 0.5}
events: [{name: late, when: {time: 0.4}}]
requirements:
  - {id: near, text: HOSTILE, parent: SYS-4, rationale: as in the drawing, clearance: [still, moving], at_least: 0.1}
  - {id: soon, time: {event: late}, at_most: 0.3}
basis:
  - {of: bodies.*.mass, is: measured, uncertainty: 0.5 %, source: weighing report 12}
  - {of: elements.spring.stiffness, is: datasheet, uncertainty: 0.01 N/m}
  - {of: constants, is: assumed}
""".replace("HOSTILE", json.dumps(HOSTILE))
CAMPAIGN = """unlatch_campaign: 1
name: passes
scenario: pass.yaml
samples: 40
seed: 3
parameters:
  push: {path: elements.spring.stiffness, normal: {mean: nominal, sigma: 10 %}}
  late: {path: events.late.when.time, uniform: {min: 0.2, max: 0.35}}
"""
STATEMENTS = """intended_use: To decide whether the two may pass
author: A. Engineer
validation: {level: 1, text: One film of a test}
people: Ten years of separations
"""


class DossierTest(ProcessTest):
    """One browser for all facts."""

    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def setUp(self):
        super().setUp()
        self.scenario = self.write("pass.yaml", SCENARIO)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def build(self, *arguments, code=1):  # as `run`: the scenario misses a requirement
        """The contents, and the path of the page."""
        page, contents = self.folder / "dossier.html", self.folder / "dossier.json"
        self.run_ok(UNLATCH, "dossier", *arguments, "--out", page, "--json", contents, code=code)
        return json.loads(contents.read_text()), page

    def open(self, page):
        self.browser.open(page)
        self.assertEqual(self.browser.complaints, [])
        self.assertEqual([url for url in self.browser.requests if not url.startswith(("file:", "data:"))], [])

    def ask(self, expression):
        return self.browser.evaluate(expression)

    def read_table(self, place):
        return self.ask(f"[...document.querySelectorAll('#{place} tr')].slice(1).map((row) => [...row.cells].map((cell) => cell.textContent))")

    def fly_campaign(self):
        campaign, results = self.write("campaign.yaml", CAMPAIGN), self.folder / "results"
        self.run_ok(UNLATCH, "campaign", campaign, "--out", results, code=None)
        return campaign, results

    def test_the_contents_are_those_of_the_run_and_of_the_file(self):
        contents, _ = self.build(self.scenario)
        run = self.run_json(UNLATCH, "run", self.scenario, "--accuracy", "1e-6", code=1)
        self.assertEqual(contents["run"]["hash"], run["hash"])
        self.assertEqual(contents["run"]["accuracy"]["values"], run["accuracy"])
        self.assertEqual([(one["id"], one["verdict"], one["value"]) for one in contents["run"]["requirements"]],
                         [("near", "met", run["verdict"][0]["value"]), ("soon", "not met", 0.4)])
        self.assertEqual([contents["run"]["requirements"][0][key] for key in ("parent", "rationale")], ["SYS-4", "as in the drawing"])
        values = {value["path"]: value for value in contents["data"]["values"]}
        self.assertEqual(values["bodies.moving.mass"]["basis"], "measured")
        self.assertEqual(values["bodies.moving.mass"]["uncertainty"], {"text": "0.5 %", "sizes": [0.01]})
        self.assertEqual(values["elements.spring.stiffness"]["uncertainty"]["sizes"], [0.01])
        self.assertEqual(values["bodies.moving.position"]["basis"], "follows")
        self.assertEqual(values["bodies.still.inertia"], {"path": "bodies.still.inertia", "text": "[1, 1, 1]", "unit": "kg m2", "numbers": [1, 1, 1], "role": "model",
                                                          "basis": "none", "place": "pass.yaml:7"})
        without = [path for path, value in values.items() if value["basis"] == "none"]
        self.assertEqual(sum(counts["none"] for counts in contents["data"]["counts"].values()), len(without))
        self.assertEqual(without, ["bodies.still.inertia", "bodies.still.shape[0].sphere.radius", "bodies.moving.inertia", "bodies.moving.velocity",
                                   "bodies.moving.shape[0].sphere.radius", "elements.spring.free_length", "events.late.when.time"])

    def test_the_hash_beside_each_command_is_what_the_command_prints(self):
        contents, _ = self.build(self.scenario, "--without-accuracy")
        hashes = {one["command"].split()[1]: one["hash"] for one in contents["commands"]}
        self.assertIn(f"model hash {hashes['check']}", self.run_ok(UNLATCH, "check", self.scenario).stdout)
        self.assertEqual(self.run_json(UNLATCH, "check", self.scenario)["model_hash"], hashes["check"])
        run = self.run_json(UNLATCH, "run", self.scenario, code=1)
        self.assertEqual((run["model_hash"], run["hash"]), (hashes["check"], hashes["run"]))
        self.assertIn(f"state hash {hashes['run']}", self.run_ok(UNLATCH, "run", self.scenario, code=1).stdout)

    def test_the_exit_code_says_whether_requirements_are_met(self):
        self.build(self.scenario, "--without-accuracy", code=1)
        met = self.write("met.yaml", SCENARIO[:SCENARIO.index("requirements:")])
        self.build(met, "--without-accuracy", code=0)

    def test_the_texts_of_included_files_are_in_the_contents(self):
        self.write("part.yaml", "unlatch_part: 1\nconstants: {a_number_of_the_part: 0.125}\n")
        contents, _ = self.build(self.write("whole.yaml", SCENARIO.replace("name: pass", "include: part.yaml\nname: pass")), "--without-accuracy")
        self.assertIn("a_number_of_the_part: 0.125", contents["scenario_text"])

    def test_this_versions_verification_and_its_limits_are_in_it(self):
        contents, _ = self.build(self.scenario, "--without-accuracy")
        text, tests = (SOURCE / "VALIDATION.md").read_text(), (SOURCE / "tests/README.md").read_text()
        own = contents["verification"]
        verified = text[text.index("## Verified"):text.index("## Beside")]
        self.assertEqual(len(own["verified"]), len(re.findall(r"^\| ", verified, re.M)) - 1)
        for key, heading in (("not_validated", "## Not validated"), ("known_to_be_wrong", "## Known to be wrong")):
            part = text[text.index(heading):].split("\n## ")[0]
            self.assertEqual(len(own[key]), len(re.findall(r"^- ", part, re.M)), key)
        promises = tests[tests.index("## Promises"):].split("\n## ")[0]
        self.assertEqual(len(own["promises"]), len(re.findall(r"^\| (?!promise \|)", promises, re.M)))
        self.assertNotIn("](", json.dumps(own))
        self.assertRegex(own["commit"], "^([0-9a-f]{12}(-modified)?|unknown)$")
        self.assertIn("left out", contents["run"]["accuracy"]["skipped"])

    def test_two_dossiers_of_the_same_files_agree_to_the_byte(self):
        campaign, results = self.fly_campaign()
        statements = self.write("statements.yaml", STATEMENTS)
        options = ("--results", "results", "--statements", "statements.yaml", "--out", "page.html", "--json", "page.json")
        pages = []
        for name in ("here", "elsewhere/below"):
            folder = self.folder / name
            folder.mkdir(parents=True)
            for path in (self.scenario, campaign, statements):
                shutil.copy(path, folder)
            shutil.copytree(results, folder / "results")
            result = subprocess.run([UNLATCH, "dossier", "campaign.yaml", *options], cwd=folder, check=False, capture_output=True, env={**os.environ, "TZ": name, "LC_ALL": "C"})
            self.assertEqual(result.returncode, 1, result.stderr)  # as `run`: the scenario misses a requirement
            pages.append([(folder / "page.html").read_bytes(), (folder / "page.json").read_bytes()])
        self.run_ok(UNLATCH, "dossier", campaign, "--results", results, "--statements", statements, "--out", self.folder / "p.html", "--json", self.folder / "p.json", code=1)
        pages.append([(self.folder / "p.html").read_bytes(), (self.folder / "p.json").read_bytes()])
        self.assertEqual(pages[0], pages[1])
        self.assertEqual(pages[0], pages[2], "of paths from elsewhere")
        self.assertNotIn(str(self.folder).encode(), pages[0][0])
        self.assertIn(hashlib.sha256(pages[0][1]).hexdigest().encode(), pages[0][0])

    def test_the_commands_give_the_hashes_that_stand_beside_them(self):
        campaign, results = self.fly_campaign()
        contents, _ = self.build(campaign, "--results", results)

        def give(command):
            words = command.split()
            self.assertEqual(words[0], "unlatch")
            words = [UNLATCH] + [str(results) if word == "RESULTS" else word for word in words[1:]]
            return json.loads(subprocess.run([*words, "--json", "-"], cwd=self.folder, capture_output=True, text=True).stdout)

        commands = {one["what"]: one for one in contents["commands"]}
        nominal = commands["the nominal run: requirements, notices, energy"]
        self.assertEqual(give(nominal["command"])["hash"], nominal["hash"])
        for requirement in contents["campaign"]["requirements"]:
            worst = requirement["worst"]
            sample = give(worst["command"])
            self.assertEqual(sample["hash"], worst["hash"])
            verdict = next(one for one in sample["verdict"] if one["id"] == requirement["id"])
            self.assertAlmostEqual(verdict["margin"], worst["margin"], delta=0)
        shutil.move(results, self.folder / "before")
        again = commands["the campaign: probabilities, sensitivities"]
        self.assertEqual(give(again["command"])["hash"], again["hash"])

    def test_results_of_another_text_are_refused(self):
        campaign, results = self.fly_campaign()
        self.scenario.write_text(SCENARIO.replace("mass: 1,", "mass: 1.5,"))
        for arguments, reason in (([campaign, "--results", results], "another campaign or scenario text"), ([campaign], "its folder is needed"),
                                  ([self.scenario, "--results", results], "belongs to a campaign"), ([campaign, "--results", self.folder], "manifest.json")):
            result = call(UNLATCH, "dossier", *arguments, "--out", self.folder / "x.html")
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(reason, result.stderr)
        self.assertFalse((self.folder / "x.html").exists())

    def test_statements_are_checked_with_their_places(self):
        wrong = self.write("wrong.yaml", "valdation: much\npeople: {level: 7, text: x}\n")
        result = call(UNLATCH, "dossier", self.scenario, "--statements", wrong, "--out", self.folder / "x.html")
        self.assertEqual(result.returncode, 2)
        self.assertIn("wrong.yaml:1:1: unknown key 'valdation'", result.stderr)
        self.assertIn("did you mean 'validation'", result.stderr)
        self.assertIn("wrong.yaml:2:17: '7' is no level", result.stderr)

    def test_a_signal_ends_it_within_a_second_and_writes_nothing(self):
        long = self.write("long.yaml", SCENARIO.replace("until: 1}", "until: 1e6}"))
        for number in (signal.SIGINT, signal.SIGTERM):
            process = self.begin(UNLATCH, "dossier", long, "--out", self.folder / "long.html", stderr=subprocess.PIPE)
            time.sleep(0.5)
            process.send_signal(number)
            self.assertEqual(process.wait(timeout=60), 1)
            self.assertIn("interrupted; nothing was written", process.stderr.read())
            process.stderr.close()
        self.assertFalse((self.folder / "long.html").exists())

    def test_the_page_shows_it_without_a_network_and_texts_stay_texts(self):
        contents, page = self.build(self.scenario, "--statements", self.write("statements.yaml", STATEMENTS))
        self.open(page)
        requirements = self.read_table("requirements")
        self.assertEqual(requirements[0][:2] + requirements[0][6:7], ["near", "SYS-4", "met"])
        self.assertIn(HOSTILE, requirements[0][2])
        self.assertEqual(requirements[1][6], "not met")
        self.assertEqual(self.ask("window.struck"), None)
        self.assertEqual([row[0] for row in self.read_table("values")], [v["path"] + (" (input)" if v["role"] == "input" else "") for v in contents["data"]["values"] if v["basis"] == "none"])
        self.ask("(() => { const s = document.getElementById('basis'); s.value = 'measured'; s.dispatchEvent(new Event('change')); })()")
        self.assertEqual(self.read_table("values")[1][2:5], ["measured", "0.5 % (0.01 kg)", "weighing report 12"])
        factors = {row[0]: row for row in self.read_table("factors")}
        self.assertEqual(factors["Validation"][3:], ["One film of a test", "1"])
        self.assertEqual(factors["M&S history"][3:], ["not stated", "–"])
        self.assertIn("7 of", self.ask("document.getElementById('chips').textContent"))
        self.assertEqual(len(self.read_table("accuracy")), len(contents["run"]["accuracy"]["values"]))
        self.assertEqual(self.ask("document.getElementById('hash').textContent"), hashlib.sha256((self.folder / "dossier.json").read_bytes()).hexdigest())

    def test_a_campaigns_page_has_its_sensitivities_and_worst_samples(self):
        campaign, results = self.fly_campaign()
        contents, page = self.build(campaign, "--results", results)
        self.open(page)
        near, soon = contents["campaign"]["requirements"]
        self.assertEqual(soon["strongest"][0]["input"], "late")
        self.assertEqual(near["strongest"][0]["input"], "push")
        self.assertEqual(self.read_table("sensitivities")[0][0], "push")
        self.assertEqual(len(self.browser.find_layers("strongest", "sensitivity")[0]["x"]), 2)
        self.assertGreater(self.browser.count_pixels("strongest"), 100)
        self.assertIn(f"sample {near['worst']['sample']}", self.read_table("requirements")[0][8])
        self.assertEqual([row[6] for row in self.read_table("inputs")], ["datasheet", "none"])

    def test_nothing_of_the_page_is_wider_than_a_narrow_screen_in_light_and_dark(self):
        campaign, results = self.fly_campaign()
        _, page = self.build(campaign, "--results", results)
        for width in (1400, 420):
            for scheme in ("light", "dark"):
                self.browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                self.browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
                self.open(page)
                self.assertLessEqual(self.ask("document.documentElement.scrollWidth"), width, scheme)
                back = self.ask("getComputedStyle(document.body).backgroundColor")
                self.assertEqual(back, "rgb(255, 255, 255)" if scheme == "light" else "rgb(23, 27, 33)")
                if os.environ.get("UNLATCH_PICTURES"):
                    height = self.ask("document.documentElement.scrollHeight")
                    self.browser.call("Emulation.setDeviceMetricsOverride", width=width, height=min(height, 6000), deviceScaleFactor=1, mobile=False)
                    self.browser.screenshot(Path(os.environ["UNLATCH_PICTURES"]) / f"dossier-{width}-{scheme}.png")
        self.browser.call("Emulation.setEmulatedMedia", features=[])
        self.browser.call("Emulation.setDeviceMetricsOverride", width=1400, height=900, deviceScaleFactor=1, mobile=False)


if __name__ == "__main__":
    if CHROMIUM is None:
        print("skipped: no chromium; tools/setup test installs it")
        sys.exit(77)
    main()
