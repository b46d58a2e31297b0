#!/usr/bin/env python3
"""Facts about `unlatch campaign`: the same table for any jobs, order and interruption; samples that run again to the bit;
distributions and statistics against OpenTURNS.

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
from processes import BIN, HANG, SANITIZED, SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

CAMPAIGN = SCENARIOS / "boosters" / "campaign.yaml"
# Scenario of a mass that falls for 5 steps: a sample takes no time. v: speed at the end, 0.05 s · 9.81 m/s2 + start.
BALL = """unlatch: 1
name: ball
step: {dt: 0.01, until: 0.05}
gravity: {uniform: [-9.81, 0, 0]}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], velocity: [0, 0, 0]}
  base: {mass: 1000, inertia: [9, 9, 9]}
requirements:
  - {id: fast, text: it is slow, velocity: {body: ball, relative_to: base}, at_most: 2.5}
"""


def read_table(folder):
    with open(folder / "samples.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class CampaignTest(ProcessTest):
    def write(self, rest, name="c.yaml"):
        (self.folder / "ball.yaml").write_text(BALL)
        path = self.folder / name
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\n" + rest)
        return path

    def run_campaign(self, path, out, *options, code=0):
        done = call(UNLATCH, "campaign", path, "--out", self.folder / out, "--json", "-", *options)
        self.assertIn(done.returncode, (code,) if isinstance(code, int) else code, done.stderr)
        return json.loads(done.stdout)

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

    CURVED = ("samples: 40\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 1 m/s}}\n"
              "outputs: [{of: ball.velocity}, {of: ball.vx, take: max}]\ncurves: [{of: [ball.vx, base.vx], every: 20 ms}]\n")

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

    def test_the_page_shows_curves_as_bands(self):
        self.run_campaign(self.write(self.CURVED), "out")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('curves').hidden"), False)
            self.assertEqual(ask("document.querySelectorAll('#curve option').length"), 2)
            widest, dark = browser.find_layers("bands", "all") + browser.find_layers("bands", "most")
            (median,) = browser.find_layers("bands", "median")
            self.assertEqual(median["x"], [0, 0.02, 0.04])
            for k, value in enumerate(median["y"]):
                order = [widest["low"][k], dark["low"][k], value, dark["high"][k], widest["high"][k]]
                self.assertEqual(order, sorted(order))
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].filter((o) => o.textContent.startsWith('curve.')).length"), 0)
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].filter((o) => o.textContent.startsWith('output.')).length"), 4)
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].at(-1).textContent"), "v [m/s]")
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

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

    # The speed of the ball is that of its start: two perpendicular normal numbers, so that P(speed > 2.5 m/s) is known: 1 - Φ for
    # one axis, exp(-r²/2) for a circle. Second oracle: OpenTURNS' SubsetSampling of the same function, an implementation with
    # another sampler (modified Metropolis) and other numbers, so estimates and the coefficients of variation that both tell are
    # compared, not bits.
    RARE = ("sampling: subset\nsamples: {samples}\nseed: {seed}\nsubset: {{of: {of}}}\nparameters:\n"
            "  x: {{path: 'bodies.ball.velocity[0]', normal: {{mean: {mean} m/s, sigma: {sigma} m/s}}}}\n"
            "  y: {{path: 'bodies.ball.velocity[1]', normal: {{mean: 0 m/s, sigma: {sigma_y} m/s}}}}\n")

    def write_rare(self, seed=1, samples=1000, of="fast", mean=0, sigma=2.5 / math.sqrt(-2 * math.log(1e-5)), sigma_y=None, name="rare.yaml"):
        return self.write(self.RARE.format(seed=seed, samples=samples, of=of, mean=mean, sigma=repr(sigma), sigma_y=repr(sigma if sigma_y is None else sigma_y)), name)

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

    def test_the_page_shows_the_campaign_in_a_browser_without_a_network(self):
        hostile = "</script><script>window.struck = 1</script>"
        path = self.write(f"title: \"{hostile}\"\nsamples: 200\nparameters:\n"
                          "  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n")
        summary = self.run_campaign(path, "out", code=1)
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "0")
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('title').textContent"), hostile)
            self.assertEqual(ask("document.querySelectorAll('#worst .flight').length"), 0)
            heads = ask("[...document.querySelectorAll('#verdict th')].map((cell) => cell.textContent)")
            cells = ask("[...document.querySelectorAll('#verdict td')].map((cell) => cell.textContent)")
            verdict = dict(zip(heads, cells, strict=True))
            self.assertEqual(verdict["missing"], "0")
            self.assertEqual(verdict["tolerance, 99 % / 95 %"], "needs 299 values")  # of 200
            # The histogram is of all samples.
            self.assertEqual(ask("unlatchReport.quantities[0].distribution.counts.reduce((a, b) => a + b)"), 200)
            self.assertEqual(ask("window.struck === undefined"), True)
            self.assertEqual(ask("document.querySelector('#verdict .bad').textContent"), str(summary["requirements"][0]["failed"]))
            self.assertGreater(len(browser.find_layers("histogram", "samples")[0]["y"]), 5)
            self.assertEqual(len(browser.find_layers("histogram", "limit") + browser.find_layers("cdf", "limit")), 2)
            met, failed = (browser.find_layers("scatter", name)[0] for name in ("met", "failed"))
            self.assertEqual((len(met["x"]) + len(failed["x"]), len(failed["x"])), (200, summary["requirements"][0]["failed"]))
            self.assertGreater(browser.count_pixels("scatter"), 200)  # points are drawn
            self.assertIn(f"--sample {summary['worst'][0]} --log", ask("document.querySelector('#worst code').textContent"))
            self.assertEqual(ask("document.getElementById('rare').hidden"), True)
            browser.click_point("scatter", failed["x"][0], failed["y"][0])
            self.assertRegex(ask("document.getElementById('picked').textContent"), r"^Sample \d+: v ")
            # Another quantity: the input itself, which depends on nothing but itself.
            ask("(() => { const q = document.getElementById('quantity'); q.value = q.options.length - 1; q.dispatchEvent(new Event('change')); })()")
            self.assertEqual(browser.find_layers("histogram", "limit"), [])
            self.assertEqual(browser.complaints, [])
            self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:"))], [])
        finally:
            browser.close()

    def test_the_worst_samples_fly_in_pages_of_their_own(self):
        path = self.write("samples: 30\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n")
        quoted = "title=it's a ball; $HOME"  # in a shell
        summary = self.run_campaign(path, "out", "--set", "step.until=0.06", "--set", quoted, code=(0, 1))
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "2")
        hashes = {int(row["sample"]): row["hash"] for row in read_table(self.folder / "out")}
        browser = Browser()
        try:
            browser.open(page)
            self.assertEqual(browser.evaluate("document.querySelectorAll('#worst .flight').length"), 2)
            for sample in summary["worst"][:2]:
                self.assertEqual(browser.evaluate(f"unlatchReport.data.flights[{sample}]"), f"page-{sample}.html")
                self.assertIn(hashes[sample], (self.folder / f"page-{sample}.html").read_text())  # the same flight
            # The command that is shown, in a shell: with the overrides.
            command = browser.evaluate("document.querySelector('#worst code').textContent")
            subprocess.run(["bash", "-c", command], cwd=self.folder, timeout=HANG, capture_output=True,
                           env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"})
            worst = summary["worst"][0]
            self.assertIn(hashes[worst], (self.folder / f"{worst}.html").read_text())
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()
        self.assertEqual(sorted(p.name for p in self.folder.glob("page*")), sorted(["page.html", *(f"page-{s}.html" for s in summary["worst"][:2])]))
        # Ten by default.
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", self.folder / "ten.html")
        self.assertEqual(len(list(self.folder.glob("ten-*.html"))), 10)
        path.write_text(path.read_text() + "seed: 9\n")
        done = call(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "1")
        self.assertEqual(done.returncode, 3)
        self.assertIn("not the campaign file of these results any more", done.stderr)
        done = self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)  # not asked for: a note
        self.assertIn("not the campaign file of these results any more", done.stderr)

    def test_a_page_without_samples_says_so(self):
        path = self.write("samples: 4\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        self.run_campaign(path, "out", code=(0, 1))
        results = self.folder / "out/results.bin"
        results.write_bytes(results.read_bytes()[:32])  # the header
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)
        browser = Browser()
        try:
            browser.open(page)
            self.assertIn("no samples", browser.evaluate("document.getElementById('convergence').textContent"))
            self.assertEqual(browser.evaluate("window.unlatchReport !== undefined"), True)  # drawn to its end
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

    def test_the_page_shows_rare_failures(self):
        summary = self.run_campaign(self.write_rare(samples=200), "out")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "0")
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('rare').hidden"), False)
            text = ask("document.getElementById('rare-result').textContent")
            self.assertIn(f"{summary['rare']['failed_samples']} of them failed", text)
            levels = len(summary["rare"]["levels_run"])
            self.assertEqual(ask("document.querySelectorAll('#rare-levels tr').length"), levels + 1)
            self.assertEqual(len(browser.find_layers("rare-curve", "levels")[0]["x"]), levels)
            self.assertEqual(len(browser.find_layers("rare-curve", "curve")), 1)
            self.assertIn(f"--results {self.folder / 'out'} ", ask("document.querySelector('#worst code').textContent"))
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

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

    def test_flight_software_that_takes_no_part_is_told(self):
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
