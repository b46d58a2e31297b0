#!/usr/bin/env python3
"""Facts about the page of `unlatch report`, in a real browser without a network:

    report_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import base64
import json
import math
import re
import sys
from array import array
from pathlib import Path

from browser import CHROMIUM, Browser
from processes import BOOSTERS, PATIENT, REFERENCE, SCENARIOS, UNLATCH, ProcessTest, main

MOST_BYTES = 5_000_000  # limit for a page of 10 s at 1 kHz
# Positions are stored in single precision relative to the first body, at most 60 m away here: half a unit of its last place.
SINGLE = 60 * 2.0**-24
SAMPLES = [0, 0.25, 0.731, 1.5, 2]  # s; the recording's frames are every tick
HOSTILE = "</script><script>window.struck = 1</script><!-- <img src=x onerror='window.struck = 2'>"


def read_document(page):
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.DOTALL).group(1)
    return json.loads(text)


class ReportTest(ProcessTest):
    """One browser for all facts; each opens its own pages."""

    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def record(self, name, *arguments, code=0):
        log = self.folder / f"{name}.log"
        self.run_ok(UNLATCH, *arguments, "--log", log, code=code)
        return log

    def build(self, *logs, code=0):
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "report", *logs, "--out", page, code=code)
        return page

    def open(self, *logs):
        self.browser.open(self.build(*logs))
        self.assert_silent()

    def assert_silent(self):
        self.assertEqual(self.browser.complaints, [])
        self.assertEqual([url for url in self.browser.requests if not url.startswith(("file:", "data:"))], [])

    def ask(self, expression):
        return self.browser.evaluate(expression)

    def set_slider(self, share):
        self.ask("(() => { const slider = document.querySelector('input.time'); slider.value = %r;"
                 " slider.dispatchEvent(new Event('input')); })()" % share)
        self.browser.settle()

    def read_picture(self):
        """Returns colours in the picture, and a number that changes with it."""
        return self.ask("""(() => {
            const gl = unlatchReport.stage.canvas.getContext('webgl2'), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
            const pixels = new Uint32Array(w * h);
            gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
            return { colours: new Set(pixels).size, sum: pixels.reduce((sum, pixel, i) => (sum * 31 + pixel) % 1000003, 7) };
        })()""")

    # --- The verdict ----------------------------------------------------------------------------------------------

    def test_the_verdict_stands_on_top_and_its_limits_are_in_the_plots(self):
        text = Path(REFERENCE).read_text()
        scenario = self.folder / "judged.yaml"
        scenario.write_text(text.replace("requirements: ", "requirements:\n  - {id: far, text: " + json.dumps(HOSTILE) +
                                         ", clearance: [core, booster1], at_least: 1.5}  #", 1))
        log = self.folder / "judged.log"
        result = self.run_json(UNLATCH, "run", scenario, "--log", log, code=1)
        self.assertEqual([entry["id"] for entry in result["verdict"] if not entry["met"]], ["far"])
        self.open(log)
        self.assertEqual(self.ask("document.getElementById('results').firstElementChild.id"), "verdict")
        rows = self.ask("[...document.querySelectorAll('#verdict tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")
        self.assertEqual([row[:2] for row in rows], [[entry["id"], "met" if entry["met"] else "not met"] for entry in result["verdict"]])
        self.assertIn("1.31941 m", rows[0][2])
        self.assertEqual(rows[0][3], "at least 1.5 m")
        self.assertIn(HOSTILE, rows[0][6])
        self.assertIn("1 of 5 not met", self.ask("document.querySelector('#verdict small').textContent"))
        limits = self.ask("unlatchReport.plots.cards.find((card) => card.group.title === 'Clearances').limits")
        self.assertEqual([(limit["id"], limit["value"], limit["met"]) for limit in limits],
                         [("far", 1.5, False), ("distance1, distance2, distance3, distance4", 1, True)])
        self.assertEqual(self.ask("window.struck"), None)
        own = "unlatchReport.plots.cards.find((card) => card.group.title === 'Quantities required')"
        self.assertEqual(self.ask(own + ".group.choices.map((choice) => choice.name)")[0], "far")
        self.assertEqual(self.ask(own + ".limits"), [{"id": "far", "value": 1.5, "met": False}])
        separations = self.ask("[...document.querySelectorAll('h2')].some((title) => title.textContent === 'Separations')")
        self.assertTrue(separations)

    # --- One run --------------------------------------------------------------------------------------------------

    def test_the_slider_moves_the_bodies_to_where_the_run_had_them(self):
        log = self.record("run", "run", REFERENCE)
        truth = self.run_json(UNLATCH, "run", REFERENCE, "--sample", ",".join(map(str, SAMPLES)))
        self.open(log)
        pictures = []
        for sample in truth["samples"]:
            self.set_slider(sample["t"] / 2)
            self.assertAlmostEqual(self.ask("unlatchReport.clock.t"), sample["t"], delta=1e-12)
            core = sample["bodies"]["core"]["p"]
            shown = self.ask("unlatchReport.stage.actors[0].poses.map(({ p }) => [p.x, p.y, p.z])")
            for i, (name, body) in enumerate(sample["bodies"].items()):
                page = self.ask(f"unlatchReport.getPosition({json.dumps(name)}, {sample['t']})")
                for k in range(3):
                    self.assertAlmostEqual(page[k], body["p"][k], delta=SINGLE)
                    self.assertAlmostEqual(shown[i][k], body["p"][k] - core[k], delta=SINGLE)
            pictures.append(self.read_picture())
        self.assertGreater(min(picture["colours"] for picture in pictures), 100, "a blank or nearly blank picture")
        self.assertEqual(len({picture["sum"] for picture in pictures}), len(pictures), "the picture did not change")
        self.assert_silent()

    def test_a_click_on_a_plot_an_event_or_a_key_sets_the_one_time(self):
        log = self.record("run", "run", REFERENCE)
        events = self.run_json(UNLATCH, "replay", log)["events"]
        self.open(log)
        titles = self.ask("[...document.querySelectorAll('.card h2')].map((node) => node.textContent)")
        for title in ("Clearances", "Reaction forces", "Reaction moments", "Angular rates", "Position from core",
                      "Thrusts and forces", "Timing", "Separations", "Peak reactions"):
            self.assertIn(title, titles)
        curves = self.ask("unlatchReport.plots.cards.map((card) => card.plot.series.length - 1)")
        self.assertGreater(min(curves), 0)
        self.browser.click(".card .u-over", x=0.25)
        t = self.ask("unlatchReport.clock.t")
        # The axis ends with the run, and a pixel of the plot is less than 1 % of it.
        self.assertAlmostEqual(t, 0.5, delta=0.02)
        cursors = self.ask("unlatchReport.plots.cards.filter((card) => card.visible).map((card) => card.plot.cursor.left)")
        self.assertGreater(len(cursors), 1)
        self.assertLess(max(cursors) - min(cursors), 1.5, "one cursor in all plots, to a pixel")
        self.browser.click(".events button:nth-child(3)")
        self.assertEqual(self.ask("unlatchReport.clock.t"), events[2]["t"])
        self.browser.press("Home")
        self.browser.press("ArrowRight")
        self.assertAlmostEqual(self.ask("unlatchReport.clock.t"), 0.001, delta=1e-12)
        self.browser.press("ArrowRight", shift=True)
        self.assertEqual(self.ask("unlatchReport.clock.t"), events[0]["t"])
        self.browser.press(" ")
        self.browser.wait_for(f"unlatchReport.clock.t > {events[0]['t']}")
        self.assertTrue(self.ask("unlatchReport.clock.playing"))
        self.browser.press(" ")
        self.assertFalse(self.ask("unlatchReport.clock.playing"))
        self.assert_silent()

    def build_many(self):
        """A satellite on three springs with 24 masses welded to it, the last the heaviest; the springs push for a second."""
        self.run_ok(UNLATCH, "init", self.folder / "first")
        template = ("    bodies:\n      mass<i>: {mass: <i> * <i> kg, inertia: [1, 1, 1], position: [2.5 m, <i>*1 m - 12 m, 0]}\n"
                    "    joints:\n      bolt<i>:\n        between: [satellite, mass<i>]\n        point: [0.9 m, <i>*1 m - 12 m, 0]\n"
                    "        modes: {held: {kind: weld}}\n        mode: held\n    elements:\n")
        text = (self.folder / "first.yaml").read_text().replace("    elements:\n", template, 1).replace("count: 3}", "count: 24}")
        many = self.folder / "many.yaml"
        many.write_text(text)
        return self.record("many", "run", many, "--until", "2")

    def get_card(self, title):
        return f"unlatchReport.plots.cards.find((card) => card.group.title === '{title}')"

    def test_the_largest_of_many_curves_are_drawn_and_the_others_reported(self):
        self.open(self.build_many())
        card = self.get_card("Reaction forces")
        shown = self.ask(f"{card}.plot.series.slice(1).filter((series) => series.show).map((series) => series.label)")
        self.assertEqual(len(shown), 12)
        self.assertIn("bolt24", shown)
        self.assertNotIn("bolt1", shown)
        self.assertIn("12 of 25 curves are drawn, those with the largest values", self.ask(f"{card}.left.textContent"))
        peaks = "[...document.querySelectorAll('.card')].find((card) => card.querySelector('h2').textContent === 'Peak reactions')"
        self.assertIn("… and 23 more of bolt#", self.ask(f"{peaks}.textContent"))
        rows = f"[...{peaks}.querySelectorAll('tbody tr')].filter((row) => !row.hidden).map((row) => row.cells[0].textContent)"
        clamp, bolt, rest = self.ask(rows)
        self.assertEqual((clamp, rest), ("clamp", "… and 23 more of bolt#"))
        self.assertIn(bolt, shown)
        self.ask(f"{peaks}.querySelector('.more button').click()")
        self.assertEqual(len(self.ask(rows)), 25)
        self.assert_silent()

    def choose(self, title, choice):
        """Shows one of a card's quantities; returns the limits of its axis."""
        card = self.get_card(title)
        self.ask(f"(() => {{ const card = {card}; card.choice = card.group.choices.find((one) => one.name === '{choice}');"
                 " unlatchReport.plots.paintCard(card); })()")
        return self.ask(f"[{card}.plot.scales.y.min, {card}.plot.scales.y.max]")

    def test_rounding_noise_does_not_fill_an_axis(self):
        self.open(self.build_many())
        low, high = self.choose("Reaction forces", "z")
        self.assertGreater(high - low, 1e-4)  # N, of kilonewtons; the rounding is of 1e-12 N
        _, largest = self.choose("Reaction moments", "|M|")
        for row in ("rot_x", "rot_y", "rot_z"):
            low, high = self.choose("Reaction moments", row)
            self.assertGreater(high - low, 1e-6 * largest)
        self.assert_silent()

    def test_sizes_of_reactions_are_those_of_their_rows(self):
        flight = ["run", SCENARIOS / "boosters/cyclogram.yaml", "--until", "4"]
        log = self.record("run", *flight)
        truth = self.run_json(UNLATCH, *flight, "--sample", ",".join(map(str, SAMPLES)))
        self.open(log)
        largest = {}
        for title, size, rows in (("Reaction forces", "|F|", ("x", "y", "z")), ("Reaction moments", "|M|", ("rot_x", "rot_y", "rot_z"))):
            choice = f"{self.get_card(title)}.group.choices[0]"
            self.assertEqual(self.ask(f"{choice}.name"), size)
            for sample in truth["samples"]:
                frame = f"run.find({sample['t']}).index"
                shown = self.ask(f"(() => {{ const run = unlatchReport.plots.runs[0];"
                                 f" return {choice}.build(run).map((curve) => [curve.name, curve.values[{frame}]]); }})()")
                for joint, value in shown:
                    reaction = sample["reactions"][joint]
                    own = [force for row, force in zip(reaction["rows"], reaction["lambda"]) if row in rows]
                    self.assertAlmostEqual(value, math.hypot(*own), delta=1e-6 * max(1, math.hypot(*reaction["lambda"])), msg=(title, joint))
                    largest[title] = max(value, largest.get(title, 0))
        self.assertGreater(min(largest.values()), 1000)  # N, N m

    def test_labels_of_an_axis_do_not_run_over_its_unit(self):
        """In every plot, for every choice, and whatever the length of the labels."""
        self.open(self.record("run", "run", REFERENCE))
        widths = self.ask("""(async () => {
            const widths = [], drawn = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
            const measure = ({ ctx }, text) => {
              ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
              return ctx.measureText(text).width / devicePixelRatio;
            };
            const add = (card, texts, size) => {
              const axis = card.plot.axes[1];
              widths.push([card.group.title, card.choice.name, Math.max(0, ...texts.map((text) => measure(card.plot, text))), size - axis.ticks.size - axis.gap]);
            };
            for (const card of unlatchReport.plots.cards) {
              for (const choice of card.group.choices) {
                card.choice = choice;
                card.fresh = true;
                unlatchReport.plots.paintCard(card);
                for (const span of [1.5, 0.002]) {
                  card.plot.setScale('x', { min: 0.3, max: 0.3 + span });
                  await drawn();
                  const axis = card.plot.axes[1];
                  add(card, axis._values ?? [], axis._size);
                }
              }
            }
            const [card] = unlatchReport.plots.cards, axis = card.plot.axes[1];
            for (let digits = 1; digits < 16; digits += 1) {
              const texts = ['−' + '8'.repeat(digits)];
              add(card, texts, axis.size(card.plot, texts, 1, 0));
            }
            return widths;
        })()""")
        for title, choice, text, place in widths:
            self.assertLessEqual(text, place, (title, choice))
        self.assertGreater(max(text for _, _, text, _ in widths), 80)  # px: wider than any axis need be for most
        self.assert_silent()

    def test_springs_have_forces_and_strokes_and_are_drawn_while_they_push(self):
        self.run_ok(UNLATCH, "init", self.folder / "first")
        self.open(self.record("first", "run", self.folder / "first.yaml"))
        card = self.get_card("Springs")
        self.assertEqual(self.ask(f"{card}.group.choices.map((choice) => choice.name)"), ["force", "stroke", "length"])
        force = self.ask(f"Array.from({card}.plot.data[1])")
        self.assertAlmostEqual(force[0], 2000 * 0.1, delta=1e-3)  # 2 kN/m, 0.1 m compressed, to single precision
        self.assertEqual(force[-1], 0)
        self.ask("unlatchReport.clock.set(0.5)")
        self.browser.settle()
        lines = "unlatchReport.stage.actors[0].springs.map((line) => line.visible)"
        self.assertEqual(self.ask(lines), [True] * 3)
        self.ask("unlatchReport.clock.set(4.5)")
        self.browser.settle()
        self.assertEqual(self.ask(lines), [False] * 3)
        stroke = f"Array.from({card}.group.choices[1].build(unlatchReport.plots.runs[0])[0].values)"
        values = [value for value in self.ask(f"{stroke}.map((value) => (Number.isNaN(value) ? null : value))") if value is not None]
        self.assertLess(max(values), 0.1 + 1e-6)  # m: up to the free length, where the force ends
        self.assertGreater(max(values), 0.09)
        self.assert_silent()

    def test_contacts_have_a_table_and_curves(self):
        self.open(self.record("strike", "run", SCENARIOS / "boosters/recontact.yaml", code=1))
        table = "[...document.querySelectorAll('.card')].find((card) => card.querySelector('small')?.textContent.startsWith('those that touch'))"
        self.assertIn("2.5552", self.ask(f"{table}.textContent"))
        card = self.get_card("Contacts")
        self.assertEqual(self.ask(f"{card}.group.choices.map((choice) => choice.name)"), ["normal force", "friction", "depth", "slip speed"])
        peak = self.ask(f"Math.max(...{card}.group.choices[0].build(unlatchReport.plots.runs[0])[0].values)")
        self.assertGreater(peak, 0.9 * 39966)  # N; the peak itself is located inside a step
        self.assertLess(peak, 1.000001 * 39967)
        self.assert_silent()

    def test_pushers_have_forces_and_are_drawn_while_they_push(self):
        self.open(self.record("stage", "run", SCENARIOS / "interstage/scenario.yaml"))
        card = self.get_card("Pushers, stops and cords")
        self.assertIn("force", self.ask(f"{card}.group.choices.map((choice) => choice.name)"))
        lines = "unlatchReport.stage.actors[0].pushers.map((pusher) => pusher.line.visible)"
        first, last = self.ask("[unlatchReport.clock.first, unlatchReport.clock.last]")
        self.ask(f"unlatchReport.clock.set({first})")
        self.browser.settle()
        self.assertGreaterEqual(self.ask(lines).count(True), 6)
        self.ask(f"unlatchReport.clock.set({last})")
        self.browser.settle()
        self.assertEqual(self.ask(lines).count(True), 0)
        self.assert_silent()

    def test_the_nearest_approach_has_a_view_of_its_own(self):
        self.open(self.record("run", "run", SCENARIOS / "boosters/cyclogram.yaml", "--until", "4"))
        card = self.get_card("Clearances")
        self.assertIn("the smallest 0.2944 m at 1.2991 s", self.ask(f"{card}.group.note"))
        self.ask(f"(() => {{ const card = {card}; card.choice = card.group.choices[1]; card.fresh = true; unlatchReport.plots.paintCard(card); }})()")
        self.assertEqual(self.ask(f"{card}.choice.name"), "nearest approach")
        self.assertLess(self.ask(f"{card}.plot.scales.y.max"), 2)
        self.assert_silent()

    def test_curves_that_lie_on_one_another_and_those_of_two_runs_are_distinguished(self):
        logs = [self.record(name, "run", SCENARIOS / "boosters/cyclogram.yaml", "--set", f"bodies.core.mass={mass}")
                for name, mass in (("a", 98500), ("b", 99000))]
        self.open(*logs)
        card = self.get_card("Reaction forces")
        strokes = self.ask(f"{card}.plot.series.slice(1).map((series) => series.stroke())")
        self.assertEqual(len(set(strokes)), len(strokes), "each curve of each run has a colour of its own")
        dashes = self.ask(f"{card}.plot.series.slice(1, 5).map((series) => JSON.stringify(series.dash))")
        self.assertEqual(len(set(dashes)), 4, "the four nodes bear the same: their colours take turns")

    def test_a_telephone_shows_every_column_and_a_slider_that_can_be_used(self):
        self.open(self.record("run", "run", REFERENCE))
        size = {"deviceScaleFactor": 1, "mobile": False}
        self.browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, **size)
        try:
            self.browser.settle()
            self.assertGreater(self.ask("document.querySelector('input.time').clientWidth"), 250)
            self.assertLessEqual(self.ask("document.documentElement.scrollWidth"), 390)
            for selector in (".events", ".list .scroll"):
                self.assertLessEqual(self.ask(f"(() => {{ const n = document.querySelector('{selector}'); return n.scrollWidth - n.clientWidth; }})()"), 0, selector)
        finally:
            self.browser.call("Emulation.setDeviceMetricsOverride", width=1600, height=1000, **size)

    def test_a_run_in_the_loop_shows_its_timing_and_faults(self):
        faults = SCENARIOS / "boosters/faults/jammed-nozzle.yaml"
        log = self.record("loop", "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--faults", faults, *PATIENT, code=1)  # a distance is not kept
        replayed = self.run_json(UNLATCH, "replay", log, code=1)
        self.open(log)
        text = self.ask("document.querySelector('#timing').innerText")
        for part in ("step", "state out, answer in", "p99.9", "overruns 0"):
            self.assertIn(part, text)
        kinds = self.ask("[...document.querySelectorAll('.row')].map((row) => row.className)")
        self.assertEqual(len(kinds), len(replayed["events"]) + len(replayed["notices"]))
        self.assertTrue(any("fault" in kind for kind in kinds))
        self.assertGreater(self.ask("unlatchReport.runs[0].points.length"), 0)
        self.assertIn("Commands", self.ask("document.querySelector('.plots').innerText"))

    def test_what_does_not_replay_as_recorded_is_said(self):
        log = self.record("cut", "run", REFERENCE)
        log.write_bytes(log.read_bytes()[:60_000])
        page = self.build(log)
        self.browser.open(page)
        self.assertIn("not complete", self.ask("document.querySelector('.banner').textContent"))
        self.assertEqual(self.ask("document.querySelector('.status').textContent"), "… truncated")
        self.assert_silent()

    # --- Two runs -------------------------------------------------------------------------------------------------

    def test_two_runs_lie_over_each_other_and_their_first_difference_is_named(self):
        log = self.record("good", "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", *PATIENT)
        faults = SCENARIOS / "boosters/faults/jammed-nozzle.yaml"
        other = self.record("bad", "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--faults", faults, *PATIENT, code=1)  # a distance is not kept
        diff = self.run_json(UNLATCH, "diff", log, other, code=1)
        self.open(log, other)
        banner = self.ask("document.querySelector('.banner').textContent")
        self.assertIn(f"first differ at tick {diff['difference']['tick']},", banner)
        self.assertEqual(self.ask("unlatchReport.stage.actors.length"), 2)
        names = self.ask("unlatchReport.plots.cards[0].plot.series.slice(1).map((series) => series.label)")
        self.assertEqual([name[2:] for name in names if name[0] == "A"], [name[2:] for name in names if name[0] == "B"])
        ends = self.ask("unlatchReport.runs.map((run, r) => unlatchReport.getPosition('booster1', run.last, r))")
        self.assertNotEqual(ends[0], ends[1])
        self.assert_silent()

    def test_runs_of_two_models_are_shown_with_the_reason_why_they_are_not_compared(self):
        log = self.record("good", "run", REFERENCE)
        other = self.record("dead", "run", REFERENCE, "--set", "events.contact:booster1.enabled=false")
        self.open(log, other)
        text = self.ask("document.querySelector('header').innerText")
        self.assertIn("different models", text)
        self.assertIn("B: booster1 stayed on core", text)

    # --- The file -------------------------------------------------------------------------------------------------

    def test_texts_of_a_scenario_stay_texts(self):
        scenario = self.folder / "hostile <img src=x onerror='window.struck = 3'>.yaml"
        text = Path(REFERENCE).read_text()
        title = next(line for line in text.splitlines() if line.startswith("title:"))
        scenario.write_text(text.replace(title, "title: " + json.dumps(HOSTILE)) + f"\n# {HOSTILE} %UNLATCH_DATA%\n")
        log = self.record("<b>run", "run", scenario, "--until", "0.1")
        self.open(log)
        self.assertIsNone(self.ask("window.struck ?? null"))
        self.assertEqual(self.ask("document.querySelector('.title').textContent"), HOSTILE)
        self.assertEqual(self.ask("document.scripts.length"), 2)
        self.assertEqual(self.ask("document.images.length"), 0)
        self.assertIn(HOSTILE, self.ask("[...document.querySelectorAll('details.text pre')].map((pre) => pre.textContent).join()"))
        # Even an injected script would not run.
        self.assertIsNone(self.ask("(() => { const script = document.createElement('script'); script.textContent = 'window.struck = 4';"
                                   " document.body.append(script); return window.struck ?? null; })()"))
        self.assertIn("Content Security Policy", " ".join(self.browser.complaints))

    def test_ten_seconds_at_1_khz_stay_below_5_mb_one_run_or_two(self):
        log = self.record("long", "run", REFERENCE, "--until", "10")
        for logs in ((log,), (log, log)):
            page = self.build(*logs)
            self.assertLess(page.stat().st_size, MOST_BYTES)
            for run in read_document(page)["runs"]:
                frames = run["frames"]
                self.assertEqual(frames["seen"], 10_001)
                self.assertGreater(frames["count"], 500)
                # Stored ticks: every n-th, the first, the last, and all near events.
                ticks = array("d", base64.b64decode(frames["ticks"])).tolist()
                self.assertEqual(len(ticks), frames["count"])
                self.assertEqual(ticks, sorted(set(ticks)))
                self.assertTrue(set(range(0, 10_001, frames["every"])) | {10_000} <= set(ticks))
                for event in run["events"]:
                    after = int(event["t"] / run["dt"]) + 1  # the tick at the end of its step
                    near = set(range(after - frames["around"] + 1, after + frames["around"]))
                    self.assertTrue(near <= set(ticks), event)

    def test_bodies_without_shapes_and_with_modal_coordinates_are_shown(self):
        page = self.build(self.record("tree", "run", SCENARIOS / "tree3/reference.yaml", "--until", "0.5"))
        document = read_document(page)
        run = document["runs"][0]
        self.assertTrue(all(body["assumed"] for body in run["structure"]["bodies"]))
        self.browser.open(page)
        self.assert_silent()
        self.assertGreater(self.read_picture()["colours"], 20)
        # A body with two modal coordinates.
        width, frames = len(run["frames"]["first"]), run["frames"]
        body = run["structure"]["bodies"][0]
        body.update(modal=2, modal_column=width)
        frames["first"] += [0.25, -0.5]
        text = page.read_text()
        begin = text.index('id="data">') + len('id="data">')
        page.write_text(text[:begin] + json.dumps(document).replace("<", "\\u003c") + text[text.index("</script>", begin):])
        self.browser.open(page)
        self.assert_silent()
        card = "unlatchReport.plots.cards.find((card) => card.group.title === 'Modal coordinates')"
        self.assertEqual(self.ask(f"{card}.plot.data.slice(1).map((values) => values[0])"), [0.25, -0.5])

    def test_without_webgl_everything_but_the_picture_is_there(self):
        page = self.build(self.record("run", "run", REFERENCE, "--until", "0.5"))
        with Browser(flags=["--disable-3d-apis"]) as browser:
            browser.open(page)
            self.assertIn("WebGL", browser.evaluate("document.querySelector('.view').textContent"))
            self.assertGreater(browser.evaluate("document.querySelectorAll('.uplot').length"), 5)
            browser.press("End")
            self.assertEqual(browser.evaluate("unlatchReport.clock.t"), 0.5)

    def test_wrong_use_is_refused_and_harms_no_recording(self):
        log = self.record("run", "run", REFERENCE, "--until", "0.01")
        before = log.read_bytes()
        for arguments in (["report", log], ["report", "--out", self.folder / "x.html"], ["report", log, "--out", log],
                          ["report", self.folder / "missing.log", "--out", self.folder / "x.html"],
                          ["report", log, log, log, "--out", self.folder / "x.html"]):
            result = self.run_ok(UNLATCH, *arguments, code=2)
            self.assertNotEqual(result.stderr.strip(), "")
        self.run_ok(UNLATCH, "report", log, "--out", self.folder / "no/such/folder.html", code=3)
        self.assertEqual(log.read_bytes(), before)
        self.assertFalse((self.folder / "x.html").exists())
        self.assertIn("Example", self.run_ok(UNLATCH, "report", "--help").stdout)


if __name__ == "__main__":
    if CHROMIUM is None:
        print("skipped: no chromium; tools/setup test installs it")
        sys.exit(77)
    main()
