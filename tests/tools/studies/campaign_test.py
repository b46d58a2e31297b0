#!/usr/bin/env python3
"""Facts about `unlatch campaign`: the same table for any jobs, order and interruption; samples that run again to the bit;
tables, files and messages.

    campaign_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import json
import math
import os
import pty
import re
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path
from random import Random

from browser import Browser
from campaign_cases import BALL, CampaignCase, read_table
from processes import BIN, HANG, SANITIZED, SCENARIOS, SOURCE, UNLATCH, call, main

CAMPAIGN = SCENARIOS / "boosters" / "campaign.yaml"


class CampaignTest(CampaignCase):
    def run_boosters(self, out, *options):
        return self.run_campaign(CAMPAIGN, out, "--set", "step.until=0.4", *options, code=1)  # no joint opens by then

    def test_jobs_parts_and_order_give_the_same_table_and_hash(self):
        whole = self.run_boosters("whole", "--samples", "0:24", "--jobs", "3")
        self.run_boosters("late", "--samples", "9:24", "--jobs", "1")
        self.run_boosters("early", "--samples", "0:12", "--jobs", "2")  # overlaps
        merged = json.loads(self.run_ok(UNLATCH, "campaign", "merge", self.folder / "late", self.folder / "early", "--out",
                                        self.folder / "merged", "--json", "-", code=1).stdout)
        self.assertEqual(whole["hash"], merged["hash"])
        for name in ("samples.csv", "samples.parquet"):
            self.assertEqual((self.folder / "whole" / name).read_bytes(), (self.folder / "merged" / name).read_bytes())

    # An arm that locks at 0.1 rad within the run where it swings fast enough; the blow passes through the base's weld.
    def test_the_summary_names_requirements_whose_values_leave_out_the_impulse_of_a_blow(self):
        (self.folder / "arm.yaml").write_text("""unlatch: 1
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
  - {id: root, reaction: {joint: root, row: force}, at_most: 10 N}
  - {id: speed, rate: {body: arm}, at_most: 10 rad/s}
""")
        path = self.folder / "arm-campaign.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: arm.yaml\nsampling: grid\n"
                        "parameters: {w: {path: constants.w, discrete: {values: [0.1 rad/s, 0.9 rad/s, 1 rad/s, 0.2 rad/s, 1.1 rad/s]}}}\n")
        summary = self.run_campaign(path, "arm")
        self.assertEqual([one.get("without_blow") for one in summary["requirements"]], [3, None])
        said = self.run_ok(UNLATCH, "campaign", path, "--out", self.folder / "again").stdout
        self.assertIn("note: the values of root in 3 samples are without the impulse of a blow through the joint", said)
        self.assertEqual([row["root.without_blow [s]"] != "" for row in read_table(self.folder / "arm")], [False, True, True, False, True])

    def test_a_sample_run_alone_has_the_hash_of_the_table(self):
        path = self.write("samples: 5\nparameters:\n  m: {path: bodies.ball.mass, normal: {mean: nominal, sigma: 1 %}}\n"
                          "  v: {path: 'bodies.ball.velocity[0]', uniform: {min: -1 m/s, max: 1 m/s}}\n")
        self.run_campaign(path, "out")
        row = read_table(self.folder / "out")[3]
        log = self.folder / "three.log"
        alone = json.loads(self.run_ok(UNLATCH, "run", path, "--sample", "3", "--json", "-", "--log", log).stdout)
        self.assertEqual(alone["hash"], row["hash"])
        self.assertEqual(json.loads(self.run_ok(UNLATCH, "replay", log, "--json", "-").stdout)["hash"], row["hash"])
        self.assertAlmostEqual(alone["verdict"][0]["value"], float(row["fast [m/s]"]), delta=1e-15)

    def test_killed_at_any_moment_it_resumes_to_the_same_hash(self):
        kills = int(os.environ.get("UNLATCH_KILLS", "24"))
        seed = int(os.environ.get("UNLATCH_SEED", "27"))
        print(f"{kills} kills, seed {seed}", file=sys.stderr)
        random = Random(seed)
        plain = self.write("samples: 3000\nsampling: latin-hypercube\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        campaigns = []  # file, folder of the whole, hash, seconds that it took
        for name, path in (("plain", plain), ("rare", self.write_rare(samples=600))):
            begin = time.monotonic()
            campaigns.append((path, self.folder / name, self.run_campaign(path, name, "--jobs", "2")["hash"], time.monotonic() - begin))
        out = self.folder / "killed"
        ended = 0
        while kills > 0:
            path, whole, expected, seconds = campaigns[ended % 2]
            records = (whole / "results.bin").stat().st_size
            kept = 0
            while kills > 0 and kept < records:  # some are killed while they read, some in their samples, some in the tables
                # In a group of its own, since its writer of Parquet is killed with it.
                process = subprocess.Popen([UNLATCH, "campaign", path, "--out", out, "--jobs", "2", "--resume"],
                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
                time.sleep(random.uniform(0, random.choice([0.02, 0.2, seconds])))
                os.killpg(process.pid, signal.SIGKILL)  # its end is not waited for yet, so that the group exists
                process.wait()
                kills -= 1
                size = (out / "results.bin").stat().st_size if (out / "results.bin").exists() else 0
                self.assertGreaterEqual(size + 4096, kept)  # at most the records in progress are lost
                kept = size
            summary = self.run_campaign(path, "killed", "--resume")
            self.assertEqual(summary["hash"], expected, f"seed {seed}")
            self.assertEqual((out / "samples.csv").read_bytes(), (whole / "samples.csv").read_bytes())
            shutil.rmtree(out)
            ended += 1
        print(f"{ended} campaigns resumed to their hash", file=sys.stderr)

    def test_the_writer_of_parquet_dies_with_a_campaign_that_is_killed(self):
        if not shutil.which("node") and not shutil.which("nodejs"):
            self.skipTest("no Node.js")
        path = self.write("samples: 3000\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        process = self.begin(UNLATCH, "campaign", path, "--out", self.folder / "out")
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")  # of its first thread
        writers = []
        while not writers and process.poll() is None:
            writers = children.read_text().split()
        self.assertNotEqual(writers, [], "it ended before its writer was seen")
        process.kill()
        process.wait()
        stat = Path(f"/proc/{writers[0]}/stat")
        for _ in range(HANG * 100):
            # Whoever inherits it may leave it as a zombie.
            if not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] in "ZX":
                return
            time.sleep(0.01)
        self.fail("the writer goes on")

    def test_the_progress_is_shown_on_a_terminal(self):
        path = self.write("samples: 200000\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        terminal, other = pty.openpty()
        process = subprocess.Popen([UNLATCH, "campaign", path, "--out", self.folder / "out"], stdout=subprocess.DEVNULL, stderr=other)
        os.close(other)
        shown = ""
        # Until it has been shown twice; then Ctrl-C, which is reported.
        while len(re.findall(" left", shown)) < 2 and process.poll() is None:
            shown += os.read(terminal, 4096).decode()
        process.send_signal(signal.SIGINT)
        try:
            while text := os.read(terminal, 4096):
                shown += text.decode()
        except OSError:  # the other end is closed
            pass
        os.close(terminal)
        self.assertEqual(process.wait(HANG), 1)
        lines = re.findall(r"\r\x1b\[K(\d+) of 200000 samples, ([\d.]+) a second, [\d.]+ (?:s|min|h) left", shown)
        self.assertGreaterEqual(len(lines), 2, shown)
        done = [int(count) for count, _ in lines]
        self.assertEqual(done, sorted(done))
        self.assertLess(done[0], done[-1])
        self.assertTrue(all(float(rate) > 0 for _, rate in lines))
        self.assertIn("interrupted; --resume continues", shown)
        self.assertGreaterEqual(len(read_table(self.folder / "out")), done[-1])

    def test_parameters_of_paths_whose_stars_mean_the_same_have_names_of_their_own(self):
        (self.folder / "ball.yaml").write_text(BALL.replace("bodies:\n", "bodies:\n  low_l: {mass: 1, inertia: [1, 1, 1], position: [9, 0, 0]}\n"
                                                            "  high_l: {mass: 1, inertia: [1, 1, 1], position: [0, 9, 0]}\n", 1))
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 3\nparameters:\n"
                        "  m: {path: [bodies.low_*.mass, bodies.high_*.mass], normal: {mean: nominal, sigma: 1 %}}\n"
                        "  x: {path: 'bodies.*_l.mass', uniform: {min: 1 kg, max: 2 kg}}\n")
        said = self.run_ok(UNLATCH, "check", path, code=2).stderr
        self.assertIn("is varied twice", said)  # both parameters
        path.write_text(path.read_text().replace("  x: {path: 'bodies.*_l.mass', uniform: {min: 1 kg, max: 2 kg}}\n",
                                                 "  x: {path: 'bodies.*_l.inertia[0]', uniform: {min: 1, max: 1.5}}\n"))
        names = [column["name"] for column in self.run_campaign(path, "out", code=(0, 1))["inputs"]]
        self.assertEqual(names, ["m:low_l", "m:high_l", "x:low", "x:high"])
        path.write_text(path.read_text().replace("samples: 3", "sampling: csv\ntable: t.csv"))
        (self.folder / "t.csv").write_text("m:low_l,m:low_l\n1,1\n")
        self.assertIn("two columns 'm:low_l'", self.run_ok(UNLATCH, "check", path, code=2).stderr)

    def test_check_warns_of_the_scenario_and_of_the_corners_of_what_may_be_drawn(self):
        spring = ("elements:\n  soft: {type: spring, between: [base, ball], follower_point: [0, 0, 1], stiffness: k}\n"
                  "constants: {k: 10}\n")
        (self.folder / "ball.yaml").write_text(BALL + spring)
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 3\nparameters:\n"
                        "  k: {path: constants.k, uniform: {min: 1, max: 1e6}}\n")
        self.assertEqual(self.run_json(UNLATCH, "check", self.folder / "ball.yaml")["warnings"], [])
        warnings = self.run_json(UNLATCH, "check", path)["warnings"]
        self.assertEqual([(w["name"], w["where"]) for w in warnings], [("step", "element 'soft'")])
        self.assertTrue(0 < warnings[0]["corners"] < 8, warnings)
        self.assertIn("corners of what may be drawn", self.run_ok(UNLATCH, "check", path).stdout)
        (self.folder / "ball.yaml").write_text(BALL + spring.replace("k: 10", "k: 1e6"))
        self.assertEqual(self.run_json(UNLATCH, "check", path)["warnings"][0]["corners"], 0)

    def test_columns_of_a_table_that_no_parameter_reads_are_named(self):
        (self.folder / "box.yaml").write_text("unlatch: 1\nname: box\nstep: {dt: 10 ms, until: 20 ms}\nconstants: {mass: 1 kg}\n"
                                              "bodies: {box: {mass: mass, inertia: [1, 1, 1]}}\n")
        file = self.folder / "box-campaign.yaml"
        file.write_text("unlatch_campaign: 1\nname: box\nscenario: box.yaml\nsampling: csv\ntable: t.csv\nparameters: {load: {path: constants.mass}}\n")
        remark = "the table has 2 columns that no parameter reads: 'stiffness', 'note'"
        for heads, remarks in (("stiffness [N/m],load,note", [remark]), ("load", [])):
            (self.folder / "t.csv").write_text(heads + "\n" + ",".join("1" for _ in heads.split(",")) + "\n")
            self.assertEqual(self.run_json(UNLATCH, "check", file)["remarks"], remarks)
            out = self.folder / f"out{len(remarks)}"
            done = self.run_ok(UNLATCH, "campaign", file, "--out", out)
            self.assertEqual(("note: " + remark) in done.stdout, bool(remarks), done.stdout)
            self.assertEqual(json.loads((out / "summary.json").read_text())["remarks"], remarks)
            merged = self.run_ok(UNLATCH, "campaign", "merge", out, "--out", self.folder / f"merged{len(remarks)}")
            self.assertEqual(("note: " + remark) in merged.stdout, bool(remarks), merged.stdout)

    # Limits in deg/s and mm, an offset drawn in mm, a speed as a plain number: the tables for a review have these units.
    def test_a_review_has_the_units_of_the_files_and_inputs_have_the_units_of_their_places(self):
        (self.folder / "units.yaml").write_text("""unlatch: 1
name: units
step: {dt: 1 ms, until: 0.1 s}
constants: {most: 2 deg/s}
bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [1, 0, 0], rate: [0, 0, 0.01]}}
requirements:
  - {id: slow, text: "It | turns slowly", rate: {body: ball}, at_most: most}
  - {id: near, position: {body: ball, component: y}, range: [-2 mm, 2 mm]}
  - {id: kept, velocity: {body: ball}, at_least: 0.5}
""")
        (self.folder / "units-campaign.yaml").write_text("""unlatch_campaign: 1
name: units
scenario: units.yaml
samples: 50
parameters:
  y: {path: "bodies.ball.position[1]", normal: {mean: 0 mm, sigma: 1 mm, within: 3}}
  v: {path: "bodies.ball.velocity[0]", uniform: {min: 0.6, max: 1.2}}
  r: {path: "bodies.ball.rate[2]", uniform: {min: 0.5 deg/s, max: 1.5 deg/s}}
""")
        out = self.folder / "units"
        printed = self.run_ok(UNLATCH, "campaign", self.folder / "units-campaign.yaml", "--out", out, code=None).stdout
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual([(i["name"], i["unit"], (i["shown"] or {}).get("unit")) for i in summary["inputs"]],
                         [("y", "m", "mm"), ("v", "m/s", None), ("r", "rad/s", "deg/s")])
        with open(out / "requirements.csv", newline="", encoding="utf-8") as file:
            rows = {row["requirement"]: row for row in csv.DictReader(file)}
        self.assertEqual([rows[name]["unit"] for name in ("slow", "near", "kept")], ["deg/s", "mm", "m/s"])
        self.assertEqual((rows["slow"]["at most"], rows["near"]["at least"], rows["near"]["at most"], rows["kept"]["at least"]), ("2", "-2", "2", "0.5"))
        quantiles = {r["id"]: r["quantiles"] for r in summary["requirements"]}
        self.assertAlmostEqual(float(rows["slow"]["quantile 0.5"]), math.degrees(quantiles["slow"]["0.5"]), places=8)
        self.assertAlmostEqual(float(rows["near"]["quantile 0.95"]), 1e3 * quantiles["near"]["0.95"], places=8)
        for one in summary["requirements"]:  # an estimate beside the bounds
            self.assertEqual(one["estimate"], one["failed"] / summary["samples"])
            self.assertRegex(printed, rf"{one['id']} +\d+ +\d+ +\d+ +{one['estimate']:.5g}  ")
        any_ = summary["any_requirement"]
        self.assertEqual(int(rows["any"]["failed"]), any_["failed"])
        self.assertAlmostEqual(float(rows["any"]["bound high"]), any_["probability"][1], places=8)
        self.assertEqual(rows["near"]["verdict"], "not met" if int(rows["near"]["failed"]) else "met")
        review = (out / "review.md").read_text()
        self.assertIn("| slow | It \\| turns slowly | deg/s |  | 2 | met |", review)
        self.assertIn("| y | mm |", review)
        self.assertRegex(printed, r"slow .* deg/s +needs 299 samples\n")
        # The page has them too, and the row of a run that misses any requirement.
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", out, "--out", page, "--flights", "0")
        browser = Browser()
        self.addCleanup(browser.close)
        browser.open(page)
        self.assertEqual(browser.complaints, [])
        cells = browser.evaluate("[...document.querySelectorAll('#verdict tr')].slice(1).map((row) => [...row.children].map((cell) => cell.textContent))")
        self.assertEqual([row[0] for row in cells], ["slow", "near", "kept", "any requirement"])
        self.assertEqual([row[1] for row in cells], ["≤ 2 deg/s", "≥ -2, ≤ 2 mm", "≥ 0.5 m/s", ""])
        requirements = {one["id"]: one for one in summary["requirements"]}
        self.assertAlmostEqual(float(cells[0][11]), math.degrees(requirements["slow"]["quantiles"]["0.5"]), delta=1e-4)
        self.assertAlmostEqual(float(cells[1][11]), 1e3 * requirements["near"]["quantiles"]["0.5"], delta=1e-4)
        self.assertEqual(cells[3][2], str(summary["any_requirement"]["failed"]))
        self.assertEqual(browser.evaluate("[...document.querySelectorAll('#worst th')].slice(1, 3).map((cell) => cell.textContent)"), ["slow [deg/s]", "near [mm]"])
        self.assertEqual(browser.evaluate("[...document.querySelectorAll('#inputs tr')].slice(1).map((row) => row.children[1].textContent)"), ["mm", "m/s", "deg/s"])

    # Springs of a catalogue: stiffness and preload of one row together.
    def test_rows_of_a_catalogue_are_drawn_together(self):
        (self.folder / "rows.yaml").write_text("""unlatch: 1
name: rows
step: {dt: 1 ms, until: 10 ms}
bodies: {ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 2, 0]}}
requirements: [{id: v, velocity: {body: ball}, at_least: 0}]
""")
        text = """unlatch_campaign: 1
name: rows
scenario: rows.yaml
samples: 20
parameters:
  part: {path: ["bodies.ball.velocity[0]", "bodies.ball.velocity[1]"], shared: true, discrete: {rows: [[3, 4], [5, 12], [8, 15]]}}
"""
        (self.folder / "rows-campaign.yaml").write_text(text)
        out = self.folder / "rows"
        self.run_ok(UNLATCH, "campaign", self.folder / "rows-campaign.yaml", "--out", out)
        with open(out / "samples.csv", newline="", encoding="utf-8") as file:
            drawn = {(float(row["part"]), round(float(row["v [m/s]"]), 9)) for row in csv.DictReader(file)}
        self.assertEqual(drawn, {(0, 5), (1, 13), (2, 17)})
        (self.folder / "rows-campaign.yaml").write_text(text.replace("[5, 12]", "[5]"))
        self.assertIn("not a row of 2 values", self.run_ok(UNLATCH, "check", self.folder / "rows-campaign.yaml", code=2).stderr)

    def test_numbers_drawn_for_constants_keep_their_units(self):
        (self.folder / "ball.yaml").write_text(BALL.replace("velocity: [0, 0, 0]", "velocity: [way / span, 0, 0]", 1)
                                               + "constants: {way: 2 m, span: 1 s}\n")
        path = self.folder / "c.yaml"
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 4\nparameters:\n"
                        "  way: {path: constants.way, uniform: {min: 1 m, max: 3 m}}\n")
        self.run_campaign(path, "o", code=(0, 1))
        for row in read_table(self.folder / "o"):
            self.assertAlmostEqual(float(row["fast [m/s]"]), float(row["way [m]"]), delta=1e-12)  # m/s: both fall alike

    def test_a_folder_with_results_is_not_overwritten_and_not_mixed(self):
        text = "samples: 4\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n"
        path = self.write(text)
        self.run_campaign(path, "out")
        self.assertEqual(call(UNLATCH, "campaign", path, "--out", self.folder / "out").returncode, 2)
        other = self.write(text + "seed: 2\n", "other.yaml")
        done = call(UNLATCH, "campaign", other, "--out", self.folder / "out", "--resume")
        self.assertEqual(done.returncode, 2)
        self.assertIn("another campaign", done.stderr)

    def test_outputs_and_curves_are_columns_of_the_same_table(self):
        path = self.write(self.CURVED)
        summary = self.run_campaign(path, "whole", "--jobs", "3")
        table = read_table(self.folder / "whole")
        for row in table:
            start, step = float(row["v [m/s]"]), 0.02 * -9.81
            for k, name in enumerate(("0", "0.02", "0.04")):
                self.assertAlmostEqual(float(row[f"curve.ball.vx@{name} [m/s]"]), start + k * step, delta=1e-12)
            self.assertAlmostEqual(float(row["output.ball.vx.final [m/s]"]), start + 2.5 * step, delta=1e-12)
            self.assertEqual(row["output.ball.vx.max [m/s]"], row["curve.ball.vx@0 [m/s]"])
            self.assertEqual(row["output.ball.vy.final [m/s]"], "0")
        self.assertNotIn("curve.ball.vx@0.06 [m/s]", table[0])
        # Parts and resumption give the same table and hash.
        self.run_campaign(path, "late", "--samples", "15:40", code=0)
        self.run_campaign(path, "early", "--samples", "0:10")
        self.run_campaign(path, "early", "--samples", "0:20", "--resume")
        merged = json.loads(self.run_ok(UNLATCH, "campaign", "merge", self.folder / "late", self.folder / "early", "--out",
                                        self.folder / "merged", "--json", "-").stdout)
        self.assertEqual(merged["hash"], summary["hash"])
        for name in ("samples.csv", "samples.parquet"):
            if (self.folder / "whole" / name).exists():  # without Node.js there is no Parquet
                self.assertEqual((self.folder / "whole" / name).read_bytes(), (self.folder / "merged" / name).read_bytes())
        manifest = json.loads((self.folder / "whole/manifest.json").read_text())
        kinds = [column["kind"] for column in manifest["columns"]]
        self.assertEqual((kinds.count("output"), kinds.count("curve")), (4, 6))
        # Bands of the curve, from the table.
        curve = summary["curves"][0]
        self.assertEqual((curve["name"], curve["unit"], curve["times"]), ("ball.vx", "m/s", [0, 0.02, 0.04]))
        column = sorted(float(row["curve.ball.vx@0.04 [m/s]"]) for row in table)
        self.assertEqual((curve["count"][2], curve["min"][2], curve["max"][2]), (40, column[0], column[-1]))
        self.assertAlmostEqual(curve["0.5"][2], statistics.median(column), delta=1e-12)
        self.assertAlmostEqual(curve["0.05"][2], column[1] + 0.95 * (column[2] - column[1]), delta=1e-12)  # 0.05 * 39 = 1.95
        self.assertEqual(len(summary["columns"]), len(manifest["columns"]) - 6)
        # Another choice is another campaign.
        path.write_text(path.read_text().replace("every: 20 ms", "every: 10 ms"))
        self.assertEqual(call(UNLATCH, "campaign", path, "--out", self.folder / "early", "--resume").returncode, 2)
        self.assertIn("outputs and curves: 16 columns", self.run_ok(UNLATCH, "check", path).stdout)

    # Tables and statistics of 60 MB of numbers, beside those of a tenth of them. Measured by a small process, because a
    # process begins with the peak of the one that started it.
    def test_tables_need_less_memory_than_their_numbers(self):
        if SANITIZED:
            self.skipTest("a sanitizer keeps memory that is free")
        path = self.write("set: {step.until: 1 s}\nsamples: 2000\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1 kg, max: 2 kg}}\n"
                          "curves: [{of: [ball.*, base.*], every: 10 ms}]\n")
        peaks, numbers = [], []
        for part in ("0:200", "0:2000"):
            part_folder = self.folder / part.replace(":", "-")
            self.run_ok(UNLATCH, "campaign", path, "--out", part_folder, "--samples", part, code=None)
            numbers.append((part_folder / "results.bin").stat().st_size)
            measure = "import os, subprocess, sys; p = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={'PATH': ''}); print(os.wait4(p.pid, 0)[2].ru_maxrss)"
            merge = [UNLATCH, "campaign", "merge", part_folder, "--out", part_folder / "merged"]
            peaks.append(1024 * int(self.run_ok(sys.executable, "-c", measure, *merge).stdout))
            self.assertEqual((part_folder / "merged/samples.csv").read_bytes(), (part_folder / "samples.csv").read_bytes())
        self.assertGreater(numbers[1] - numbers[0], 50e6)
        self.assertLess(peaks[1] - peaks[0], 0.5 * (numbers[1] - numbers[0]))

    def test_parts_that_lack_samples_are_incomplete(self):
        path = self.write("samples: 6\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        self.run_campaign(path, "some", "--samples", "0:2")
        done = call(UNLATCH, "campaign", "merge", self.folder / "some", "--out", self.folder / "merged")
        self.assertEqual(done.returncode, 1)
        self.assertIn("incomplete: 2 of 6 samples", done.stderr)
        self.run_campaign(path, "rest", "--samples", "2:6")
        self.run_ok(UNLATCH, "campaign", "merge", self.folder / "some", self.folder / "rest", "--out", self.folder / "all")

    def test_an_event_that_never_came_is_counted_as_missing(self):
        summary = self.run_boosters("out", "--samples", "0:3")
        release = next(c for c in summary["columns"] if c["name"] == "event.release:booster1")
        self.assertEqual((release["count"], release["missing"]), (0, 3))
        self.assertEqual(read_table(self.folder / "out")[0]["event.release:booster1 [s]"], "")

    # Events with delays that make all orders, at one time too; one comes in a part of the samples, one never.
    def test_samples_are_classed_by_the_order_of_their_events(self):
        names = ("late", "bell", "a", "never")
        (self.folder / "ball.yaml").write_text(BALL + "signals: [" + ", ".join(f"s{k}" for k in range(4)) + "]\nevents:\n" + "".join(
            f"  - {{name: {name}, when: {{time: {0.01 if k < 3 else 1}}}, delay: 0, then: [{{raise: s{k}}}]}}\n" for k, name in enumerate(names)))
        path = self.folder / "c.yaml"
        delays = {"late": "0 ms, 10 ms, 90 ms", "bell": "0 ms, 10 ms", "a": "0 ms, 10 ms, 20 ms"}
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\nsamples: 200\nparameters:\n" + "".join(
            f"  {name}: {{path: events.{name}.delay, discrete: {{values: [{values}]}}}}\n" for name, values in delays.items()))
        summary = self.run_campaign(path, "out", code=(0, 1))
        classes = {}
        for row in read_table(self.folder / "out"):
            events = [(float(row[f"event.{name} [s]"]), place, name) for place, name in enumerate(names) if row[f"event.{name} [s]"]]
            events.sort()
            order = "".join(("" if k == 0 else " = " if events[k][0] == events[k - 1][0] else " > ") + events[k][2] for k in range(len(events)))
            classes.setdefault(order, []).append(int(row["sample"]))
        self.assertGreater(len(classes), 10)
        expected = sorted(classes, key=lambda order: (-len(classes[order]), order))
        self.assertEqual(summary["orders"]["count"], len(classes))
        self.assertEqual(summary["orders"]["classes"],
                         [{"order": order, "samples": len(classes[order]), "first": classes[order][0]} for order in expected[:20]])

    # tests/data/golden.json: of every instruction set, compiler and processor (tools/determinism).
    def test_the_first_samples_have_the_golden_hash(self):
        golden = json.loads((SOURCE / "tests/data/golden.json").read_text())["campaigns"]["boosters/campaign"]
        summary = self.run_campaign(CAMPAIGN, "out", "--samples", "0:8", code=(0, 1))
        self.assertEqual(golden, {"0:8": summary["hash"]})

    def test_parquet_has_the_columns_of_the_csv_file(self):
        path = self.write("samples: 20\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        self.run_campaign(path, "out", code=(0, 1))
        if not (self.folder / "out/samples.parquet").exists():
            self.skipTest("no Node.js")
        modules = next(path for path in BIN.parent.glob("**/node_modules") if (path / "hyparquet").is_dir())
        read = json.loads(self.run_ok("node", SOURCE / "tests/tools/formats/read_export.mjs", modules, self.folder / "out/samples.parquet").stdout)
        rows = read_table(self.folder / "out")
        self.assertEqual(list(read["units"]), [name.split(" [")[0] for name in rows[0]])
        self.assertEqual(read["rows"], len(rows))
        for name, text in rows[-1].items():
            value = read["last"][name.split(" [")[0]]
            self.assertEqual(value, text if isinstance(value, str) else float(text))

    def test_check_knows_campaigns(self):
        self.assertIn("is valid", self.run_ok(UNLATCH, "check", CAMPAIGN).stdout)
        path = self.write("samples: 4\nparameters:\n  m: {path: bodies.ball.mass, normal: {mean: 2, sigma: 1}}\n")
        done = call(UNLATCH, "check", path)
        self.assertEqual(done.returncode, 2)
        self.assertIn("probability of 0.0228", done.stderr)

    def test_a_full_disk_ends_it_with_an_error_and_a_readable_file(self):
        path = self.write("samples: 2000\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        limited = f"ulimit -f 64; exec '{UNLATCH}' campaign '{path}' --out '{self.folder}/full'"  # blocks of 1024 bytes
        done = call("bash", "-c", limited)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("results.bin", done.stderr)
        merged = self.run_ok(UNLATCH, "campaign", "merge", self.folder / "full", "--out", self.folder / "read", "--json", "-", code=1)
        self.assertIn("incomplete: ", merged.stderr)
        self.assertGreater(json.loads(merged.stdout)["samples"], 10)

    def test_flight_software_that_takes_no_part_is_reported(self):
        path = self.write("samples: 2\nset: {flight_software.required: [fsw]}\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        for arguments in (["campaign", path, "--out", self.folder / "out"], ["check", path], ["run", path, "--sample", "1"]):
            done = self.run_ok(UNLATCH, *arguments)
            self.assertIn("requires flight software (fsw), which takes no part in a", done.stdout + done.stderr)
        (self.folder / "c.yaml").write_text(path.read_text().replace("[fsw]", "[]"))
        done = self.run_ok(UNLATCH, "campaign", path, "--out", self.folder / "without")
        self.assertNotIn("flight software", done.stdout + done.stderr)

    def check_script(self, name, *options, stubs, times=1):
        """Runs the script with these programs before the others in the path: it gives the table of one campaign; returns its output."""
        path = self.write("samples: 50\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n", "a b.yaml")
        for stub, text in stubs.items():
            (self.folder / stub).write_text(text)
            (self.folder / stub).chmod(0o755)
        script = SCENARIOS / "cluster" / name
        self.run_ok("bash", "-n", script)
        out = self.folder / "the result"
        environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}", "UNLATCH": UNLATCH, "FOLDER": str(self.folder)}
        for _ in range(times):
            done = subprocess.run([script, path, "50", out, "3", *options], capture_output=True, text=True, timeout=HANG, env=environment)
            self.assertIn(done.returncode, (0, 1), done.stderr)  # 1: of the merge, since a requirement failed
        self.assertEqual(len(list(self.folder.glob("the result.part*"))), 3)
        self.run_campaign(path, "alone", code=1)
        for table in ("samples.csv", "samples.parquet"):
            if (out / table).exists():  # without Node.js there is no Parquet
                self.assertEqual((out / table).read_bytes(), (self.folder / "alone" / table).read_bytes())
        self.assertEqual(call(script).returncode, 2)
        return done

    def test_the_slurm_script_gives_the_table_of_one_campaign(self):
        # A simulated Slurm that runs a job at once, its tasks one after the other.
        sbatch = """#!/bin/bash
echo "$@" >>"$FOLDER/sbatch.txt"
first=0 last=0
while [[ $1 == --* ]]; do
  case $1 in --array=*) range=${1#--array=}; first=${range%-*}; last=${range#*-} ;; esac
  shift
done
cp "$1" "$FOLDER/spooled"  # as Slurm does
for ((k = first; k <= last; ++k)); do
  SLURM_ARRAY_TASK_ID=$k SLURM_CPUS_PER_TASK=2 bash "$FOLDER/spooled" "${@:2}" >>"$FOLDER/jobs.txt" 2>&1 || echo "failed: $?" >>"$FOLDER/jobs.txt"
done
echo "4711;cluster"
"""
        self.check_script("slurm-array", "--partition=long", stubs={"sbatch": sbatch}, times=2)  # then nothing is missing
        submitted = (self.folder / "sbatch.txt").read_text().splitlines()
        self.assertEqual(len(submitted), 4)
        self.assertIn("--array=0-2 --partition=long", submitted[0])
        self.assertIn("--dependency=afterany:4711 ", submitted[1])
        self.assertEqual((self.folder / "jobs.txt").read_text().count("failed: "), 2)  # the merges: a requirement failed

    def test_the_gnu_parallel_script_gives_the_table_of_one_campaign(self):
        # Without GNU parallel its lines run one after the other.
        parallel = """#!/bin/bash
while read -r one two three; do
  command=${@: -1}
  command=${command//"{1}"/$one} command=${command//"{2}"/$two}
  bash -c "${command//"{3}"/$three}" </dev/null || failed=1
done
exit ${failed:-0}
"""
        installed = shutil.which("parallel")
        genuine = installed is not None and "GNU parallel" in call(installed, "--version").stdout
        self.check_script("gnu-parallel", "--jobs", "2", stubs={} if genuine else {"parallel": parallel})


if __name__ == "__main__":
    main()
