#!/usr/bin/env python3
"""Facts about `unlatch optimize`: optima in closed form, their limits' shadows, budgets, interruptions, files and messages.

    optimize_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import json
import resource
import signal
import subprocess
import time

import yaml
from optimize_cases import CATALOGUE, FRONT, PROBLEM, SCENARIO, VALUE, OptimizeCase
from processes import UNLATCH, main

SHADOW = 1e-2  # relative: the limit is moved by 1 %


class OptimizeTest(OptimizeCase):
    def optimize_any(self, text, out):
        """Runs to any result."""
        process = self.start(text, out)
        process.communicate(timeout=250)
        return self.folder / out

    def test_finds_the_optimum_in_closed_form_and_its_shadow(self):
        result = self.optimize(PROBLEM, "o")
        self.assertEqual(result["status"], "optimal")
        self.assertAlmostEqual(result["objectives"][0]["value"] / 6.4, 1, delta=VALUE)
        self.assertAlmostEqual(result["variables"]["a"]["value"] / (4 * result["variables"]["b"]["value"]), 1, delta=1e-2)
        self.assertAlmostEqual(result["constraints"][0]["shadow"] / 12.8, 1, delta=SHADOW)
        self.assertTrue(result["verification"]["met"] and result["verification"]["same_bits"])

    def test_patch_runs_as_it_is(self):
        self.optimize(PROBLEM, "o")
        (self.folder / "s.yaml").unlink()
        subprocess.run([UNLATCH, "run", self.folder / "o/patch.yaml"], check=True, capture_output=True)

    def test_torques_stiffnesses_and_energies_have_their_own_units(self):
        scenario = SCENARIO.replace("profile: 1 N", "profile: 1 N + 0 * (twist + spring * (1 rad) + damper * (1 rad/s) + inertia / (1 s)^2) / arm", 1)
        (self.folder / "s.yaml").write_text(scenario + "constants: {twist: 1 N m, spring: 1 N m/rad, damper: 1 N m s/rad, inertia: 1 kg m2, arm: 1 m}\n")
        bounds = {"twist": "N m", "spring": "N m/rad", "damper": "N m s/rad", "inertia": "kg m2", "arm": "m"}
        variables = "".join(f"  {name}: {{path: constants.{name}, between: [1 {unit}, 2 {unit}]}}\n" for name, unit in bounds.items())
        head = PROBLEM.partition("variables:")[0].replace("scenario: s.yaml", "scenario: s.yaml\nset: {requirements.far.at_least: 0 m}")
        result = self.optimize(head + "variables:\n" + variables + "objectives: [{minimise: 2*twist}]\nbudget: {runs: 10}\n", "o", code=None)
        self.assertEqual({name: variable["unit"] for name, variable in result["variables"].items()}, bounds)
        self.assertEqual(result["objectives"][0]["unit"], "N m")
        force = PROBLEM.replace("a^2 + 4*b^2", "a * (1 m)") + "budget: {runs: 10}\n"
        self.assertEqual(self.optimize(force, "p", code=None)["objectives"][0]["unit"], "J")

    def test_global_search_finds_the_same_optimum(self):
        result = self.optimize(PROBLEM + "method: global\n", "o")
        self.assertEqual(result["method"], "global")
        self.assertAlmostEqual(result["objectives"][0]["value"] / 6.4, 1, delta=VALUE)

    def test_catalogues_are_tried_in_all_combinations(self):
        result = self.optimize(CATALOGUE, "o")
        best = min(a * a + 4 * b * b for a in range(4) for b in range(4) if a + b >= 8 ** 0.5)
        self.assertTrue(result["exhaustive"])
        self.assertEqual(result["objectives"][0]["value"], best)

    def test_pareto_front_lies_on_the_line_of_the_constraint(self):
        front = self.optimize(FRONT, "o")["front"]
        self.assertGreater(len(front), 20)
        for point in front:
            self.assertGreaterEqual(sum(point["objectives"]), 8 ** 0.5)
        excess = sorted(sum(point["objectives"]) - 8 ** 0.5 for point in front)
        self.assertLess(excess[len(excess) // 2], 0.1)  # relative to 2.8 N, at the median of 2000 runs
        gaps = [b["objectives"][0] - a["objectives"][0] for a, b in zip(front, front[1:])]
        self.assertLess(max(gaps), 0.15)  # N, of a front 2.8 N long: a quarter of the runs fills gaps

    def test_several_starts_find_the_best_of_several_optima(self):
        # Two wells, the deeper one near 1 N; the start is in the other one. The constraint is met everywhere.
        wells = "((a/(1 N) - 1) * (a/(1 N) - 4))^2 + 0.5*a/(1 N)"
        text = (PROBLEM.replace("a: {path: elements.px.profile, between: [0 N, 5 N]}", "a: {path: elements.px.profile, between: [0 N, 5 N], start: 4.2 N}")
                .replace("[0 N, 5 N]}", "[3 N, 5 N]}").replace("a^2 + 4*b^2", wells))
        f = lambda a: ((a - 1) * (a - 4)) ** 2 + 0.5 * a
        deep, shallow = (min(f(low + i * 1e-4) for i in range(20000)) for low in (0, 3))
        one = self.optimize(text, "one")
        self.assertAlmostEqual(one["objectives"][0]["value"], shallow, delta=1e-5)
        several = self.optimize(text + "starts: 3\n", "several")
        self.assertAlmostEqual(several["objectives"][0]["value"], deep, delta=1e-5)
        ends = [search["objective"] for search in several["searches"]]
        self.assertEqual(len(ends), 3)
        self.assertAlmostEqual(ends[0], shallow, delta=1e-5)  # the first is the problem's own
        self.assertEqual(several["status"], "optimal")

    def test_starts_without_a_local_search_are_refused(self):
        for text in PROBLEM + "method: global\n", CATALOGUE, FRONT:
            (self.folder / "p.yaml").write_text(text + "starts: 4\n")
            done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, text)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn("several starts, and no local search", done.stderr)

    def test_same_result_with_one_job_and_with_eight(self):
        for name, text in ("local", PROBLEM), ("starts", PROBLEM + "starts: 4\nbudget: {runs: 300}\n"), ("global", PROBLEM + "method: global\n"), ("pareto", FRONT):
            self.optimize(text, name + "1", "--jobs", "1")
            self.optimize(text, name + "8", "--jobs", "8")
            for file in "result.json", "history.csv", "patch.yaml", "report.html":
                self.assertEqual((self.folder / (name + "1") / file).read_bytes(),
                                 (self.folder / (name + "8") / file).read_bytes(), name + file)

    def test_resume_gives_the_same_from_any_part_of_the_history(self):
        text = PROBLEM + "method: global\n"
        self.optimize(text, "whole")
        whole = (self.folder / "whole/history.csv").read_bytes()
        for part in 0, 30, len(whole) // 2, len(whole) - 7:  # 30: within the heading
            out = self.folder / f"part{part}"
            out.mkdir()
            if part > 0:
                (out / "history.csv").write_bytes(whole[:part])
                (out / "manifest.json").write_bytes((self.folder / "whole/manifest.json").read_bytes())
            self.optimize(text, out.name, "--resume")
            for file in "result.json", "history.csv", "patch.yaml":
                self.assertEqual((out / file).read_bytes(), (self.folder / "whole" / file).read_bytes())

    def test_resume_after_a_kill_gives_the_same(self):
        text = PROBLEM + "method: global\n"
        self.optimize(text, "whole")
        process = self.start(text, "killed")
        process.stderr.readline()  # the first tenth is done, or more
        process.send_signal(signal.SIGKILL)
        process.communicate()
        self.optimize(text, "killed", "--resume")
        self.assertEqual((self.folder / "killed/history.csv").read_bytes(), (self.folder / "whole/history.csv").read_bytes())

    def test_resume_refuses_a_folder_of_another_problem_and_says_what_differs(self):
        self.optimize(PROBLEM, "o")
        for text, part in ((PROBLEM.replace("5 N", "4 N"), "problem"), (PROBLEM + "seed: 2\n", "problem")):
            process = self.start(text, "o", "--resume")
            errors = process.communicate(timeout=60)[1]
            self.assertEqual(process.returncode, 2)
            self.assertIn(f"its {part} differs", errors)
        (self.folder / "s.yaml").write_text(SCENARIO.replace("mass: 1 kg", "mass: 2 kg"))  # the columns are the same
        process = self.start(PROBLEM, "o", "--resume")
        self.assertIn("its scenario differs", process.communicate(timeout=60)[1])
        self.assertEqual(process.returncode, 2)

    def test_ctrl_c_leaves_the_best_so_far(self):
        process = self.start(PROBLEM + "method: global\nbudget: {runs: 1000000}\n", "o")
        while not (self.folder / "o/history.csv").exists() or (self.folder / "o/history.csv").stat().st_size < 4000:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        result = json.loads((self.folder / "o/result.json").read_text())
        self.assertEqual(result["status"], "interrupted")
        with open(self.folder / "o/history.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        objective = next(name for name in rows[0] if name.startswith("a^2"))
        met = [float(row[objective]) for row in rows if float(row["far.margin [m]"]) >= 0]
        self.assertEqual(result["objectives"][0]["value"], min(met))
        subprocess.run([UNLATCH, "run", self.folder / "o/patch.yaml"], check=True, capture_output=True)

    def test_search_for_a_feasible_point_leaves_budget_for_the_optimum(self):
        start = PROBLEM.replace("[0 N, 5 N]}", "[0 N, 5 N], start: 0 N}")  # no constraint is met there
        result = self.optimize(start + "method: local\nbudget: {runs: 200}\n", "o")
        self.assertAlmostEqual(result["objectives"][0]["value"] / 6.4, 1, delta=VALUE)

    def test_budget_is_kept(self):
        for starts in 1, 3:
            for budget in 1, 7, 60:
                text = PROBLEM + f"starts: {starts}\nbudget: {{runs: {budget}}}\n"
                result = json.loads((self.optimize_any(text, f"o{starts}-{budget}") / "result.json").read_text())
                self.assertEqual(result["runs"], budget)

    def test_slices_lead_through_the_optimum(self):
        result = self.optimize(PROBLEM, "o")
        for name, other in ("a", "b"), ("b", "a"):
            values = [point["value"] for point in result["slices"][name]]
            self.assertEqual((values[0], values[-1]), (0, 5))
            self.assertIn(result["variables"][name]["value"], values)
            for point in result["slices"][name]:  # the other variable keeps its value
                push = point["value"] + result["variables"][other]["value"]
                self.assertAlmostEqual(point["margins"][0], push / 8 ** 0.5 - 1, delta=1e-9)

    # The cost of a thing that the scenario does not know: no run gets it.
    def test_a_variable_that_an_objective_alone_reads_is_searched_and_one_that_nothing_reads_is_refused(self):
        (self.folder / "s.yaml").write_text(SCENARIO + "constants: {price: 3}\n")
        text = PROBLEM.replace("variables:\n", "variables:\n  p: {path: constants.price, between: [1, 5]}\n")
        result = self.optimize(text.replace("a^2 + 4*b^2", "a^2 + 4*b^2 + (p - 2)^2 * 1 N^2"), "o")
        self.assertAlmostEqual(result["variables"]["p"]["value"], 2, delta=1e-2)
        self.assertAlmostEqual(result["objectives"][0]["value"] / 6.4, 1, delta=1e-3)
        self.run_ok(UNLATCH, "run", self.folder / "o/patch.yaml")
        (self.folder / "p.yaml").write_text(text)
        refused = self.run_ok(UNLATCH, "check", self.folder / "p.yaml", code=2)
        self.assertIn("nothing reads the constant 'price'", refused.stderr)

    # A column's name has the variable as a word: the objective is the column, and nothing reads the variable.
    def test_a_variable_whose_name_is_a_word_in_the_name_of_a_column_is_not_read(self):
        (self.folder / "s.yaml").write_text(SCENARIO.replace("{id: far,", "{id: far-p,") + "constants: {p: 3}\n")
        (self.folder / "p.yaml").write_text(PROBLEM.replace("variables:\n", "variables:\n  p: {path: constants.p, between: [1, 5]}\n")
                                            .replace("a^2 + 4*b^2", "far-p"))
        refused = self.run_ok(UNLATCH, "check", self.folder / "p.yaml", code=2)
        self.assertIn("nothing reads the constant 'p'", refused.stderr)

    # Rows of a catalogue: push a and push b of one real actuator belong together.
    def test_rows_of_a_catalogue_give_their_values_together(self):
        rows = PROBLEM.partition("variables:")[0] + """variables:
  actuator:
    paths: [elements.px.profile, [elements.py.profile]]
    rows: [[0 N, 5 N], [1 N, 2 N], [2 N, 1 N], [3 N, 0 N]]
    columns: [a, b]
    start: [0 N, 5 N]
objectives: [{minimise: a^2 + 4*b^2}]
"""
        result = self.optimize(rows, "o")  # (a + b) / sqrt(8) >= 1: a + b = 3 is enough; 9 is the least of 17, 8, 9, but 8 is of [2, 1]
        self.assertEqual((result["exhaustive"], result["objectives"][0]["value"]), (True, 8))
        self.assertEqual(result["variables"]["actuator"]["value"], "[2 N, 1 N]")
        patch = yaml.safe_load((self.folder / "o/patch.yaml").read_text().partition("---")[0])["set"]
        self.assertEqual((patch["elements.px.profile"], patch["elements.py.profile"]), ("2 N", "1 N"))
        for wrong, words in (("rows: [[0 N, 5 N], [1 N]", "not a row of 2 values"), ("rows: [1 N, 2 N]\n    #", "not a row of 2 values")):
            (self.folder / "p.yaml").write_text(rows.replace("rows: [[0 N, 5 N], [1 N, 2 N]", wrong))
            self.assertIn(words, self.run_ok(UNLATCH, "check", self.folder / "p.yaml", code=2).stderr)

    def test_ctrl_c_during_the_verification_says_that_it_is_not_finished_and_resume_finishes_it(self):
        (self.folder / "s.yaml").write_text(SCENARIO.replace("dt: 100 ms, until: 1 s", "dt: 1 ms, until: 300 s"))
        text = CATALOGUE.replace("[0 N, 1 N, 2 N, 3 N]", "[1 N, 2 N]") + "budget: {runs: 4}\n"
        self.assertNotIn("hash", self.interrupt_verification(text)["verification"])
        ask = self.look_at("o")
        self.assertIn("not flown once more to the end", ask("document.getElementById('verification').textContent"))
        result = self.optimize(text, "o", "--resume")
        self.assertEqual((result["status"], result["verification"]["finished"]), ("optimal", True))

    def test_infeasible_problem_is_reported_with_its_cause(self):
        result = self.optimize(PROBLEM.replace("5 N", "1 N"), "o", code=1)
        self.assertEqual(result["status"], "infeasible")
        self.assertEqual(result["violation"]["constraint"], "far")
        self.assertAlmostEqual(result["violation"]["size"], 1 - 2 / 8 ** 0.5, delta=VALUE)
        self.assertIn("at their bounds: a, b", result["violation"]["text"])

    def test_a_budget_that_ends_before_a_feasible_point_says_so_and_nothing_of_infeasibility(self):
        lost = PROBLEM.replace("[0 N, 5 N]}", "[0 N, 5 N], start: 0 N}")  # no constraint is met there
        front = lost.replace("[{minimise: a^2 + 4*b^2}]", "[{minimise: a}, {minimise: b}]")
        for number, (text, told) in enumerate(((lost + "budget: {runs: 2}\n", "of 2 runs: raise budget.runs"),
                                               (lost + "method: global\nbudget: {runs: 2}\n", "of 2 runs: raise budget.runs"),
                                               (front + "budget: {runs: 1}\n", "of 1 run: raise budget.runs"),
                                               (lost + "budget: {seconds: 1 us}\n", "of 1e-06 s: raise budget.seconds"))):
            process = self.start(text, f"o{number}")
            printed, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1, printed + errors)
            result = json.loads((self.folder / f"o{number}/result.json").read_text())
            self.assertEqual((result["status"], result["feasible"]), ("not-found", False))
            self.assertEqual(result["ended_by"], "seconds" if "seconds" in told else "runs")
            self.assertIn("ended by its budget of " + ("1e-06 s (budget.seconds)" if "seconds" in told else told[3:].split(":")[0]), printed)
            for words in printed, result["violation"]["why"]:
                self.assertIn("no feasible point found within the budget " + told, words)
            self.assertNotIn("infeasible", printed)
        ask = self.look_at("o0")
        self.assertIn("No feasible point was found within the budget", ask("document.getElementById('verdict').textContent"))

    def test_an_objective_without_a_value_is_reported_and_no_constraint_is_blamed(self):
        (self.folder / "s.yaml").write_text(SCENARIO + "events: [{name: never, when: {time: 5 s}}]\n")
        result = self.optimize(PROBLEM.replace("a^2 + 4*b^2", "event.never"), "o", code=1)
        self.assertEqual(result["status"], "infeasible")
        self.assertEqual(result["violation"]["objective"], "event.never")
        self.assertNotIn("constraint", result["violation"])
        self.assertIn("has a value of event.never", result["violation"]["text"])
        self.assertTrue(result["constraints"][0]["met"])

    def test_an_objective_that_has_no_value_in_a_part_of_the_bounds_is_best_outside_it(self):
        text = PROBLEM.replace("a^2 + 4*b^2", "sqrt(a / (1 N) - 2)") + "budget: {runs: 200}\n"
        result = self.optimize(text, "o", code=None)
        self.assertTrue(result["feasible"])
        self.assertLess(result["objectives"][0]["value"], 0.1)
        self.assertGreaterEqual(result["variables"]["a"]["value"], 2)

    def test_a_constant_objective_gives_a_point_that_meets_the_constraints(self):
        result = self.optimize(PROBLEM.replace("a^2 + 4*b^2", "3"), "o")
        self.assertEqual((result["status"], result["objectives"][0]["value"]), ("optimal", 3))
        self.look_at("o")

    def test_a_budget_that_ends_before_the_search_begins_gives_no_optimum(self):
        for number, budget in enumerate(("runs: 1", "seconds: 1 us")):  # the start is run in any case
            result = self.optimize(PROBLEM + f"budget: {{{budget}}}\n", f"o{number}")
            self.assertEqual((result["status"], result["runs"]), ("budget", 1))
            self.look_at(f"o{number}")

    def test_seconds_bound_the_runs_around_the_result_too(self):
        (self.folder / "s.yaml").write_text(SCENARIO.replace("dt: 100 ms, until: 1 s", "dt: 1 ms, until: 100 s").replace("1 m}", "10 km}"))
        result = self.optimize(PROBLEM + "budget: {runs: 1000000, seconds: 1 ms}\n", "o", code=None)
        self.assertLess(result["study_runs"], 10)  # without a bound: the number of slices and differences

    def test_a_full_disk_ends_the_search_and_resume_goes_on(self):
        def allow_small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a write beyond the limit fails, as on a full disk
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

        for number, text in enumerate((PROBLEM, PROBLEM + "method: global\n")):
            self.optimize(text, f"whole{number}")
            done = subprocess.run([UNLATCH, "optimize", self.folder / "p.yaml", "--out", self.folder / f"full{number}"],
                                  capture_output=True, text=True, preexec_fn=allow_small_files)
            self.assertEqual(done.returncode, 3)
            self.assertIn("--resume", done.stderr)
            self.assertFalse((self.folder / f"full{number}/result.json").exists())
            self.optimize(text, f"full{number}", "--resume")
            for file in "history.csv", "result.json":
                self.assertEqual((self.folder / f"full{number}" / file).read_bytes(), (self.folder / f"whole{number}" / file).read_bytes())

    def test_a_file_of_another_kind_is_reported(self):
        (self.folder / "p.yaml").write_text(PROBLEM)
        for verb, file, told in (("optimize", "s.yaml", "this is a scenario"), ("run", "p.yaml", "`unlatch optimize`")):
            options = ["--out", self.folder / "o"] if verb == "optimize" else []
            done = subprocess.run([UNLATCH, verb, self.folder / file, *options], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(len(done.stderr.splitlines()), 1)
            self.assertIn(told, done.stderr)

    def test_a_mistake_is_reported_once_at_its_own_place(self):
        cases = {"between: [5 N, 0 N]": "not below the upper one", "between: [5 N, 5 N]": "not below the upper one",
                 "values: [1 N]": "a catalogue of length 1", "values: []": "a catalogue of length 0", "between: [.nan, 5 N]": "not finite"}
        for text, told in cases.items():
            (self.folder / "p.yaml").write_text(PROBLEM.replace("between: [0 N, 5 N]", text, 1))
            done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, text)
            self.assertIn(told, done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)  # not of the objective that names the variable
        (self.folder / "p.yaml").write_text(PROBLEM.replace("elements.px.profile", "elements.px.profil"))
        done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)  # not of the other variable
        self.assertIn("did you mean 'profile'", done.stderr)

    def test_all_mistakes_are_reported_at_once(self):
        wrong = PROBLEM.replace("a: {path: elements.px.profile", "a: {path: elements.nothing.profile").replace(
            "b: {path: elements.py.profile, between: [0 N, 5 N]", "b: {path: elements.py.profile, between: [0 m, 5 m]")
        (self.folder / "p.yaml").write_text(wrong + "constraints: [fra]\n")
        done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        for place in "p.yaml:5:", "p.yaml:6:", "p.yaml:8:", "did you mean 'far'":
            self.assertIn(place, done.stderr)

    def test_a_limit_that_is_a_variable_is_judged_and_reported_with_its_own_value(self):
        head = PROBLEM.partition("variables:")[0] + "variables: {asked: {path: requirements.far.at_least, between: [0.5 m, 2 m], start: 0.6 m}}\n"
        text = head + "objectives: [{maximise: asked}]\n"
        self.write_campaign(20)
        reached = 2 / 8 ** 0.5  # m, of the nominal block; the scenario asks for 1 m
        for number, constraint in enumerate(("far", "{requirement: far, probability: 0.9}")):
            process = self.start(text + f"campaign: {{file: c.yaml, samples: 20, checks: 0}}\nconstraints: [{constraint}]\n", f"o{number}")
            printed, errors = process.communicate(timeout=60)
            self.assertEqual(process.returncode, number, printed + errors)  # of the second the probability is not checked
            result = json.loads((self.folder / f"o{number}/result.json").read_text())
            found, told = result["variables"]["asked"]["value"], result["constraints"][0]
            self.assertAlmostEqual(found / reached, 1, delta=VALUE if number == 0 else 0.1)
            self.assertEqual(told["limit"], found)
            self.assertAlmostEqual(told["value"], found + told["margin"], delta=1e-12)
            self.assertIn(f"at least {found:.6g} m", printed)
            ask = self.look_at(f"o{number}")
            self.assertIn(f"{found:.3f}"[:4], ask("document.querySelector('#constraints tr:nth-child(2) td:nth-child(2)').textContent"))

    def test_a_variable_that_is_named_as_a_requirement_is_refused(self):
        (self.folder / "p.yaml").write_text(PROBLEM.replace("  b: {", "  far: {").replace("4*b^2", "4*far^2"))
        done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn("p.yaml:6:", done.stderr)
        self.assertIn("'far' is a result of the scenario", done.stderr)

    def test_flight_software_that_would_not_take_part_is_refused_unless_the_problem_says_so(self):
        plain = SCENARIO
        (self.folder / "s.yaml").write_text(plain + "flight_software: {required: [fsw]}\n")
        said = PROBLEM + "set: {flight_software.required: []}\n"
        for verb, options in ("check", []), ("optimize", ["--out", self.folder / "o"]):
            (self.folder / "p.yaml").write_text(PROBLEM)
            done = subprocess.run([UNLATCH, verb, self.folder / "p.yaml", *options], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertIn("requires flight software (fsw), which takes no part", done.stderr)
            self.assertIn("set: {flight_software.required: []}", done.stderr)
            (self.folder / "p.yaml").write_text(said)
            done = subprocess.run([UNLATCH, verb, self.folder / "p.yaml", *options], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        # That of the campaign's scenario alone.
        (self.folder / "t.yaml").write_text(plain + "flight_software: {required: [fsw]}\n")
        (self.folder / "s.yaml").write_text(plain)
        self.write_campaign(20)
        (self.folder / "c.yaml").write_text((self.folder / "c.yaml").read_text().replace("s.yaml", "t.yaml"))
        (self.folder / "p.yaml").write_text(PROBLEM + "campaign: c.yaml\n")
        done = subprocess.run([UNLATCH, "check", self.folder / "p.yaml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("requires flight software", done.stderr)


if __name__ == "__main__":
    main()
