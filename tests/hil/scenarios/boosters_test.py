#!/usr/bin/env python3
"""The boosters' cyclogram and its failures as users run them, against tests/references/boosters_reference.py (dense KKT, DOP853 at
1e-12) and against the sum of the forces. Run by ctest:

    boosters_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import csv
import importlib.util
import json
import math
import sys

from processes import FSW, PATIENT, SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

sys.dont_write_bytecode = True  # nothing beside the scenarios
BOOSTERS = SCENARIOS / "boosters"
REFERENCE = json.loads((SOURCE / "tests/data/boosters_cyclogram.json").read_text())
ASCENT = json.loads((SOURCE / "tests/data/boosters_ascent.json").read_text())
EVENT_TIME = 1e-6                                     # s, asked for at 1 ms
STATE = {"p": 1e-5, "q": 1e-6, "v": 1e-5, "w": 1e-7}  # 1e-6 of 10 m, 1, 10 m/s, 0.1 rad/s
ASCENT_TIME = 1e-9                                    # s
ASCENT_STATE = {"p": 1e-8, "q": 1e-9, "v": 1e-8, "w": 5e-10}  # 1e-9 of the motion beside the core: 10 m, 1, 10 m/s, 0.5 rad/s
AIR_TABLE = [[0.666, 0.789, 6.166], [0.636, 0.636, 6.309], [0.633, 0.764, 4.838]]  # README.md: release, liftoff, distance at 2 s
ROUND_OFF = 1e-9                                      # m/s, rad/s
FULL, TILT, MASS = 300000 / 0.84, 0.087, 98500 + 4 * 4380


class BoostersTest(ProcessTest):
    def run_at(self, file, times, *overrides, code=0):
        return self.run_json(UNLATCH, "run", BOOSTERS / file, "--sample", ",".join(map(str, times)), *overrides, code=code)

    def compare(self, name, file, *overrides, missed=()):
        """Compares a run with the reference. `missed`: requirements that this run does not meet."""
        times = sorted(map(float, REFERENCE[name]["samples"]))
        report = self.run_at(file, times, *overrides, code=1 if missed else 0)
        return self.compare_report(name, report, missed)

    def compare_report(self, name, report, missed):
        return self.compare_with(REFERENCE[name], name, report, missed, EVENT_TIME, STATE)

    def compare_with(self, reference, name, report, missed, time_tolerance, tolerances):
        states = {float(t): bodies for t, bodies in reference["samples"].items()}
        self.assertEqual([entry["id"] for entry in report["verdict"] if not entry["met"]], list(missed))
        self.assertEqual(report["status"], "ok")
        found = {(e["name"], e["subject"]): e["t"] for e in report["events"]
                 if e["name"] in ("release", "contact", "liftoff")}
        wanted = {(event, f"booster{k}"): t for t, event, k in reference["events"]}
        self.assertEqual(sorted(found), sorted(wanted))  # no other joint opened
        worst_time = max(abs(found[key] - wanted[key]) for key in wanted)
        self.assertLess(worst_time, time_tolerance)
        worst = dict.fromkeys(STATE, 0)
        for sample in report["samples"]:
            for body, state in zip(sample["bodies"].values(), states[round(sample["t"], 9)], strict=True):
                sign = math.copysign(1, sum(a * b for a, b in zip(body["q"], state[3:7])))
                for key, part, factor in (("p", state[:3], 1), ("q", state[3:7], sign), ("v", state[7:10], 1),
                                          ("w", state[10:], 1)):
                    worst[key] = max([worst[key], *(abs(factor * a - b) for a, b in zip(body[key], part, strict=True))])
        for key, tolerance in tolerances.items():
            self.assertLess(worst[key], tolerance, key)
        print(f"{name}: events {worst_time:.1e} s, {worst['p']:.1e} m, {worst['q']:.1e}, {worst['w']:.1e} rad/s",
              file=sys.stderr)
        return report

    def test_the_cyclogram_goes_as_the_reference_does(self):
        self.compare("cyclogram", "cyclogram.yaml")

    def test_a_late_valve_lets_its_nose_go_late(self):
        report = self.compare("late-valve", "late-valve.yaml")
        times = {e["subject"]: e["t"] for e in report["events"] if e["name"] == "liftoff"}
        self.assertGreater(times["booster1"], times["booster2"] + 0.3)

    def test_a_booster_whose_ties_hold_stays_and_turns_the_core(self):
        report = self.compare("uncut-tie", "uncut-tie.yaml", missed=["leaves2"])
        self.assertEqual(report["joints"]["nose2"], "tied")
        self.assertGreater(math.hypot(*report["samples"][-1]["bodies"]["core"]["w"]), 1e-4)

    def test_unequal_engines_let_go_at_unequal_times(self):
        self.compare("imbalance", "imbalance.yaml")

    def test_a_dead_nozzle_keeps_its_nose_as_long_as_the_reference_says(self):
        self.compare("dead-nozzle", "cyclogram.yaml", "--set", "events.nozzle:booster1.enabled=false", missed=["distance1"])

    def test_nozzles_of_both_tanks_go_as_the_reference_does(self):
        self.compare("both-nozzles", "both-nozzles.yaml")

    def test_the_fuel_tanks_nozzle_alone_takes_the_booster_away(self):
        shut = ("--set", "events.nozzle:booster1.enabled=false")
        report = self.compare("oxidizer-shut", "both-nozzles.yaml", *shut)
        both = self.compare("both-shut", "both-nozzles.yaml", *shut, "--set", "events.fuel_nozzle:booster1.enabled=false",
                            missed=["distance1"])
        liftoffs = [next(e["t"] for e in run["events"] if (e["name"], e["subject"]) == ("liftoff", "booster1"))
                    for run in (report, both)]
        self.assertLess(liftoffs[0], liftoffs[1] - 0.3)

    def test_the_oxidizer_tanks_nozzle_alone_takes_the_booster_away(self):
        self.compare("fuel-shut", "both-nozzles.yaml", "--set", "events.fuel_nozzle:booster1.enabled=false")

    # --- In air ---------------------------------------------------------------------------------------------------

    # tests/references/ascent_reference.py: the Earth's field and air, tables by SciPy's splines.
    def test_the_separation_in_air_goes_as_its_reference_does(self):
        report = self.run_at("ascent.yaml", sorted(map(float, ASCENT["samples"])))
        self.compare_with(ASCENT, "ascent", report, (), ASCENT_TIME, ASCENT_STATE)

    def test_the_air_changes_the_separation_as_the_readme_says(self):
        found = {}
        for name, *options in (("ascent-vacuum",), ("ascent",), ("ascent", "--set", "tables.push.scale=0")):
            report = self.run_at(f"{name}.yaml", [2], *options, code=None)
            times = {e["name"]: e["t"] for e in report["events"] if e["subject"] == "booster1"}
            away = next(entry["value"] for entry in report["verdict"] if entry["id"] == "away1")
            found[name, *options] = times["release"], times["liftoff"], away
        self.assertEqual([[round(x, 3) for x in row] for row in found.values()], AIR_TABLE)

    def test_the_tables_are_those_that_their_script_writes(self):
        before = {name: (BOOSTERS / name).read_bytes() for name in ("ascent-free.csv", "ascent-near.csv")}
        script = self.folder / "make-ascent"
        script.write_bytes((BOOSTERS / "make-ascent").read_bytes())
        self.run_ok("/usr/bin/python3", script)
        for name, text in before.items():
            self.assertEqual((self.folder / name).read_bytes(), text)

    # --- What the paper assumes, dropped --------------------------------------------------------------------------

    def test_masses_that_burn_go_as_the_reference_does(self):
        self.compare("variable-mass", "variable-mass.yaml")

    def test_a_central_field_goes_as_the_reference_does(self):
        self.compare("central-field", "central-field.yaml")

    def test_without_both_assumptions_it_goes_as_the_reference_does_and_their_effects_add(self):
        both = self.compare("no-assumptions", "no-assumptions.yaml")
        runs = [both, *(self.run_at(file, [0]) for file in ("cyclogram.yaml", "variable-mass.yaml", "central-field.yaml"))]
        for event in "release", "contact", "liftoff":
            together, base, burning, central = (
                next(e["t"] for e in run["events"] if (e["name"], e["subject"]) == (event, "booster1")) for run in runs)
            self.assertAlmostEqual(together - base, (burning - base) + (central - base), delta=1e-8)  # s; of 5 ms and 0.5 us

    # Rocket equation: the thrusts act along the core alone, or are inclined with their boosters.
    def test_before_the_ties_are_cut_burning_adds_the_rocket_equations_speed(self):
        constant, burning = (self.run_at(file, [0.09])["samples"][0]["bodies"]["core"]["v"][0] + 6.2 * 0.09
                             for file in ("cyclogram.yaml", "variable-mass.yaml"))
        thrust = 990000 + 4 * (FULL + 70000 * math.cos(TILT))
        flow = 990000 / (315 * 9.80665) + 4 * (FULL + 70000) / (310 * 9.80665)
        self.assertAlmostEqual(constant, thrust / MASS * 0.09, delta=ROUND_OFF)
        self.assertAlmostEqual(burning, -thrust / flow * math.log(1 - flow * 0.09 / MASS), delta=1e-8)

    # --- The attitude loop --------------------------------------------------------------------------------------

    def fly(self, file, *options, transport="inproc", code=0, log=None):
        if transport != "inproc":
            self.begin(FSW, "--transport", transport)
        recording = ["--log", log] if log else []
        return self.run_json(UNLATCH, "hil", BOOSTERS / file, "--transport", transport, "--pace", "lockstep", *PATIENT, *recording,
                             *options, code=code)

    def read_back(self, log, *options, code=0):
        """Returns the replay, with the bodies' states each 0.1 s as samples."""
        report = self.run_json(UNLATCH, "replay", log, "--outputs", "body.*@100", *options, code=code)
        self.assertTrue(report["replay"]["agrees"])
        table = report["outputs"][0]
        columns = [column["name"] for output in table["outputs"] for column in output["columns"]]
        report["samples"] = []
        for t, row in zip(table["t"], table["rows"]):
            values = dict(zip(columns, row))
            bodies = {name: {key: [values[f"{name}.{part}"] for part in parts] for key, parts in
                             (("p", "x y z".split()), ("q", "qw qx qy qz".split()), ("v", "vx vy vz".split()), ("w", "wx wy wz".split()))}
                      for name in ("core", "booster1", "booster2", "booster3", "booster4")}
            report["samples"].append({"t": t, "bodies": bodies})
        return report

    def compare_loop(self, name, missed=()):
        log, code = self.folder / f"{name}.log", 1 if missed else 0
        self.fly(f"{name}.yaml", log=log, code=code)
        report = self.read_back(log, code=code)
        wanted = {float(t) for t in REFERENCE[name]["samples"]}
        report["samples"] = [sample for sample in report["samples"] if round(sample["t"], 9) in wanted]
        self.assertEqual(len(report["samples"]), len(wanted))
        return self.compare_report(name, report, missed)

    def test_the_closed_loop_goes_as_the_reference_does_and_holds_the_core(self):
        self.compare_loop("attitude-loop")

    def test_without_the_loop_the_core_goes_as_the_reference_does_and_turns_away(self):
        self.compare_loop("open-loop", missed=["pointing", "sides", "quiet"])

    def test_the_closed_loop_flies_the_same_over_every_transport(self):
        reports = [self.fly("attitude-loop.yaml", "--until", "2", transport=transport, code=None)  # whether at rest or not
                   for transport in ("inproc", "dds", "lcm", "udp")]
        self.assertEqual(len({report["hash"] for report in reports}), 1)
        self.assertTrue(all(report["replay"]["agrees"] for report in reports))

    # The reported margins must be those at which the flight begins to oscillate: at nine tenths of them it decays, at eleven
    # tenths it does not.
    def load_loop(self):
        spec = importlib.util.spec_from_file_location("loop_margins", BOOSTERS / "loop_margins.py")
        margins = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(margins)
        return {loop.name: loop for loop in margins.list_loops()}["y and z, core alone"]

    def fly_to_rate(self, *options):
        report = self.fly("attitude-loop.yaml", *options, code=None)
        return next(entry["value"] for entry in report["verdict"] if entry["id"] == "quiet")

    def test_the_delay_margin_is_that_at_which_the_core_swings(self):
        loop = self.load_loop()
        whole = 1000 * (loop.late * loop.period + loop.calc_margins()["delay"])  # ticks
        rates = [self.fly_to_rate("--until", "30", "--set", f"flight_software.delay={round(part * whole)}") for part in (0.9, 1.1)]
        print(f"whole delay {whole:.0f} ms: rates at the end {rates[0]:.1e} and {rates[1]:.1e} rad/s", file=sys.stderr)
        self.assertLess(rates[0], 1e-4)    # of some 3e-3 at the separation
        self.assertGreater(rates[1], 1e-2)

    def test_the_gain_margin_is_that_at_which_the_core_swings(self):
        loop = self.load_loop()
        gain = loop.calc_margins()["gain"]

        def fly_with(factor):
            return self.fly_to_rate("--set", f"channels.attitude_gain.initial={factor * loop.attitude}", "--set",
                                    f"channels.rate_gain.initial={factor * loop.rate}")

        stable, swinging = fly_with(0.9 * gain), fly_with(1.1 * gain)
        print(f"gain margin {gain:.2f}: rate at the end {stable:.1e} and {swinging:.1e} rad/s", file=sys.stderr)
        self.assertLess(stable, 0.1 * swinging)
        # Beyond it the chambers move from stop to stop: a first harmonic of (4/pi) 0.6 rad at most, at that frequency.
        harmonic = 4 / math.pi * 0.6 * loop.acceleration / loop.calc_margins()["gain_at"]
        self.assertGreater(swinging, 0.3 * harmonic)
        self.assertLess(swinging, 2 * harmonic)

    def test_a_vehicle_without_a_gain_is_refused_by_its_name(self):
        folder = self.folder / "boosters"
        (folder / "parts").mkdir(parents=True)
        for file in ("scenario.yaml", "parts/fuel-nozzles.yaml"):
            (folder / file).write_text((BOOSTERS / file).read_text())
        text = (BOOSTERS / "attitude-loop.yaml").read_text()
        (folder / "lame.yaml").write_text(text.replace("  roll_rate_gain:", "  another_gain:"))
        report = self.run_json(UNLATCH, "hil", folder / "lame.yaml", "--transport", "inproc", "--pace", "lockstep", code=1)
        self.assertEqual(report["status"], "aborted")
        self.assertIn("lacks channel roll_rate_gain", report["message"])

    # Comparison with the same flight without contact: the difference is the effect of the strike; the law's own sum gives its
    # size.
    def test_a_strike_gives_booster_and_core_opposite_momenta_and_the_reported_impulse(self):
        dead = ("--set", "events.contact:booster1.enabled=false")
        without = self.run_at("cyclogram.yaml", [2.58], *dead, "--until", "3", code=1)["samples"][0]["bodies"]
        struck = self.run_at("recontact.yaml", [2.58], code=1)
        bodies, (strike,) = struck["samples"][0]["bodies"], struck["contacts"]
        core, booster = ([mass * (a - b) for a, b in zip(bodies[name]["v"], without[name]["v"])]
                         for name, mass in (("core", 98500), ("booster1", 4380)))
        for a, b in zip(core, booster):
            self.assertAlmostEqual(a, -b, delta=0.05)  # N s; the loads of the two flights have differed since
        normal, slip = strike["impulse"], 0.3 * strike["impulse"]  # it slips all the time
        self.assertAlmostEqual(math.hypot(*booster), math.hypot(normal, slip), delta=0.005 * normal)
        self.assertEqual([entry["id"] for entry in struck["verdict"] if not entry["met"]], ["distance1"])

    def test_dispersed_tail_offs_let_each_go_at_its_own_time(self):
        report = self.compare("dispersed", "dispersed.yaml")
        times = sorted(e["t"] for e in report["events"] if e["name"] == "liftoff")
        self.assertGreater(min(b - a for a, b in zip(times, times[1:])), 0.001)

    # tests/references/separations_reference.py: the first samples of campaign.yaml.
    def test_forty_dispersed_separations_go_as_their_references_do(self):
        file = SOURCE / "tests/data/boosters_separations.json"
        references = json.loads(file.read_text())["separations"]
        self.assertEqual([reference["sample"] for reference in references], list(range(40)))
        out = self.folder / "out"
        self.run_ok(UNLATCH, "campaign", BOOSTERS / "campaign.yaml", "--samples", "0:40", "--out", out, code=None)
        with open(out / "samples.csv", newline="", encoding="utf-8") as table:
            rows = [{name.split(" [")[0]: value for name, value in row.items()} for row in csv.DictReader(table)]
        worst, liftoffs = 0, []  # s
        for reference, row in zip(references, rows, strict=True):
            self.assertEqual(row["status"], "done")
            for name, value in reference["inputs"].items():
                self.assertEqual(float(row[name]), value, f"{file.name} is of other samples: make it again")
            events = reference["events"]
            self.assertEqual(len(events), 12)
            worst = max([worst, *(abs(float(row[f"event.{name}"]) - t) for name, t in events.items())])
            liftoffs += [events[f"liftoff:booster{k}"] for k in range(1, 5)]
        print(f"480 events of 40 separations: {worst:.1e} s", file=sys.stderr)
        self.assertLess(worst, EVENT_TIME)
        self.assertGreater(max(liftoffs) - min(liftoffs), 0.3)  # the dispersions act

    def test_before_the_ties_are_cut_the_rocket_is_one_body(self):
        report = self.run_at("cyclogram.yaml", (0.09, 0.449))
        early, late = (sample["bodies"]["core"]["v"][0] for sample in report["samples"])
        # The main thrust acts along the core; verniers are inclined with their booster.
        thrust = 990000 + 4 * (FULL + 70000 * math.cos(TILT))
        self.assertAlmostEqual(early, (thrust / MASS - 6.2) * 0.09, delta=ROUND_OFF)
        # Thrust falls to 84 % over 0.1 … 0.2 s, the verniers' to zero over 0.25 … 0.29 s.
        impulse = (990000 * 0.449 + 4 * FULL * (0.1 + 0.92 * 0.1 + 0.84 * 0.249)
                   + 4 * 70000 * math.cos(TILT) * (0.25 + 0.5 * 0.04))
        self.assertAlmostEqual(late, impulse / MASS - 6.2 * 0.449, delta=ROUND_OFF)
        for body in report["samples"][1]["bodies"].values():
            self.assertAlmostEqual(body["v"][1], -7.4 * 0.449, delta=ROUND_OFF)
            self.assertLess(math.hypot(*body["w"]), ROUND_OFF)

    def test_failures_are_what_their_generator_writes(self):
        self.run_ok(BOOSTERS / "make-cyclogram", "--check")


if __name__ == "__main__":
    main()
