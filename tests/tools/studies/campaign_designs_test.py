#!/usr/bin/env python3
"""Facts about what the samples of a design say, and what they do not: probabilities, quantiles and tolerance limits are of
draws from the distributions alone; each design has its own results; blows have columns of their own.

    campaign_designs_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import json
import math
import statistics
import subprocess

from browser import Browser
from processes import UNLATCH, ProcessTest, main

# A mass that flies at the speed v + w for five steps; base is at rest.
BALL = """unlatch: 1
name: ball
step: {dt: 0.01, until: 0.05}
constants: {v: 1 m/s, w: 1 m/s}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], velocity: [v + w, 0, 0]}
  base: {mass: 1000, inertia: [9, 9, 9]}
requirements:
  - {id: fast, text: it is slow, velocity: {body: ball, relative_to: base}, at_most: 4}
"""
UNIFORM = "parameters:\n  v: {path: constants.v, uniform: {min: 0 m/s, max: 3 m/s}}\n  w: {path: constants.w, uniform: {min: 0 m/s, max: 2 m/s}}\n"


class CampaignDesignsTest(ProcessTest):
    def write(self, rest, scenario=BALL):
        (self.folder / "ball.yaml").write_text(scenario)
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\n" + rest)
        return path

    def fly(self, rest, out, code=1, scenario=BALL):
        """Summary, what was printed, and the table."""
        done = self.run_ok(UNLATCH, "campaign", self.write(rest, scenario), "--out", self.folder / out, code=code)
        with open(self.folder / out / "samples.csv", newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        return json.loads((self.folder / out / "summary.json").read_text()), done.stdout, table

    def test_chosen_points_have_counts_and_no_probabilities_quantiles_or_limits(self):
        for sampling, rest in (("morris", "samples: 300\n"), ("grid", "levels: 18\n"), ("one-at-a-time", "levels: 160\n")):
            with self.subTest(sampling):
                summary, said, table = self.fly(f"sampling: {sampling}\n{rest}{UNIFORM}", sampling, code=None)
                self.assertGreater(len(table), 299)  # enough for a tolerance limit
                values = [float(row["fast [m/s]"]) for row in table]
                one, both = summary["requirements"][0], summary["any_requirement"]
                failed = sum(value > 4 for value in values)
                self.assertEqual((one["failed"], both["failed"]), (failed, failed))
                self.assertEqual((one["min"], one["max"]), (min(values), max(values)))
                for entry in (one, both):
                    self.assertEqual((entry["estimate"], entry["probability"]), (None, None))
                self.assertEqual((one["tolerance"], one["intervals"], one["convergence"]), (None, {}, []))
                for entry in (one, *summary["columns"], *summary["inputs"]):
                    self.assertEqual((set(entry["quantiles"].values()), entry["intervals"]), ({None}, {}), entry["name" if "name" in entry else "id"])
                self.assertEqual(summary["basis"]["draws"], None)
                note = f"samples of {sampling} are chosen, not drawn from the distributions"
                self.assertIn(note, said)
                for word in ("Clopper", "Wilks", "tolerance limits keep", "probability"):
                    self.assertNotIn(word, said.replace("no probabilities", "").partition("Influences")[0].split("Requirements")[1])
                with open(self.folder / sampling / "requirements.csv", newline="", encoding="utf-8") as file:
                    for row in csv.DictReader(file):
                        for key in ("probability", "bound low", "bound high", "quantile 0.5", "99 % are above", "99 % are below"):
                            self.assertEqual(row[key], "", key)
                review = (self.folder / sampling / "review.md").read_text()
                self.assertIn(note, review)
                self.assertNotIn("Clopper", review)
                self.assertIn(note, self.run_ok(UNLATCH, "check", self.folder / "c.yaml").stdout)

    def test_the_page_of_chosen_points_says_that_they_have_no_probability(self):
        self.fly(f"sampling: grid\nlevels: 5\n{UNIFORM}", "grid")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "grid", "--out", page, "--flights", "0")
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        ask = browser.evaluate
        heads = ask("[...document.querySelectorAll('#verdict th')].map((cell) => cell.textContent)")
        cells = dict(zip(heads, ask("[...document.querySelectorAll('#verdict td')].map((cell) => cell.textContent)"), strict=True))
        self.assertEqual([cells[key] for key in ("probability, 95 %", "median", "tolerance, 99 % / 95 %")], ["–"] * 3)
        self.assertEqual(float(cells["least"]), 0.5)
        self.assertIn("are chosen, not drawn", ask("document.getElementById('basis').textContent"))
        self.assertIn("without a probability", ask("document.getElementById('convergence').textContent"))
        self.assertIn("over the grid", ask("document.getElementById('tornado-caption').textContent"))
        self.assertEqual(browser.complaints, [])

    # Variances of v and w are 9/12 and 4/12 of their ranges' squares, of a grid and of draws alike.
    def test_a_grid_and_one_at_a_time_have_results_of_their_own(self):
        summary, said, _ = self.fly(f"sampling: grid\nlevels: 6\n{UNIFORM}", "grid")
        effects = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]["grid_effects"]
        self.assertAlmostEqual(effects[0], 9 / 13, delta=1e-12)
        self.assertAlmostEqual(effects[1], 4 / 13, delta=1e-12)
        self.assertIn("over the grid by an input alone", said)
        summary, said, _ = self.fly(f"sampling: one-at-a-time\nlevels: 6\n{UNIFORM}", "one", code=0)
        sensitivity = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]
        for swing, name, middle, width in zip(sensitivity["swings"], "vw", (2.5, 2.5), (3, 2), strict=True):
            self.assertEqual(swing["parameter"], name)
            self.assertAlmostEqual(swing["least"], middle - width * 5 / 12, delta=1e-12)
            self.assertAlmostEqual(swing["greatest"], middle + width * 5 / 12, delta=1e-12)
        self.assertEqual(sensitivity["spearman"], [None, None])  # most samples are at the medians

    def test_influences_of_a_part_of_a_design_are_not_estimated_and_are_said_to_be(self):
        for sampling, rest in (("one-at-a-time", "levels: 6"), ("grid", "levels: 4")):
            with self.subTest(sampling):
                path = self.write(f"sampling: {sampling}\n{rest}\n{UNIFORM}")
                done = self.run_ok(UNLATCH, "campaign", path, "--out", self.folder / sampling, "--samples", "2:9", code=None)
                self.assertIn("not estimated, since samples have no value: v, w", done.stdout)
                self.assertNotIn("of no input", done.stdout)

    def test_a_value_that_is_the_same_in_every_sample_is_said_to_be_so(self):
        still = BALL + "  - {id: still, rate: {body: ball, relative_to: base}, at_most: 1}\n"
        for sampling in ("random", "sobol"):
            with self.subTest(sampling):
                _, said, _ = self.fly(f"sampling: {sampling}\nsamples: 64\n{UNIFORM}", sampling, code=None, scenario=still)
                line = next(line for line in said.splitlines() if "none: all values are equal" in line)
                self.assertIn("still", line)
                self.assertNotIn("samples have no value", said)

    def test_the_review_of_a_subset_simulation_has_its_probability_and_says_whose_the_others_are(self):
        rest = ("sampling: subset\nsamples: 500\nseed: 3\nsubset: {of: fast}\n"
                "parameters:\n  v: {path: constants.v, normal: {mean: 0 m/s, sigma: 1 m/s}}\n  w: {path: constants.w, normal: {mean: 0 m/s, sigma: 0.3 m/s}}\n")
        summary, said, _ = self.fly(rest, "subset", code=None)
        review = (self.folder / "subset/review.md").read_text()
        self.assertIsNotNone(summary["rare"]["probability"])
        result = f"probability {summary['rare']['probability']:.3g}, 95 %: "
        self.assertIn(result, said)
        self.assertIn("## Subset simulation: fast.margin below 0 m/s\n\n" + result, review)
        self.assertIn("## Requirements, first level alone", review)
        self.assertIn("## Inputs, as drawn in the first level", review)

    def test_bounds_of_saltelli_are_those_of_its_independent_rows(self):
        from scipy.stats import beta
        summary, said, table = self.fly(f"sampling: saltelli\nsamples: 1600\n{UNIFORM}", "saltelli")
        base = [float(row["fast [m/s]"]) for row in table if int(row["sample"]) % 4 < 2]
        self.assertEqual(summary["basis"]["draws"], len(base))
        one, failed, n = summary["requirements"][0], sum(value > 4 for value in base), len(base)
        self.assertEqual(one["failed"], sum(float(row["fast [m/s]"]) > 4 for row in table))  # of all samples
        self.assertAlmostEqual(one["estimate"], failed / n, delta=1e-15)
        for entry in (one, summary["any_requirement"]):
            self.assertAlmostEqual(entry["probability"][0], beta.ppf(0.025, failed, n - failed + 1), delta=1e-9)
            self.assertAlmostEqual(entry["probability"][1], beta.ppf(0.975, failed + 1, n - failed), delta=1e-9)
        self.assertAlmostEqual(one["quantiles"]["0.5"], statistics.median(base), delta=1e-12)
        self.assertEqual(one["tolerance"]["upper"], sorted(base)[-4])  # rank 4 of 800: the fifth would need 913
        column = next(c for c in summary["columns"] if c["name"] == "fast")
        self.assertEqual(column["count"], n)
        self.assertIn("of the first two samples of each block alone", said)
        sobol = {entry["parameter"]: entry for entry in column["sensitivity"]["sobol"]}
        for name, exact in (("v", 9 / 13), ("w", 4 / 13)):
            for key in ("first_interval", "total_interval"):
                self.assertTrue(sobol[name][key][0] <= exact <= sobol[name][key][1], sobol[name])

    def test_few_blocks_of_saltelli_have_indices_without_intervals(self):
        summary, _, _ = self.fly(f"sampling: saltelli\nsamples: 80\n{UNIFORM}", "few")
        for entry in next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]["sobol"]:
            self.assertTrue(math.isfinite(entry["total"]))
            self.assertEqual((entry["first_interval"], entry["total_interval"]), (None, None))

    def test_samples_that_are_draws_but_not_independent_are_said_to_be(self):
        for sampling in ("latin-hypercube", "sobol", "random"):
            summary, said, _ = self.fly(f"sampling: {sampling}\nsamples: 64\n{UNIFORM}", sampling)
            dependent = sampling != "random"
            self.assertEqual(summary["basis"]["independent"], not dependent)
            for text in (said, (self.folder / sampling / "review.md").read_text()):
                self.assertEqual("are not independent" in text and "not guaranteed" in text, dependent, sampling)

    # Where nothing was estimated, no input was "distinct from chance".
    def test_influences_of_few_values_are_not_estimated_and_are_said_to_be(self):
        for samples in (39, 40):
            _, said, _ = self.fly(f"samples: {samples}\n{UNIFORM}", f"n{samples}", code=None)
            self.assertEqual("not estimated: fewer than 40 values" in said, samples < 40, said)
            self.assertNotIn("distinct from chance", said)

    # An input without influence had an interval below 0 with a Sobol' sequence.
    def test_intervals_of_indices_are_not_below_0(self):
        still = BALL.replace("[v + w, 0, 0]", "[v, 0, 0]").replace("mass: 1000", "mass: 1 kg + w * 1 kg / (1 m/s)")
        for seed in range(1, 7):
            summary, _, _ = self.fly(f"sampling: sobol\nsamples: 256\nseed: {seed}\n{UNIFORM}", f"s{seed}", code=0, scenario=still)
            v, w = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]["first_order"]
            self.assertTrue(w["interval"][0] == 0 < w["interval"][1], w)
            self.assertTrue(v["interval"][1] == 1 or v["interval"][1] > 0.999, v)

    # A requirement at an event that comes in part of the samples: the others have no value, and may not keep to a limit.
    # Two outcomes: too fast in four of a hundred samples, which is 0.04 for any seed and not the part of a next level.
    def test_rare_failures_of_a_discrete_outcome_have_the_probability_of_the_outcome(self):
        held = 0
        for seed in range(1, 11):
            rest = (f"sampling: subset\nsamples: 500\nseed: {seed}\nsubset: {{of: fast}}\n"
                    "parameters:\n  v: {path: constants.v, discrete: {values: [1 m/s, 5 m/s], weights: [0.96, 0.04]}}\n")
            rare = self.fly(rest, f"two{seed}", code=0)[0]["rare"]
            self.assertEqual((rare["decided"], rare["probability"]), (True, rare["failed_samples"] / 500))
            self.assertEqual((rare["reached"], len(rare["levels_run"])), (True, 1))
            held += rare["interval"][0] <= 0.04 <= rare["interval"][1]
        self.assertGreaterEqual(held, 8)

    # One sample in a thousand has a flag, with which nearly all fail: where no independent sample has it, chains that come to it
    # do not say how probable it is.
    def test_failures_with_a_value_that_no_independent_sample_has_are_undecided(self):
        wrong, undecided = 0, 0
        probability = 1e-3 * statistics.NormalDist().cdf(1)
        (self.folder / "flag.yaml").write_text(
            "unlatch: 1\nname: flag\nstep: {dt: 0.01, until: 0.01}\nconstants: {x: 0, y: 0}\nbodies:\n"
            "  ball: {mass: 2, inertia: [1, 1, 1], velocity: [x + 10*y, 0, 0]}\n"
            "requirements:\n  - {id: fast, text: it is slow, velocity: {body: ball, component: x}, take: final, at_most: 9}\n")
        for seed in range(1, 9):
            path = self.folder / f"flag{seed}.yaml"
            path.write_text(f"unlatch_campaign: 1\nname: flag\nscenario: flag.yaml\nsampling: subset\nsamples: 300\nseed: {seed}\n"
                            "subset: {of: fast}\nparameters:\n  x: {path: constants.x, normal: {mean: 0, sigma: 1}}\n"
                            "  y: {path: constants.y, discrete: {values: [0, 1], weights: [0.999, 0.001]}}\n")
            done = subprocess.run([UNLATCH, "campaign", path, "--out", self.folder / f"flag{seed}"], capture_output=True, text=True)
            rare = json.loads((self.folder / f"flag{seed}/summary.json").read_text())["rare"]
            self.assertGreaterEqual(rare["interval"][1], probability, (seed, rare["interval"]))
            undecided += not rare["decided"]
            if rare["unseen"]:
                self.assertIn("values of y that none of the independent samples has", done.stdout)
                self.assertEqual(done.returncode, 1)
                wrong += rare["decided"]
        self.assertEqual(wrong, 0)
        self.assertGreater(undecided, 2)  # of three campaigns two have no flag among 300 samples

    def test_rare_failures_that_equal_margins_hide_are_undecided(self):
        rest = ("sampling: subset\nsamples: 200\nsubset: {of: fast, at_most: 0.5}\n"
                "parameters:\n  v: {path: constants.v, discrete: {values: [1 m/s, 5 m/s], weights: [0.999999, 0.000001]}}\n")
        summary, said, table = self.fly(rest, "hidden")
        rare = summary["rare"]
        self.assertEqual((len(table), rare["decided"], rare["tied"], rare["met"], rare["probability"]), (200, False, True, False, None))
        self.assertAlmostEqual(rare["interval"][1], 1 - 0.025 ** (1 / 200), delta=1e-9)
        self.assertIn("undecided: probability at most 1.83e-02 (95 %)", said)
        self.assertIn("no estimate", self.run_ok(UNLATCH, "campaign", "--help").stdout.replace("\n", " "))

    def test_a_catalogue_has_no_rank_and_an_index_by_its_entries(self):
        # Speeds that go up and down along the catalogue explain all of the variance but that of w.
        rows = ", ".join(f"[{v} m/s, 1000 kg]" for v in (0.1, 2, 0.3, 1.9, 0.2))
        rest = (f"samples: 500\nparameters:\n  v: {{path: [constants.v, bodies.base.mass], shared: true, discrete: {{rows: [{rows}]}}}}\n"
                "  w: {path: constants.w, uniform: {min: 0 m/s, max: 1 m/s}}\n")
        sensitivity = next(c for c in self.fly(rest, "rows", code=None)[0]["columns"] if c["name"] == "fast")["sensitivity"]
        self.assertEqual(sensitivity["spearman"][0], None)
        variance = statistics.pvariance([0.1, 2, 0.3, 1.9, 0.2])
        self.assertAlmostEqual(sensitivity["first_order"][0]["index"], variance / (variance + 1 / 12), delta=0.03)
        low, high = sensitivity["first_order"][0]["interval"]
        self.assertTrue(low <= sensitivity["first_order"][0]["index"] <= high)

    def test_an_index_lies_within_its_interval(self):
        for sampling, samples in (("random", 60), ("sobol", 64), ("saltelli", 480)):
            for seed in 1, 2, 3:
                rest = (f"sampling: {sampling}\nsamples: {samples}\nseed: {seed}\n{UNIFORM}"
                        "  m: {path: bodies.ball.mass, uniform: {min: 1 kg, max: 2 kg}}\n").replace("480", "500")
                found = next(c for c in self.fly(rest, f"{sampling}{seed}", code=None)[0]["columns"] if c["name"] == "fast")["sensitivity"]
                pairs = [(one["index"], one["interval"]) for one in found.get("first_order", [])]
                for one in found.get("sobol", []):
                    pairs += [(one["first"], one["first_interval"]), (one["total"], one["total_interval"])]
                for index, interval in pairs:
                    self.assertTrue(interval[0] <= index <= interval[1], (sampling, index, interval))

    def test_components_of_a_direction_are_said_to_overlap(self):
        # What the ball's own direction makes of its speed along x is explained by each of the three components.
        tilted = BALL.replace("velocity: [v + w, 0, 0]", "velocity: [v, 0, 0]").replace("constants: {v: 1 m/s, w: 1 m/s}", "constants: {v: 1 m/s}")
        tilted = tilted.replace("bodies:", "elements: {push: {type: force, body: ball, direction: [1, 0, 0], profile: 100 N}}\nbodies:")
        tilted = tilted.replace("relative_to: base}", "relative_to: base, along: [1, 0, 0]}")
        summary, said, _ = self.fly("samples: 200\nparameters: {axis: {path: elements.push.direction, cone: {within: 60 deg}}}\n", "cone", code=None, scenario=tilted)
        self.assertTrue(summary["directions"])
        self.assertIn("the components of a direction depend on one another", said)

    def test_text_columns_of_a_table_are_for_readers_unless_a_parameter_reads_them(self):
        table = 'v,note,w\n1,"first, a good one",2\n2,second,1\n'
        for text, code in ((table, 0), (table.replace("v,note,w", "note,v,w"), 2)):
            (self.folder / "t.csv").write_text(text)
            path = self.write("sampling: csv\ntable: t.csv\nparameters: {v: {path: constants.v}, w: {path: constants.w}}\n")
            done = self.run_ok(UNLATCH, "check", path, code=code)
            self.assertIn("no parameter reads: 'note'" if code == 0 else "line 2: 'first, a good one' is not a number", done.stdout + done.stderr)

    def test_what_a_design_says_in_words(self):
        path = self.write(f"samples: 500\n{UNIFORM}")
        done = self.run_ok(UNLATCH, "campaign", path, "--out", self.folder / "far", "--samples", "490:600", code=2)
        self.assertIn("490:600 goes beyond the campaign, which has 500 samples", done.stderr)
        for sampling, samples, words in (("morris", 90, "by 30 blocks"), ("saltelli", 400, "by 100 blocks")):
            _, said, _ = self.fly(f"sampling: {sampling}\nsamples: {samples}\n{UNIFORM}", sampling, code=None)
            self.assertIn(words, said)
        self.assertIn("## Inputs, as chosen", (self.folder / "morris/review.md").read_text())
        self.assertIn("## Inputs, as drawn", (self.folder / "saltelli/review.md").read_text())
        # The mass changes no speed: its part of the variance is 0, not what rounding leaves.
        rest = f"sampling: grid\nlevels: 5\n{UNIFORM}  m: {{path: bodies.ball.mass, uniform: {{min: 1 kg, max: 2 kg}}}}\n"
        effects = next(c for c in self.fly(rest, "grid", code=None)[0]["columns"] if c["name"] == "fast")["sensitivity"]["grid_effects"]
        self.assertEqual(effects[2], 0)

    # Every second sample turns so fast that its first step fails, before its event.
    def test_faulted_samples_are_counted_apart_and_have_no_order_of_events(self):
        turning = BALL.replace("inertia: [1, 1, 1], velocity", "inertia: [1, 2, 3], rate: [0, 0, 0], velocity")
        turning += "events: [{name: come, when: {time: 0.01 s}}]\n"
        summary, said, table = self.fly("samples: 40\nparameters: {r: {path: 'bodies.ball.rate[0]', discrete: {values: [0, 1e200]}}}\n", "turning", scenario=turning)
        faulted = sum(row["status"] == "faulted" for row in table)
        self.assertTrue(5 < faulted < 35, faulted)
        one = summary["requirements"][0]
        self.assertEqual((one["faulted"], one["not_evaluated"], one["failed"]), (faulted, 0, faulted))
        self.assertEqual((summary["orders"]["count"], summary["orders"]["left_out"]), (1, faulted))
        self.assertRegex(said, rf"(?m)^  fast +{faulted} +{faulted} +0 ")

    def test_samples_without_a_value_leave_no_tolerance_limit_for_all_runs(self):
        late = BALL.replace("{v: 1 m/s,", "{d: 0.01 s, v: 1 m/s,") + "events: [{name: far, when: {time: d}}]\n"
        late = late.replace("relative_to: base}, at_most: 4", "relative_to: base}, at: far, at_most: 6")
        rest = f"samples: 400\n{UNIFORM}  d: {{path: constants.d, uniform: {{min: 0 s, max: 0.1 s}}}}\n"
        summary, said, table = self.fly(rest, "late", scenario=late)
        missing = sum(row["fast [m/s]"] == "" for row in table)
        self.assertTrue(100 < missing < 300, missing)  # the run ends at 0.05 s
        one = summary["requirements"][0]
        self.assertEqual((one["not_evaluated"], one["tolerance"]["without_value"]), (missing, missing))
        self.assertNotIn("upper", one["tolerance"])
        self.assertIn(f"none: {missing} samples without a value", said)

    # An arm that locks, by a blow through the base's weld; sixty requirements on it, more than any message could name.
    def test_each_value_without_a_blow_is_marked_in_a_column_and_on_the_page(self):
        many = 60
        arm = """unlatch: 1
name: arm
step: {dt: 1 ms, until: 0.15}
constants: {w: 1 rad/s}
bodies:
  base: {mass: 1, inertia: [1, 1, 1]}
  arm: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [0, w * 1 m / (1 rad), 0], rate: [0, 0, w]}
joints:
  root: {between: [ground, base], modes: {held: {kind: weld}}}
  hinge: {between: [base, arm], follower_point: [-1, 0, 0], modes: {open: {kind: revolute, axis: z}, locked: {kind: weld}}, mode: open}
events: [{name: lock, when: {angle: {joint: hinge, axis: z}, above: 0.1}, then: [{latch: {joint: hinge, mode: locked}}]}]
requirements:
""" + "".join(f"  - {{id: root-with-a-name-{k}, reaction: {{joint: root, row: force}}, at_most: {10 + k} N}}\n" for k in range(many))
        rest = "sampling: grid\nparameters: {w: {path: constants.w, discrete: {values: [0.1 rad/s, 0.9 rad/s, 1 rad/s]}}}\n"
        summary, said, table = self.fly(rest, "arm", code=0, scenario=arm)
        self.assertEqual([one.get("without_blow") for one in summary["requirements"]], [2] * many)
        self.assertEqual([[row[f"root-with-a-name-{k}.without_blow [s]"] == "" for row in table] for k in (0, many - 1)], [[True, False, False]] * 2)
        # It locks at 0.1 rad: by the end of 0.15 s at 0.9 and 1 rad/s.
        self.assertAlmostEqual(float(table[2]["root-with-a-name-0.without_blow [s]"]), 0.1, delta=1e-9)
        self.assertEqual([row["message"] for row in table], [""] * 3)
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "arm", "--out", page, "--flights", "0")
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        self.assertIn(f"The values of root-with-a-name-{many - 1} in 2 samples are without the impulse of a blow",
                      browser.evaluate("document.getElementById('basis').textContent"))


if __name__ == "__main__":
    main()
