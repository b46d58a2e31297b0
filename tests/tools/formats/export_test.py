#!/usr/bin/env python3
"""Facts about `unlatch export`: other tools read the values of the replay. Run by ctest like tools_test.py."""

import csv
import json
import os
import shutil
import subprocess
from pathlib import Path

from processes import BIN, REFERENCE, SCENARIOS, UNLATCH, ProcessTest, call, main

READER = Path(__file__).resolve().parent / "read_export.mjs"
MODULES = BIN.parent / "tools/export/node_modules"
NODE = shutil.which("node") or shutil.which("nodejs")
UNTIL, TICKS = "0.8", 800  # s: past the first release


class ExportTest(ProcessTest):
    def setUp(self):
        super().setUp()
        self.log = self.folder / "run.log"
        self.report = self.run_json(UNLATCH, "run", REFERENCE, "--until", UNTIL, "--log", self.log)
        self.last = self.report["samples"][-1]

    def export(self, form, *options, code=0):
        out = self.folder / f"out.{form}"
        self.run_ok(UNLATCH, "export", self.log, "--format", form, "--out", out, *options, code=code)
        return out

    def read_with_node(self, path, *names):
        if NODE is None or not MODULES.exists():
            self.skipTest("Node.js, or what the build installs with it, is missing")
        return json.loads(self.run_ok(NODE, READER, MODULES, path, *names).stdout)

    def test_csv_is_a_table_with_units(self):
        text = self.export("csv").read_bytes()
        self.assertEqual(text.count(b"\r\n"), text.count(b"\n"))
        rows = list(csv.DictReader(text.decode().splitlines()))
        self.assertEqual(len(rows), TICKS + 1)
        self.assertEqual([int(row["tick"]) for row in rows], list(range(TICKS + 1)))
        end = rows[-1]
        core = self.last["bodies"]["core"]
        self.assertEqual([float(end[f"core.{axis} [m]"]) for axis in "xyz"], core["p"])
        self.assertEqual([float(end[f"core.q{axis}"]) for axis in "wxyz"], core["q"])
        self.assertEqual([float(end[f"core.w{axis} [rad/s]"]) for axis in "xyz"], core["w"])
        nose = self.last["reactions"]["nose1"]
        self.assertEqual(end["nose1.mode"], nose["mode"])
        self.assertEqual([float(end[f"nose1.{row} [{'N m' if 'rot' in row else 'N'}]"]) for row in nose["rows"]], nose["lambda"])
        exported_events = [event for row in rows for event in row["events"].split("; ") if event]
        self.assertEqual(exported_events, [f"{e['name']} {e['subject']}" for e in self.report["events"]])

    def test_every_nth_tick_of_some_bodies_and_no_event_is_lost(self):
        rows = list(csv.DictReader(self.export("csv", "--every", "300", "--bodies", "booster2").read_text().splitlines()))
        self.assertEqual([int(row["tick"]) for row in rows], [0, 300, 600, 800])
        self.assertIn("booster2.x [m]", rows[0])
        self.assertNotIn("core.x [m]", rows[0])
        exported_events = [event for row in rows for event in row["events"].split("; ") if event]
        self.assertEqual(len(exported_events), len(self.report["events"]))

    def test_json_lines_are_the_run(self):
        lines = [json.loads(line) for line in self.export("json").read_text().splitlines()]
        self.assertEqual((lines[0]["kind"], lines[-1]["kind"]), ("run", "end"))
        self.assertEqual((lines[-1]["status"], lines[-1]["hash"]), ("ok", self.report["hash"]))
        ticks = [line for line in lines if line["kind"] == "tick"]
        self.assertEqual(len(ticks), TICKS + 1)
        for name, body in self.last["bodies"].items():
            self.assertEqual(body, ticks[-1]["bodies"][name])
        for section in ("joints", "elements", "sensors", "channels", "clearance"):
            self.assertEqual(ticks[-1][section], self.last[section])
        self.assertEqual({"p", "q", "v", "w", "a", "alpha", "modal"}, set(ticks[-1]["bodies"]["core"]))
        self.assertEqual(ticks[-1]["reactions"], self.last["reactions"])
        events = [(line["t"], line["name"], line["subject"]) for line in lines if line["kind"] == "event"]
        self.assertEqual(events, [(e["t"], e["name"], e["subject"]) for e in self.report["events"]])
        self.assertTrue(all(body["shapes"] for body in lines[0]["bodies"]))

    def test_mcap_shows_foxglove_the_scene(self):
        if NODE is None or not MODULES.exists():
            self.skipTest("Node.js, or what the build installs with it, is missing")
        read = self.read_with_node(self.export("mcap"))
        self.assertEqual(read["channels"]["/tf"], "foxglove.FrameTransforms")
        self.assertEqual(read["channels"]["/scene"], "foxglove.SceneUpdate")
        self.assertEqual(read["channels"]["/events"], "foxglove.Log")
        self.assertEqual(read["counts"]["/tf"], TICKS + 1)
        self.assertEqual(read["counts"]["/events"], len(self.report["events"]))
        self.assertGreater(read["chunks"], 0)
        self.assertTrue(read["indexed"])
        self.assertTrue(all(name == "zstd" for name, _, _ in read["sizes"]))
        written, whole = (sum(size[k] for size in read["sizes"]) for k in (1, 2))
        self.assertLess(3 * written, whole)  # JSON of numbers shrinks to a third and less
        last = {transform["child_frame_id"]: transform for transform in read["last"]["/tf"]["transforms"]}
        for name, body in self.last["bodies"].items():
            self.assertEqual([last[name]["translation"][axis] for axis in "xyz"], body["p"])
            self.assertEqual([last[name]["rotation"][axis] for axis in "wxyz"], body["q"])
        entities = {entity["frame_id"]: entity for entity in read["last"]["/scene"]["entities"]}
        self.assertEqual(sorted(entities), sorted(self.last["bodies"]))
        self.assertTrue(all(entity["cylinders"] for entity in entities.values()))
        self.assertEqual(read["metadata"]["hash"], self.report["hash"])
        core = self.last["bodies"]["core"]
        self.assertEqual([read["last"]["/bodies/core"]["a"][axis] for axis in "xyz"], core["a"])
        name, element = next(iter(self.last["elements"].items()))
        self.assertEqual(read["last"][f"/elements/{name}"], element)
        nose = read["last"]["/joints/nose1"]
        self.assertEqual([nose["angle"][axis] for axis in "xyz"], self.last["joints"]["nose1"]["angle"])
        self.assertEqual(nose["mode"], self.last["reactions"]["nose1"]["mode"])

    def test_damage_to_an_mcap_is_found_by_its_reader(self):
        path = self.folder / "out.mcap"
        if NODE is None or not MODULES.exists():
            self.skipTest("Node.js, or what the build installs with it, is missing")
        self.export("mcap")
        bytes_ = bytearray(path.read_bytes())
        bytes_[len(bytes_) // 3] ^= 1
        path.write_bytes(bytes_)
        self.assertNotEqual(call(NODE, READER, MODULES, path).returncode, 0)

    def test_parquet_is_the_table(self):
        if NODE is None or not MODULES.exists():
            self.skipTest("Node.js, or what the build installs with it, is missing")
        read = self.read_with_node(self.export("parquet"))
        self.assertEqual(read["rows"], TICKS + 1)
        self.assertEqual(read["units"]["core.x [m]"], "m")
        self.assertEqual([read["last"][f"core.{axis} [m]"] for axis in "xyz"], self.last["bodies"]["core"]["p"])
        self.assertEqual([read["last"][f"core.a{axis} [m/s2]"] for axis in "xyz"], self.last["bodies"]["core"]["a"])
        self.assertEqual(read["last"]["nose1.mode"], self.last["reactions"]["nose1"]["mode"])

    # A ball that bounces twice and is in its third touch at the end.
    def test_touches_are_numbers_in_every_export(self):
        path = self.folder / "bounce.yaml"
        path.write_text("""unlatch: 1
name: bounce
step: {dt: 1 ms, until: 0.94}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, box: {centre: [0, 0, -0.5], size: [9, 9, 1]}}]}
bodies: {ball: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.2], shape: [{name: skin, sphere: {radius: 0.1}}]}}
contacts: {bounce: {between: [ball, ground.floor], stiffness: 0.2 MN/m, damping: 0.3}}
""")
        report = self.run_json(UNLATCH, "run", path, "--log", self.log)
        touches = report["contacts"][0]["each"]
        self.assertGreater(len(touches), 1)
        keys = ("t", "lift", "duration", "peak_force", "peak_t", "depth", "impulse")
        expected = [{key: touch[key] for key in keys} for touch in touches]
        lines = [json.loads(line) for line in self.export("json").read_text().splitlines()]
        self.assertEqual([{key: line[key] for key in keys} for line in lines if line["kind"] == "touch"], expected)
        self.export("csv")
        with open(self.folder / "out.touches.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        units = dict(zip(keys, ("s", "s", "s", "N", "s", "m", "N s")))
        read = lambda cell: None if cell == "" else float(cell)
        self.assertEqual([{key: read(row[f"{key} [{unit}]"]) for key, unit in units.items()} for row in rows], expected)
        shown = self.read_with_node(self.export("mcap"))
        self.assertEqual(shown["counts"]["/touches"], len(touches))
        self.assertEqual({key: shown["last"]["/touches"][key] for key in keys}, expected[-1])
        self.export("parquet")
        table = self.read_with_node(self.folder / "out.touches.parquet")
        self.assertEqual((table["rows"], table["units"]["impulse [N s]"]), (len(touches), "N s"))
        self.assertEqual({key: table["last"].get(f"{key} [{unit}]") for key, unit in units.items()}, expected[-1])
        self.assertEqual(table["last"]["shapes"], "ball.skin – ground.floor")

    def test_groups_of_outputs_go_out_at_their_own_rates(self):
        rows = list(csv.DictReader(self.export("csv", "--outputs", "core.velocity@100,nose1.*@4Hz").read_text().splitlines()))
        self.assertEqual([int(row["tick"]) for row in rows], [0, 100, 200, 250, 300, 400, 500, 600, 700, 750, 800])
        self.assertEqual([int(row["tick"]) for row in rows if row["core.vx [m/s]"]], list(range(0, 801, 100)))
        self.assertEqual([int(row["tick"]) for row in rows if row["nose1.mode"]], [0, 250, 500, 750, 800])
        self.assertNotIn("core.x [m]", rows[0])
        self.assertEqual([float(rows[-1][f"core.v{axis} [m/s]"]) for axis in "xyz"], self.last["bodies"]["core"]["v"])

    def test_a_name_that_is_no_output_is_refused_with_a_guess(self):
        result = self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", self.folder / "out.csv", "--outputs",
                             "core.velocty", code=2)
        self.assertIn("did you mean 'core.velocity'?", result.stderr)
        self.assertFalse((self.folder / "out.csv").exists())

    def test_a_run_and_its_replay_write_the_outputs_of_the_scenario(self):
        options = ("--outputs", "core.acceleration@200,clearance.*")
        run = self.run_json(UNLATCH, "run", REFERENCE, "--until", UNTIL, *options)
        slow, fast = run["outputs"]
        self.assertEqual([column["name"] for column in slow["outputs"][0]["columns"]], ["core.ax", "core.ay", "core.az"])
        self.assertEqual((slow["every"], slow["t"]), (200, [0, 0.2, 0.4, 0.6, 0.8]))
        self.assertEqual(slow["rows"][-1], self.last["bodies"]["core"]["a"])
        self.assertEqual(len(fast["rows"]), TICKS + 1)
        replay = self.run_json(UNLATCH, "replay", self.log, *options)
        self.assertEqual(replay["outputs"], run["outputs"])
        self.assertEqual(replay["samples"], run["samples"])

    def test_pandas_reads_the_table_at_once(self):
        import pandas
        table = pandas.read_csv(self.export("csv", "--outputs", "*,core.velocity"), index_col="t [s]")
        self.assertEqual(len(table), TICKS + 1)
        self.assertTrue(table.index.is_monotonic_increasing and table.index.is_unique)
        texts = {name for name in table.columns if table[name].dtype == object}
        self.assertEqual({name for name in texts if not name.endswith(".mode")}, {"events"})
        sparse = pandas.read_csv(self.export("csv", "--outputs", "core.velocity@100,core.position@250"), index_col="t [s]")
        self.assertEqual(sparse["core.vx [m/s]"].count(), 9)
        self.assertEqual(sparse["core.x [m]"].dtype, float)

    # The accelerometer sticks, the gyro is biased for a while, States are lost: what happened in the session is in every
    # export and in the replay, and the sensors as flight software had them beside those measured.
    def test_a_session_has_its_events_and_received_sensors_in_every_export(self):
        script = self.folder / "faults.yaml"
        script.write_text("unlatch_faults: 1\nfaults:\n  - stick: accelerometer.x\n  - {bias: {sensor: gyro, by: 0.5}, ticks: [100, 200]}\n"
                          "  - {drop: {message: State}, probability: 0.05}\n")
        session = self.run_json(UNLATCH, "hil", SCENARIOS / "boosters/scenario.yaml", "--transport", "inproc", "--pace", "lockstep", "--faults", script,
                                "--until", "0.8", "--log", self.log, "--set", "flight_software.timeout=30", code=None)
        exported_events = [f"{event['name']} {event['subject']}" for event in session["session_events"]]
        for name in ("participant.joined fsw", "fault.stick accelerometer.x", "fault.bias gyro", "fault.bias.end gyro"):
            self.assertIn(name, exported_events)
        self.assertTrue([name for name in exported_events if name.startswith("fault.message.drop")])
        replayed = self.run_json(UNLATCH, "replay", self.log, code=None)
        self.assertEqual(replayed["session_events"], session["session_events"])
        rows = list(csv.DictReader(self.export("csv").read_text().splitlines()))
        exported = [event for row in rows for event in row["events"].split("; ") if event]
        self.assertEqual(sorted(exported), sorted(exported_events + [f"{e['name']} {e['subject']}".strip() for e in session["events"]]))
        for tick, offset in ((50, 0), (99, 0), (100, 0.5), (200, 0.5), (201, 0), (800, 0)):
            for axis in "xyz":
                self.assertEqual(float(rows[tick][f"received.gyro.{axis} [rad/s]"]), float(rows[tick][f"sensor.gyro.{axis} [rad/s]"]) + offset, (tick, axis))
        stuck = {float(row["received.accelerometer.x [m/s2]"]) for row in rows}
        self.assertEqual(len(stuck), 1)
        self.assertGreater(len({float(row["sensor.accelerometer.x [m/s2]"]) for row in rows}), 100)
        self.assertEqual(session["samples"][-1]["received"]["accelerometer"][0], *stuck)
        lines = [json.loads(line) for line in self.export("json").read_text().splitlines()]
        self.assertEqual(len([line for line in lines if line["kind"] == "event"]), len(exported))
        only = list(csv.DictReader(self.export("csv", "--outputs", "received.gyro").read_text().splitlines()))
        self.assertEqual(float(only[150]["received.gyro.x [rad/s]"]), float(rows[150]["received.gyro.x [rad/s]"]))
        shown = self.read_with_node(self.export("mcap"))
        self.assertIn("/received/gyro", json.dumps(shown))
        self.assertEqual(shown["counts"]["/events"], len(exported))
        parquet = self.read_with_node(self.export("parquet"))
        self.assertEqual(parquet["events"], [row["events"] for row in rows if row["events"]])
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "report", self.log, "--out", page)
        for name in ("fault.stick", "fault.bias.end", "fault.message.drop", "participant.joined"):
            self.assertIn(name, page.read_text())

    # A gyro three samples late and biased for a while, an accelerometer that loses samples and has one value stuck.
    def test_other_readers_see_true_and_received_values_side_by_side(self):
        script = self.folder / "faults.yaml"
        script.write_text("unlatch_faults: 1\nfaults:\n  - stick: accelerometer.x\n  - {bias: {sensor: gyro, by: 0.5}, ticks: [100, 200]}\n")
        self.run_json(UNLATCH, "hil", SCENARIOS / "boosters/scenario.yaml", "--transport", "inproc", "--pace", "lockstep", "--faults", script,
                      "--until", "0.8", "--log", self.log, "--set", "flight_software.timeout=30",
                      "--set", "sensors.gyro.errors={delay: 3}", "--set", "sensors.accelerometer.errors={dropout: 0.3}", code=None)
        names = {kind: {"gyro": [f"{kind}.gyro.{axis} [rad/s]" for axis in "xyz"],
                        "accelerometer": [f"{kind}.accelerometer.{axis} [m/s2]" for axis in "xyz"]} for kind in ("sensor", "received")}
        columns = [name for kind in names.values() for sensor in kind.values() for name in sensor]
        parquet = self.read_with_node(self.export("parquet"), *columns)["series"]
        topics = {"sensor": "/sensors/", "received": "/received/"}
        mcap = self.read_with_node(self.export("mcap"), *(topics[kind] + sensor for kind, sensors in names.items() for sensor in sensors))["series"]
        tables = []
        for kind, sensors in names.items():
            for sensor, own in sensors.items():
                rows = [list(row) for row in zip(*(parquet[name] for name in own))]
                self.assertEqual(len(rows), TICKS + 1)
                self.assertEqual(mcap[topics[kind] + sensor], rows)
                tables.append(rows)
        true_rate, true_force, rate, force = tables
        for tick in range(3, TICKS + 1):
            offset = 0.5 if 100 <= tick <= 200 else 0
            self.assertEqual(rate[tick], [value + offset for value in true_rate[tick - 3]], tick)
        self.assertNotEqual(true_rate[TICKS], true_rate[TICKS - 3])
        self.assertEqual(len({row[0] for row in force}), 1)
        lost = [tick for tick in range(1, TICKS + 1) if force[tick][1:] != true_force[tick][1:]]
        self.assertTrue(150 < len(lost) < 330, len(lost))  # of 800 with a probability of 0.3
        self.assertTrue(all(force[tick][1:] == force[tick - 1][1:] for tick in lost))

    # A spring whose period a step of 5 ms does not resolve.
    def write_stiff(self, step):
        scenario = self.folder / "stiff.yaml"
        scenario.write_text("unlatch: 1\nname: stiff\nstep: {dt: " + step + ", until: 0.3}\nbodies: {a: {mass: 1, inertia: [1, 1, 1]}}\n"
                            "joints: {j: {between: [ground, a], modes: {slide: {kind: prismatic, axis: x}}}}\n"
                            "elements: {s: {type: joint_spring, joint: j, axis: x, stiffness: 1e6, rest: 1 mm}}\n")
        return scenario

    def test_a_table_of_csv_has_the_status_of_its_run_beside_it(self):
        out = self.folder / "table.csv"
        for step, status in (("5 ms", "unresolved"), ("0.05 ms", "ok")):
            code = 0 if status == "ok" else 1
            self.run_ok(UNLATCH, "run", self.write_stiff(step), "--log", self.log, code=code)
            self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", out, code=code)
            said = json.loads((self.folder / "table.status.json").read_text(encoding="utf-8"))
            self.assertEqual((said["status"], said["reason"] != "", said["replays"]), (status, status != "ok", True))
            self.assertRegex(said["hash"], r"^[0-9a-f]{16}$")
        self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", "-")
        self.assertEqual([path.name for path in self.folder.glob("*.status.json")], ["table.status.json"])

    def test_what_is_made_of_an_unresolved_run_says_so(self):
        scenario = self.write_stiff("5 ms")
        self.run_ok(UNLATCH, "run", scenario, "--log", self.log, code=1)
        for form in ("csv", "json") + (("mcap", "parquet") if NODE and MODULES.exists() else ()):
            out = self.folder / f"out.{form}"
            printed = self.run_ok(UNLATCH, "export", self.log, "--format", form, "--out", out, code=1).stderr
            self.assertIn("unresolved", printed, form)
            self.assertIn("overshoot s: its period is not resolved", printed, form)
        end = json.loads((self.folder / "out.json").read_text().splitlines()[-1])
        self.assertEqual((end["kind"], end["status"]), ("end", "unresolved"))
        self.assertIn("overshoot s: its period is not resolved", end["message"])
        page = self.folder / "page.html"
        printed = self.run_ok(UNLATCH, "report", self.log, "--out", page).stderr
        self.assertIn("run.log: unresolved: ", printed)
        self.assertIn("overshoot s: its period is not resolved", printed)
        self.assertIn("unresolved", page.read_text())
        self.assertEqual(self.read_with_node(self.folder / "out.mcap")["metadata"]["status"], "unresolved")
        keys = self.read_with_node(self.folder / "out.parquet")["keys"]
        self.assertEqual(keys["status"], "unresolved")
        self.assertIn("overshoot s: its period is not resolved", keys["message"])

    def test_parquet_has_nothing_where_an_output_is_not_due(self):
        if NODE is None or not MODULES.exists():
            self.skipTest("Node.js, or what the build installs with it, is missing")
        self.export("parquet", "--outputs", "core.velocity@100,core.position@250", "--every", "1")
        read = self.read_with_node(self.folder / "out.parquet")
        self.assertEqual(read["rows"], 11)
        self.assertEqual(read["counts"]["core.vx [m/s]"], 9)
        self.assertEqual(read["counts"]["core.x [m]"], 5)

    def test_what_cannot_be_written_is_reported(self):
        nowhere = self.folder / "no/such/folder/file"
        for form in ("csv", "json") + (("mcap", "parquet") if NODE and MODULES.exists() else ()):
            result = self.run_ok(UNLATCH, "export", self.log, "--format", form, "--out", nowhere, code=3)
            self.assertIn("no/such/folder", result.stderr)
        if Path("/dev/full").exists():
            self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", "/dev/full", code=3)
        self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", self.log, code=2)
        self.run_ok(UNLATCH, "export", self.log, "--format", "csv", "--out", "-", "--bodies", "nobody", code=2)
        self.run_ok(UNLATCH, "export", self.log, "--format", "xlsx", "--out", "-", code=2)

    def test_without_node_the_way_out_is_named(self):
        done = subprocess.run([UNLATCH, "export", self.log, "--format", "mcap", "--out", self.folder / "x.mcap"],
                              capture_output=True, text=True, env={**os.environ, "PATH": str(self.folder)})
        self.assertEqual(done.returncode, 3)
        self.assertIn("nodejs", done.stderr)

    def test_a_recording_cut_short_goes_out_as_far_as_it_is(self):
        self.log.write_bytes(self.log.read_bytes()[:-20000])
        lines = [json.loads(line) for line in self.export("json").read_text().splitlines()]
        self.assertEqual(lines[-1]["status"], "truncated")
        self.assertGreater(len(lines), 100)

    def test_capsules_boxes_and_hulls_are_shown(self):
        text = (SCENARIOS / "tree3/reference.yaml").read_text()
        shapes = ["{capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0.1}}",
                  "{box: {centre: [0, 0, 0], size: [1, 2, 3], attitude: [1, 0, 0, 0]}}",
                  "{hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}}, {sphere: {centre: [0, 0, 0], radius: 1}}"]
        for i, shape in enumerate(shapes):
            self.assertIn(f"  body{i}:\n", text)
            text = text.replace(f"  body{i}:\n", f"  body{i}:\n    shape: [{shape}]\n", 1)
        scenario = self.folder / "shapes.yaml"
        scenario.write_text(text)
        self.run_ok(UNLATCH, "run", scenario, "--until", "0.01", "--log", self.log)
        read = self.read_with_node(self.export("mcap"))
        zero, one, two = read["last"]["/scene"]["entities"]
        self.assertEqual((len(zero["cylinders"]), len(zero["spheres"])), (1, 2))
        self.assertEqual(one["cubes"][0]["size"], {"x": 1, "y": 2, "z": 3})
        self.assertEqual(len(two["triangles"][0]["points"]), 4 * 3)
        self.assertEqual(len(two["spheres"]), 1)


if __name__ == "__main__":
    main()
