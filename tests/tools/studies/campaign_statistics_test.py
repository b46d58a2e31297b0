#!/usr/bin/env python3
"""Facts about what campaigns draw and what they conclude from it: distributions, statistics, sensitivities and rare failures,
against closed forms, OpenTURNS and SciPy.

    campaign_statistics_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import json
import math
import shutil
import statistics
import sys

from browser import Browser
from campaign_cases import BALL, CampaignCase, read_table
from processes import UNLATCH, call, main


class CampaignStatisticsTest(CampaignCase):
    def test_an_even_dependence_is_a_sensitivity(self):
        (self.folder / "ball.yaml").write_text(BALL.replace("velocity: [0, 0, 0]", "velocity: [100*y*y, x, 0]", 1) + "constants: {x: 0, y: 0}\n")
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 400\nparameters:\n"
                        "  x: {path: constants.x, uniform: {min: -0.1, max: 0.1}}\n  y: {path: constants.y, uniform: {min: -0.1, max: 0.1}}\n")
        summary = self.run_campaign(path, "out", code=(0, 1))
        fast = next(column for column in summary["columns"] if column["name"] == "fast")["sensitivity"]
        self.assertLess(abs(fast["spearman"][1]), 0.2)
        self.assertGreater(fast["first_order"][1]["index"], 0.8)
        self.assertLess(fast["first_order"][0]["index"], 0.2)
        self.assertGreater(fast["first_order"][1]["interval"][0], fast["significant"])
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "0")
        browser = Browser()
        try:
            browser.open(page)
            longest, other = browser.find_layers("tornado", "effects")[0]["x"]
            self.assertGreater(longest, 5 * other)
            self.assertEqual(len(browser.find_layers("tornado", "significant")), 1)
            self.assertIn("First-order index", browser.evaluate("document.getElementById('tornado-caption').textContent"))
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

    def test_designs_with_a_missing_value_use_their_other_blocks(self):
        parameters = ("parameters:\n  m: {path: bodies.ball.mass, normal: {mean: 2, sigma: 5 %}}\n"
                      "  v: {path: 'bodies.ball.velocity[1]', uniform: {min: 0.1 m/s, max: 1 m/s}}\n")
        for sampling, samples, size in (("morris", 60, 3), ("saltelli", 80, 4)):
            path = self.write(f"sampling: {sampling}\nsamples: {samples}\n" + parameters, f"{sampling}.yaml")
            summary = self.run_campaign(path, sampling, "--samples", f"0:{samples - 1}")  # the last block lacks a sample
            fast = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]
            self.assertEqual(fast["blocks"], {"used": samples // size - 1, "left_out": 1})
            self.assertEqual(len(fast["morris" if sampling == "morris" else "sobol"]), 2)

    def test_failures_are_counted_with_their_bounds(self):
        import openturns
        path = self.write("samples: 400\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n")
        summary = self.run_campaign(path, "out", code=1)
        requirement = summary["requirements"][0]
        table = read_table(self.folder / "out")
        failed = [row for row in table if float(row["fast.margin [m/s]"]) < 0]
        self.assertEqual(requirement["failed"], len(failed))
        # The terminal's table: failures, missing values, Wilks' limit of the side that has one.
        said = self.run_ok(UNLATCH, "campaign", "merge", self.folder / "out", "--out", self.folder / "again", code=1).stdout
        line = next(line for line in said.splitlines() if line.startswith("  fast"))
        self.assertEqual(line.split()[1:3], [str(len(failed)), "0"])
        self.assertTrue(line.endswith(f" ≤ {requirement['tolerance']['upper']:.5g}") and " m/s " in line, line)
        self.assertGreater(len(failed), 0)
        low = openturns.Beta(len(failed), 401 - len(failed), 0, 1)
        high = openturns.Beta(len(failed) + 1, 400 - len(failed), 0, 1)
        self.assertAlmostEqual(requirement["probability"][0], low.computeQuantile(0.025)[0], delta=1e-9)
        self.assertAlmostEqual(requirement["probability"][1], high.computeQuantile(0.975)[0], delta=1e-9)
        worst = min(table, key=lambda row: float(row["fast.margin [m/s]"]))
        self.assertEqual(summary["worst"][0], int(worst["sample"]))

    def test_distributions_are_those_of_openturns(self):
        import openturns as ot
        n = 201
        kinds = {
            "normal: {mean: 5, sigma: 0.5}": ot.Normal(5, 0.5),
            "normal: {mean: 5, sigma: 10 %, within: 2}": ot.TruncatedDistribution(ot.Normal(5, 0.5), 4.0, 6.0),
            "normal: {mean: 5, sigma: 0.5, min: 4.9, max: 7}": ot.TruncatedDistribution(ot.Normal(5, 0.5), 4.9, 7.0),
            "lognormal: {mean: 5, sigma: 1}": ot.ParametrizedDistribution(ot.LogNormalMuSigma(5, 1, 0)),
            "uniform: {min: 2, max: 3}": ot.Uniform(2, 3),
            "triangular: {min: 1, mode: 2, max: 5}": ot.Triangular(1, 2, 5),
        }
        for text, distribution in kinds.items():
            path = self.write(f"sampling: grid\nlevels: {n}\nparameters:\n  m: {{path: bodies.ball.mass, {text}}}\n")
            out = self.folder / str(len(list(self.folder.iterdir())))
            self.run_campaign(path, out.name)
            for k, row in enumerate(read_table(out)):
                expected = distribution.computeQuantile((k + 0.5) / n)[0]
                self.assertAlmostEqual(float(row["m [kg]"]), expected, delta=1e-10 * abs(expected), msg=f"{text} {k}")

    def test_statistics_are_those_of_openturns(self):
        import openturns as ot
        path = self.write("samples: 500\nparameters:\n  m: {path: bodies.ball.mass, normal: {mean: 2, sigma: 5 %}}\n"
                          "  v: {path: 'bodies.ball.velocity[0]', uniform: {min: -1 m/s, max: 1 m/s}}\n")
        summary = self.run_campaign(path, "out", code=(0, 1))
        table = read_table(self.folder / "out")
        names = ["m [kg]", "v [m/s]", "fast [m/s]"]
        sample = ot.Sample([[float(row[name]) for name in names] for row in table])
        matrix = sample.computeSpearmanCorrelation()
        fast = next(c for c in summary["columns"] if c["name"] == "fast")
        for k in range(2):
            self.assertAlmostEqual(fast["sensitivity"]["spearman"][k], matrix[2, k], delta=1e-12)
        self.assertAlmostEqual(fast["mean"], sample.computeMean()[2], delta=1e-12)
        self.assertAlmostEqual(fast["deviation"], sample.computeStandardDeviation()[2], delta=1e-12)
        ordered = sorted(float(row["fast [m/s]"]) for row in table)
        at = 0.95 * (len(ordered) - 1)
        expected = ordered[int(at)] + (at - int(at)) * (ordered[int(at) + 1] - ordered[int(at)])
        self.assertAlmostEqual(fast["quantiles"]["0.95"], expected, delta=1e-15)

    # Ishigami's function as the ball's speed: the same blocks A, B and A with an axis of B for both, and the same estimators
    # (first order: Saltelli 2010, which OpenTURNS names after Mauntz and Kucherenko, and centres by the mean of all blocks).
    def test_sobol_indices_are_those_of_openturns(self):
        import openturns as ot
        x, y, z = (f"constants.{name}" for name in "xyz")
        (self.folder / "ball.yaml").write_text(
            BALL.replace("velocity: [0, 0, 0]", "velocity: [sin(x) + 7*sin(y)*sin(y) + z*z*z*z*sin(x)/10 + 20, 0, 0]", 1)
            + "constants: {x: 0, y: 0, z: 0}\n")
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsampling: saltelli\nsamples: 5000\nparameters:\n" + "".join(
            f"  {name[-1]}: {{path: {name}, uniform: {{min: {-math.pi!r}, max: {math.pi!r}}}}}\n" for name in (x, y, z)))
        summary = self.run_campaign(path, "out", code=(0, 1))
        ours = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]["sobol"]
        table = read_table(self.folder / "out")
        blocks = [table[k::5] for k in range(5)]  # A, B, A with x, y, z of B
        rows = [row for block in blocks for row in block]
        inputs = ot.Sample([[float(row[name]) for name in "xyz"] for row in rows])
        outputs = ot.Sample([[float(row["fast [m/s]"])] for row in rows])
        first = ot.MauntzKucherenkoSensitivityAlgorithm(inputs, outputs, 1000).getFirstOrderIndices()
        total = ot.JansenSensitivityAlgorithm(inputs, outputs, 1000).getTotalOrderIndices()
        # OpenTURNS divides by the variance of A, and its sums by 2 n - 1; ours by that of A and B, and by 2 n.
        a, b = ([float(row["fast [m/s]"]) for row in block] for block in blocks[:2])
        ratio = statistics.variance(a) / statistics.pvariance(a + b) * (2 * 1000 - 1) / (2 * 1000)
        # An index lies between 0 and 1; its estimate may not (that of z, whose first-order index is 0), and is cut there.
        worst = [max(abs(ours[k][key] - min(max(theirs[k] * ratio, 0), 1)) for k in range(3)) for key, theirs in (("first", first), ("total", total))]
        print(f"Sobol' indices: first order {worst[0]:.1e}, total {worst[1]:.1e}", file=sys.stderr)
        self.assertLess(worst[0], 1e-3)  # the estimator itself scatters by 0.03
        self.assertLess(worst[1], 1e-11)

    # Ishigami's function from samples as they are: z has no first-order influence, y an even one that no rank correlation sees.
    # OpenTURNS fits a polynomial chaos expansion to the same samples, ours sorts them into bins with a line in each; both come near the closed form.
    def test_first_order_indices_from_given_samples_are_those_of_openturns_and_the_closed_form(self):
        import openturns as ot
        (self.folder / "ball.yaml").write_text(
            BALL.replace("velocity: [0, 0, 0]", "velocity: [sin(x) + 7*sin(y)*sin(y) + z*z*z*z*sin(x)/10 + 20, 0, 0]", 1)
            + "constants: {x: 0, y: 0, z: 0}\n")
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 4000\nparameters:\n" + "".join(
            f"  {name}: {{path: constants.{name}, uniform: {{min: {-math.pi!r}, max: {math.pi!r}}}}}\n" for name in "xyz"))
        summary = self.run_campaign(path, "out", code=(0, 1))
        given = next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]
        table = read_table(self.folder / "out")
        inputs = ot.Sample([[float(row[name]) for name in "xyz"] for row in table])
        outputs = ot.Sample([[float(row["fast [m/s]"])] for row in table])
        terms = ot.LinearEnumerateFunction(3)
        basis = ot.OrthogonalProductPolynomialFactory([ot.LegendreFactory()] * 3, terms)
        expansion = ot.FunctionalChaosAlgorithm(inputs, outputs, ot.ComposedDistribution([ot.Uniform(-math.pi, math.pi)] * 3),
                                                ot.FixedStrategy(basis, terms.getStrataCumulatedCardinal(10)), ot.LeastSquaresStrategy())
        expansion.run()
        sobol = ot.FunctionalChaosSobolIndices(expansion.getResult())
        theirs = [sobol.getSobolIndex(k) for k in range(3)]
        # Variances by parts, of 7 sin^2 y and (1 + z^4/10) sin x.
        of_x, of_y, of_xz = 0.5 * (1 + math.pi ** 4 / 50) ** 2, 49 / 8, math.pi ** 8 * (1 / 18 - 1 / 50) / 100
        exact = [of_x / (of_x + of_y + of_xz), of_y / (of_x + of_y + of_xz), 0]
        for k, first in enumerate(given["first_order"]):
            self.assertAlmostEqual(first["index"], exact[k], delta=0.03)  # two deviations of 4000 samples
            self.assertAlmostEqual(theirs[k], exact[k], delta=0.01)  # the expansion leaves 1e-3 of the variance
            self.assertAlmostEqual(first["index"], theirs[k], delta=0.04)
            self.assertEqual(first["index"] > given["significant"], k < 2)
            self.assertLess(first["interval"][0], exact[k] + 0.02)
            self.assertGreater(first["interval"][1], exact[k] - 0.02)
        self.assertLess(abs(given["spearman"][1]), 0.05)  # blind for y

    # The seed shifts Boost's sequence: it changes the same bits of all numbers of an axis. OpenTURNS has other direction
    # numbers from the third axis on; SciPy's are those of Joe and Kuo, too.
    def test_the_sobol_sequence_is_that_of_scipy_but_for_its_shift(self):
        try:
            from scipy.stats import qmc
        except ImportError:
            self.skipTest("no SciPy; `tools/setup long` installs it")
        names = "abcdef"
        ball = BALL.replace("velocity: [0, 0, 0]", "velocity: [(a + b + c) * (1 m/s), (d + e + f) * (1 m/s), 0 m/s]")
        (self.folder / "ball.yaml").write_text(ball + "constants: {" + ", ".join(f"{name}: 0" for name in names) + "}\n")
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsampling: sobol\nsamples: 256\nparameters:\n" + "".join(
            f"  {name}: {{path: constants.{name}, uniform: {{min: 0, max: 1}}}}\n" for name in names))
        self.run_campaign(path, "out", code=(0, 1))
        ours = read_table(self.folder / "out")
        theirs = qmc.Sobol(len(names), scramble=False, bits=32).random(256)
        for k, name in enumerate(names):
            shifts = {int(float(row[name]) * 2**40) ^ int(point[k] * 2**40) for row, point in zip(ours, theirs, strict=True)}
            self.assertEqual(len(shifts), 1, name)

    # Oracle: OpenTURNS' Wilks, for the least number of samples and for one order more. Closed form, in hil/statistics_test.cc: the
    # greatest of n samples is above a part c of all with the confidence 1 - c^n.
    def test_tolerance_limits_need_as_many_samples_as_openturns_says(self):
        import openturns as ot
        needed = ot.Wilks.ComputeSampleSize(0.99, 0.95, 0)
        for count, enough in ((needed - 1, False), (needed, True)):
            path = self.write(f"samples: {count}\nparameters:\n  v: {{path: 'bodies.ball.velocity[0]', uniform: {{min: 0 m/s, max: 1 m/s}}}}\n")
            tolerance = self.run_campaign(path, f"out{count}", code=(0, 1))["requirements"][0]["tolerance"]
            self.assertEqual(tolerance["samples_needed"], needed)
            self.assertEqual("upper" in tolerance, enough)
        second = ot.Wilks.ComputeSampleSize(0.99, 0.95, 1)
        path = self.write(f"samples: {second}\nparameters:\n  v: {{path: 'bodies.ball.velocity[0]', uniform: {{min: 0 m/s, max: 1 m/s}}}}\n")
        upper = self.run_campaign(path, "second", code=(0, 1))["requirements"][0]["tolerance"]["upper"]
        self.assertEqual(upper, sorted(float(row["fast [m/s]"]) for row in read_table(self.folder / "second"))[-2])

    def test_rare_failures_have_the_probability_that_is_known_and_that_openturns_finds(self):
        import openturns as ot
        seeds = range(1, 6)
        # Linear: one axis alone fails, 4.26 sigma away. Nonlinear: a circle, which has no preferred direction. Both 1e-5.
        for name, mean, sigma_y in (("linear", 1.0, 1e-6), ("circle", 0.0, None)):
            sigma = (2.5 - mean) / 4.264890793922825 if name == "linear" else 2.5 / math.sqrt(-2 * math.log(1e-5))
            ours, ours_said = [], []
            for seed in seeds:
                path = self.write_rare(seed=seed, samples=900, mean=mean, sigma=sigma, sigma_y=sigma_y)
                rare = self.run_campaign(path, f"{name}{seed}")["rare"]
                self.assertTrue(rare["finished"] and rare["reached"])
                self.assertLessEqual(rare["levels_run"][-1]["last"], 5000)
                ours.append(rare["probability"])
                ours_said.append(rare["deviation"])
            theirs, theirs_said = [], []
            limit = ot.PythonFunction(2, 1, func=lambda v: [math.hypot(v[0], v[1])])
            inputs = ot.JointDistribution if hasattr(ot, "JointDistribution") else ot.ComposedDistribution
            vector = ot.RandomVector(inputs([ot.Normal(mean, sigma), ot.Normal(0, sigma if sigma_y is None else sigma_y)]))
            for seed in seeds:
                ot.RandomGenerator.SetSeed(seed)
                event = ot.ThresholdEvent(ot.CompositeRandomVector(limit, vector), ot.Greater(), 2.5)
                sampling = ot.SubsetSampling(event)
                sampling.setMaximumOuterSampling(1000)
                sampling.setBlockSize(1)
                sampling.run()
                theirs.append(sampling.getResult().getProbabilityEstimate())
                theirs_said.append(sampling.getResult().getCoefficientOfVariation())
            for estimates in (ours, theirs):  # by logarithms, since single estimates scatter by half
                center = statistics.fmean(math.log10(p) for p in estimates)
                self.assertAlmostEqual(center, -5, delta=4 * 0.25 / math.sqrt(len(estimates)), msg=f"{name}: {ours} {theirs}")
            ratio = statistics.fmean(ours_said) / statistics.fmean(theirs_said)
            self.assertTrue(0.5 < ratio < 2, f"{name}: {ours_said} {theirs_said}")

    def test_rare_failures_are_the_same_for_any_jobs_and_when_resumed(self):
        path = self.write_rare(samples=300)
        whole = self.run_campaign(path, "one", "--jobs", "1")
        many = self.run_campaign(path, "many", "--jobs", "5")
        self.assertEqual(many["hash"], whole["hash"])
        self.assertEqual(many["rare"], whole["rare"])
        # The folder of a campaign that ended anywhere, and one whose record was damaged in mid-file.
        results = (self.folder / "one" / "results.bin").read_bytes()
        for k in range(8):
            folder = self.folder / f"cut{k}"
            folder.mkdir()
            shutil.copy(self.folder / "one" / "manifest.json", folder)
            cut = bytearray(results[:len(results) * (k + 1) // 9])
            if k % 2 == 0:
                cut[len(cut) // 3] ^= 1
            (folder / "results.bin").write_bytes(cut)
            resumed = self.run_campaign(path, folder.name, "--resume", "--jobs", str(1 + k % 3))
            self.assertEqual(resumed["rare"], whole["rare"])
            self.assertEqual(resumed["hash"], whole["hash"])
            self.assertEqual((folder / "samples.csv").read_bytes(), (self.folder / "one" / "samples.csv").read_bytes())
        merged = json.loads(self.run_ok(UNLATCH, "campaign", "merge", self.folder / "one", "--out", self.folder / "merged", "--json", "-").stdout)
        self.assertEqual(merged["rare"], whole["rare"])

    def test_the_first_level_of_rare_failures_are_independent_samples(self):
        path = self.write_rare(samples=200)
        self.run_campaign(path, "rare")
        plain = self.folder / "plain.yaml"
        plain.write_text("\n".join(line for line in path.read_text().splitlines() if "subset" not in line) + "\n")
        self.run_campaign(plain, "plain")
        rare, independent = read_table(self.folder / "rare"), read_table(self.folder / "plain")
        self.assertEqual(rare[:200], independent)
        # Each later sample runs again to the bit, from the folder.
        last = rare[-1]
        self.assertGreater(len(rare), 200 + 3 * 180)
        alone = json.loads(self.run_ok(UNLATCH, "run", path, "--sample", last["sample"], "--results", self.folder / "rare", "--json", "-", code=None).stdout)
        self.assertEqual(alone["hash"], last["hash"])
        for options, message in ((["--sample", "700"], "--results"), (["--sample", "799999", "--results", self.folder / "rare"], "samples 0 to"),
                                 (["--sample", "700", "--results", self.folder / "plain"], "another campaign")):
            done = call(UNLATCH, "run", path, *options)
            self.assertEqual(done.returncode, 2)
            self.assertIn(message, done.stderr)
        done = call(UNLATCH, "campaign", path, "--out", self.folder / "part", "--samples", "0:10")
        self.assertEqual(done.returncode, 2)
        self.assertIn("follow from one another", done.stderr)

    def test_the_allowed_probability_decides_the_exit_code(self):
        for at_most, code in (("1e-3", 0), ("1e-7", 1)):
            path = self.write_rare(samples=300, of=f"fast, above: 250 cm/s, at_most: {at_most}", name=f"{code}.yaml")
            rare = self.run_campaign(path, f"allowed{code}", code=code)["rare"]
            self.assertEqual(rare["met"], code == 0)
            self.assertAlmostEqual(rare["limit"], 2.5, delta=1e-12)

    def test_screening_finds_the_one_parameter_that_matters(self):
        parameters = ("parameters:\n  m: {path: bodies.ball.mass, normal: {mean: 2, sigma: 5 %}}\n"
                      "  v: {path: 'bodies.ball.velocity[1]', uniform: {min: 0.1 m/s, max: 1 m/s}}\n")
        morris = self.run_campaign(self.write("sampling: morris\nsamples: 30\n" + parameters), "morris")
        fast = next(c for c in morris["columns"] if c["name"] == "fast")["sensitivity"]["morris"]
        self.assertGreater(fast[1]["mean_size"], 0.1)
        self.assertLess(fast[0]["mean_size"], 1e-9)
        sobol = self.run_campaign(self.write("sampling: saltelli\nsamples: 800\n" + parameters, "s.yaml"), "sobol")
        fast = next(c for c in sobol["columns"] if c["name"] == "fast")["sensitivity"]["sobol"]
        self.assertAlmostEqual(fast[1]["total"], 1, delta=0.15)
        self.assertAlmostEqual(fast[0]["total"], 0, delta=1e-9)
        self.assertTrue(math.isfinite(fast[0]["first"]))

    def test_morris_effects_are_those_of_the_whole_grid(self):
        # The speed is hypot(v, w), its value at any point known, so its elementary effects on all 4 x 4 levels are too.
        trajectories, step = 2500, 2 / 3
        ranges = {"v": (-1, 1), "w": (0, 2)}
        parameters = "".join(f"  {name}: {{path: 'bodies.ball.velocity[{k}]', uniform: {{min: {low} m/s, max: {high} m/s}}}}\n"
                             for k, (name, (low, high)) in enumerate(ranges.items()))
        parameters += "  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n"
        path = self.write(f"sampling: morris\nsamples: {4 * trajectories}\nseed: 11\nparameters:\n{parameters}")
        summary = self.run_campaign(path, "out", code=(0, 1))
        found = {e["parameter"]: e for e in next(c for c in summary["columns"] if c["name"] == "fast")["sensitivity"]["morris"]}
        table, names = read_table(self.folder / "out"), {"v": "v [m/s]", "w": "w [m/s]", "m": "m [kg]"}
        for row in table[::97]:
            self.assertAlmostEqual(float(row["fast [m/s]"]), math.hypot(float(row["v [m/s]"]), float(row["w [m/s]"])), delta=1e-12)
        # The table's own effects, from which coordinate moved and which way.
        effects = {name: [] for name in names}
        for begin in range(0, len(table), 4):
            for before, after in zip(table[begin:begin + 3], table[begin + 1:begin + 4]):
                moved = [name for name, column in names.items() if before[column] != after[column]]
                self.assertEqual(len(moved), 1)
                sign = math.copysign(1, float(after[names[moved[0]]]) - float(before[names[moved[0]]]))
                effects[moved[0]].append(sign * (float(after["fast [m/s]"]) - float(before["fast [m/s]"])) / step)
        for name, own in effects.items():
            self.assertEqual(len(own), trajectories)
            self.assertAlmostEqual(found[name]["mean"], statistics.mean(own), delta=1e-12)
            self.assertAlmostEqual(found[name]["mean_size"], statistics.mean(map(abs, own)), delta=1e-12)
            self.assertAlmostEqual(found[name]["deviation"], statistics.stdev(own), delta=1e-12)
        # The whole grid's: a design that favoured some levels or directions would miss them.
        levels = [[low + (0.01 + 0.98 * k / 3) * (high - low) for k in range(4)] for low, high in ranges.values()]
        for name, whole in (("v", [(math.hypot(levels[0][k + 2], w) - math.hypot(levels[0][k], w)) / step for k in (0, 1) for w in levels[1]]),
                            ("w", [(math.hypot(v, levels[1][k + 2]) - math.hypot(v, levels[1][k])) / step for k in (0, 1) for v in levels[0]]),
                            ("m", [0.0])):
            sizes, deviation = [abs(e) for e in whole], statistics.pstdev(whole)
            error = 4 / math.sqrt(trajectories)  # four standard errors
            self.assertAlmostEqual(found[name]["mean"], statistics.mean(whole), delta=error * deviation + 1e-12)
            self.assertAlmostEqual(found[name]["mean_size"], statistics.mean(sizes), delta=error * statistics.pstdev(sizes) + 1e-12)
            self.assertAlmostEqual(found[name]["deviation"], deviation, delta=error * deviation + 1e-12)


if __name__ == "__main__":
    main()
