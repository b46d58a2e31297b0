#!/usr/bin/env python3
"""The Python package: the bits of a session, views without copies, exceptions with their place, signals, types, the wheel.

    python_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import ctypes
import locale
import math
import os
import pickle
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from processes import BIN, BOOSTERS, FLIGHT, HANG, REFERENCE, SANITIZED, SOURCE, ProcessTest, main  # noqa: E402

BUILD = BIN.parent
if SANITIZED:
    sys.exit(77)  # Python itself would need the sanitizer
sys.path.insert(0, str(BUILD / "python"))
import numpy as np  # noqa: E402

import unlatch  # noqa: E402

if "UNLATCH_LOCALE" in os.environ:
    locale.setlocale(locale.LC_ALL, os.environ["UNLATCH_LOCALE"])  # of the host: comma_locale.sh

EXAMPLES = SOURCE / "library/python/examples"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(BUILD / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
WRONG = "unlatch: 1\nname: wrong\nstep: {dt: 0.001, until: 1}\nbodies:\n  core:\n    mass: -3 kg\n    inertia: [1, 1, 1]\n"


class PythonTest(ProcessTest):
    def run_python(self, *arguments, environment=ENVIRONMENT):
        done = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=HANG, env=environment)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def record_session(self):
        log = self.folder / "session.log"
        session = self.run_json(BIN / "unlatch", "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", "2", "--log",
                                log, code=None)
        return log, session["hash"]

    def test_own_control_separates_the_boosters_to_the_hash_of_a_session_in_lockstep(self):
        _, wanted = self.record_session()
        said = self.run_python(EXAMPLES / "own_control.py", BOOSTERS)
        self.assertIn(f"hash {wanted}", said)
        self.assertEqual(said.count("liftoff"), 4)

    def test_findings_are_those_of_check_and_those_of_the_steps(self):
        text = ("unlatch: 1\nname: pulse\nstep: {dt: 5 ms, until: 2 s}\nbodies:\n  lid: {mass: 4 kg, inertia: [1, 1, 1]}\nelements:\n"
                "  pyro: {type: force, body: lid, frame: world, direction: [1, 0, 0], profile: {table: {times: [0, 1.0011, 1.0012, 1.0013, 1.0014, 1.0015, 1.0016, 1.0017, 1.0018, 1.0019, 1.002, 1.0021, 2], "
                "values: [0, 0, 1.6 kN, 3.2 kN, 4.8 kN, 6.4 kN, 8 kN, 6.4 kN, 4.8 kN, 3.2 kN, 1.6 kN, 0, 0]}}}\n  spring: {type: spring, between: [ground, lid], stiffness: 1 N/m, free_length: 1}\n")
        with unlatch.load_text(text, notice=True) as sim:
            self.assertIn(("direction", "element 'spring'", False), [(f.name, f.subject, f.of_run) for f in sim.findings])
            sim.run()
            noticed = next(f for f in sim.findings if f.of_run and f.name == "profile")
            self.assertEqual((noticed.subject, noticed.unresolved), ("pyro", True))
            self.assertAlmostEqual(noticed.time, 1, delta=0.01)

    def test_a_linear_model_is_that_of_a_body_with_a_thruster(self):
        text = ("unlatch: 1\nname: craft\nstep: {dt: 1 ms, until: 1 s}\nchannels: {thrust: {initial: 0, range: [-9, 9], unit: N}}\n"
                "bodies:\n  craft: {mass: 4 kg, inertia: [3, 4, 5]}\nelements:\n  jet: {type: force, body: craft, point: [0.5, 0, 0], "
                "direction: [0, 1, 0], profile: 1 N, channel: thrust}\nsensors: {gyro: {type: rate, body: craft}}\n")
        with unlatch.load_text(text) as sim:
            before = sim.hash
            linear = sim.linearize()
            self.assertEqual(sim.hash, before)
            self.assertEqual((linear.A.shape, linear.B.shape, linear.C.shape, linear.D.shape), ((12, 12), (12, 1), (3, 12), (3, 1)))
            gains = dict(zip(linear.states, linear.B[:, 0]))
            self.assertAlmostEqual(gains.pop("rate.body.craft.y"), 1 / 4, delta=1e-9)
            self.assertAlmostEqual(gains.pop("rate.body.craft.rot_z"), 0.5 / 5, delta=1e-9)
            self.assertLess(max(map(abs, gains.values())), 1e-9)
            self.assertEqual(linear.outputs[2], "sensor.gyro.z")
            self.assertAlmostEqual(linear.C[2, linear.states.index("rate.body.craft.rot_z")], 1, delta=1e-9)
            self.assertLess(linear.A_error.max(), 1e-9)
            # It floats freely: the thruster turns it ever faster, about z alone.
            np.testing.assert_array_equal(linear.gains, [[0], [0], [np.inf]])
            self.assertEqual(len(linear.poles), 12)
            self.assertLess(max(map(abs, linear.poles)), 1e-3)

    # A pendulum of stiffness k, damping d and inertia 1 with a motor, and a loop (60 + 9 s) e^-0.02s around it.
    def test_poles_gains_and_margins_are_those_of_closed_forms(self):
        text = ("unlatch: 1\nname: pendulum\nstep: {dt: 1 ms, until: 2}\ngravity: {uniform: [9.81, 0, 0]}\n"
                "channels: {torque: {initial: 0, range: [-100, 100], unit: N m}}\nbodies:\n"
                "  bar: {mass: 3, inertia: [0.01, 0.25, 0.25], position: [0.5, 0, 0]}\njoints:\n"
                "  hinge: {between: [ground, bar], point: [0, 0, 0], follower_point: [-0.5, 0, 0], modes: {hinge: {kind: revolute, axis: z}}, mode: hinge}\n"
                "elements:\n  damper: {type: joint_spring, joint: hinge, axis: rot_z, damping: 0.4}\n"
                "  motor: {type: torque, body: bar, frame: world, direction: [0, 0, 1], profile: 1 N*m, channel: torque}\n"
                "sensors:\n  angle: {type: angle, joint: hinge, axis: rot_z}\n  speed: {type: speed, joint: hinge, axis: rot_z}\n")
        k, d, late = 3 * 9.81 * 0.5, 0.4, 0.02
        loop = "torque=60*sensor.angle+9*sensor.speed"
        with unlatch.load_text(text) as sim:
            with self.assertRaises(unlatch.OrderError):
                sim.calc_margins(loop)
            linear = sim.linearize()
            np.testing.assert_allclose(sorted(linear.poles, key=lambda p: p.imag), sorted(np.roots([1, d, k]), key=lambda p: p.imag), rtol=1e-6)
            np.testing.assert_allclose(linear.gains, [[1 / k], [0]], rtol=1e-7, atol=1e-9)
            self.assertLess(np.max(linear.gains_error), 1e-7)
            margins = sim.calc_margins(loop, delay=late)
            self.assertTrue(margins.stable)

            def open_loop(w):
                return (60 + 9j * w) / (k - w * w + 1j * d * w) * np.exp(-1j * w * late)

            self.assertAlmostEqual(abs(open_loop(margins.phase_frequency)), 1, places=6)
            self.assertAlmostEqual(abs(np.angle(-open_loop(margins.phase_frequency))), margins.phase, places=6)
            self.assertAlmostEqual(np.angle(-open_loop(margins.gain_frequency)), 0, places=6)
            self.assertAlmostEqual(1 / abs(open_loop(margins.gain_frequency)), margins.gain, places=5)
            self.assertAlmostEqual(margins.delay, margins.phase / margins.delay_frequency, places=6)
            self.assertTrue(np.isnan(margins.drop))
            self.assertFalse(sim.calc_margins(loop, delay=late + 1.01 * margins.delay).stable)
            for wrong, text in (("torque=60*sensor.angles", "did you mean 'sensor.angle'"), ("torque=sensor.angle", "CHANNEL=GAIN*OUTPUT")):
                with self.assertRaisesRegex(unlatch.Error, re.escape(text)):
                    sim.calc_margins(wrong)
            with self.assertRaises(unlatch.RangeError):
                sim.calc_margins(loop, period=-1)

    def test_a_recording_is_read_and_followed(self):
        log, wanted = self.record_session()
        with unlatch.open_recording(log) as recorded, unlatch.load(BOOSTERS) as own:
            path = []
            for _ in range(2000):
                recorded.step()
                for name, value in recorded.channels.items():
                    own.channels[name] = value
                own.step()
                path.append(recorded.bodies["booster1"].position[1])
            self.assertRaises(StopIteration, recorded.step)
            self.assertEqual(recorded.run(ticks=10), 0)
            self.assertEqual((own.hash, recorded.hash), (wanted, wanted))
            self.assertGreater(abs(path[-1] - path[0]), 1)
            with self.assertRaises(unlatch.OrderError):
                recorded.channels["throttle1"] = 1

    def test_a_recording_is_tabulated(self):
        log, _ = self.record_session()
        exported = self.folder / "session.csv"
        self.run_ok(BIN / "unlatch", "export", log, "--format", "csv", "--every", 100, "--out", exported)
        table, wanted = unlatch.read_recording(log, every=100), unlatch.read_table(exported)
        self.assertEqual((table.rows, wanted.rows), (21, 21))
        for column in ("tick", "t", "core.x", "core.qw", "booster1.vz", "booster4.wy", "channel.throttle1"):
            np.testing.assert_array_equal(table[column], wanted[column], column)
            self.assertEqual(table.units[column].replace("1", ""), wanted.units[column], column)  # CSV names no unit of plain numbers
        self.assertEqual((table["tick"].dtype, table["core.x"].dtype), (np.int64, np.float64))
        self.assertRaises(ValueError, unlatch.read_recording, log, every=0)
        self.assertRaises(unlatch.FileError, unlatch.read_recording, BOOSTERS)

    def test_a_recording_whose_body_is_named_as_a_kind_of_columns_is_tabulated(self):
        scenario, log, exported = (self.folder / name for name in ("kinds.yaml", "kinds.log", "kinds.csv"))
        bodies = "".join(f"  {name}: {{mass: 1, inertia: [1, 1, 1], position: [0, {at}, 0], velocity: [{at}, 0, 0]}}\n"
                         for at, name in enumerate(("sensor", "channel", "x"), 1))
        scenario.write_text("unlatch: 1\nname: kinds\nstep: {dt: 10 ms, until: 0.1}\nbodies:\n" + bodies +
                            "quantities: {place: {position: {body: x, component: x}}}\n"
                            "sensors: {x: {type: quantity, quantity: place}}\nchannels: {x: {initial: 0.5}}\n")
        self.run_ok(BIN / "unlatch", "run", scenario, "--log", log)
        self.run_ok(BIN / "unlatch", "export", log, "--format", "csv", "--out", exported)
        table, wanted = unlatch.read_recording(log), unlatch.read_table(exported)
        for column in ("sensor.x", "channel.x", "x.x", "sensor.sensor.x", "command.channel.x"):
            np.testing.assert_array_equal(table[column], wanted[column], column)
        self.assertAlmostEqual(table["sensor.sensor.x"][-1], 0.3)
        self.assertEqual(set(table["command.channel.x"]), {0.5})

    def test_the_table_of_a_campaign_is_numpy_and_pandas(self):
        campaign, folder = SOURCE / "hil/scenarios/boosters/campaign.yaml", self.folder / "campaign"
        self.run_ok(BIN / "unlatch", "campaign", campaign, "--out", folder, "--samples", "0:6", "--set", "step.until=0.8", code=None)
        table = unlatch.read_table(folder)
        self.assertEqual((table.rows, table.manifest["campaign"]), (6, "boosters-dispersion"))
        self.assertEqual(list(table["sample"]), [0, 1, 2, 3, 4, 5])
        self.assertEqual(set(table["status"]), {"done"})
        self.assertEqual((table.units["nozzle:1"], table.units["distance1.margin"], table.units["mass:1"]), ("N", "m", "kg"))
        np.testing.assert_array_equal(table["distance1.margin"], table["distance1"] - 1)
        self.assertTrue(np.isnan(table["leaves1"]).any() or (table["leaves1"] > 0).all())
        # A sample equals the library's result for its overrides.
        with unlatch.load(SOURCE / "hil/scenarios/boosters/reference.yaml") as sim:
            self.assertTrue(all(len(digits) == len(sim.hash) for digits in table["hash"]))
        frame = table.to_pandas()
        self.assertEqual((frame.shape, frame.attrs["units"]["distance1"]), ((6, len(table)), "m"))
        self.assertEqual(frame["thrust:1"].mean(), table["thrust:1"].mean())
        np.testing.assert_array_equal(unlatch.read_table(folder / "samples.csv")["distance2"], table["distance2"])
        with self.assertRaisesRegex(KeyError, "known: .*distance1"):
            table["distance9"]
        try:
            parquet = unlatch.read_table(folder / "samples.parquet")
        except unlatch.FileError as error:  # pandas without a reader
            self.assertIn("samples.csv", str(error))
        else:
            np.testing.assert_array_equal(parquet["distance1"], table["distance1"])
        for path, why in ((self.folder, "no folder of a campaign"), (self.folder / "none.csv", "there is no such file")):
            with self.assertRaisesRegex(unlatch.FileError, why):
                unlatch.read_table(path)
        wrong = self.folder / "wrong.csv"
        wrong.write_text("a,b\n1,2\n3\n", encoding="utf-8")
        with self.assertRaisesRegex(unlatch.FileError, "no table"):
            unlatch.read_table(wrong)

    def test_quantities_and_constants_have_units(self):
        with unlatch.load(BOOSTERS) as sim:
            units = {name: sim.quantities[name].unit for name in ("rate.core", "reaction.nose1.x", "reaction.nose1.rot_x", "reaction.nose1.moment",
                                                                  "time.release:booster1", "position.booster2", "sensor.kr1", "order")}
            self.assertEqual(list(units.values()), ["rad/s", "N", "N m", "N m", "s", "m", "", "s"])
            self.assertEqual(sim.quantities["reaction.nose1.x"].text, "reaction: {joint: nose1, row: x}")
            self.assertEqual((sim.constants["slope"].value, sim.constants["slope"].unit), (0.06, "rad"))
            self.assertEqual(sim.get_unit("constant", "node_radius"), "m")
            self.assertEqual(sim.numbers["bodies.core.mass"], unlatch.Number(98500, "kg"))
        # The language accepts the texts of the list.
        for name in ("rate.core", "clearance.core.booster1", "displacement.nose1.x", "sensor.kr1", "time.liftoff:booster3"):
            with unlatch.load(BOOSTERS) as sim:
                requirement = f"[{{id: one, {sim.quantities[name].text}, at_least: 0}}]"
            with unlatch.load(BOOSTERS, {"requirements": requirement}) as sim:
                self.assertEqual(sim.get_unit("requirement", "one"), sim.quantities[name].unit)

    def test_arrays_are_read_only_views_of_the_present_state(self):
        with unlatch.load(REFERENCE) as sim:
            core = sim.bodies["core"]
            before, address = core.position.copy(), core.position.ctypes.data
            self.assertEqual(sim.run(until=0.7), 700)
            self.assertEqual(core.position.ctypes.data, address)
            self.assertGreater(np.abs(core.position - before).max(), 1)
            self.assertEqual(sim.bodies["core"].position[0], ctypes.c_double.from_address(address).value)
            with self.assertRaises(ValueError):
                core.position[0] = 0
            self.assertAlmostEqual(float(np.linalg.norm(core.attitude)), 1)
            nose = sim.joints["nose1"]
            self.assertEqual((nose.mode, nose.reaction.shape), ("slider", (6,)))
            self.assertGreater(np.abs(nose.reaction).max(), 1)
            kept, value = core.position, core.position[0]
        self.assertEqual(kept[0], value)  # its memory stays
        self.assertRaises(unlatch.OrderError, sim.step)
        self.assertIn("closed", repr(sim))

    def test_sensors_channels_events_and_verdicts_have_names_and_units(self):
        with unlatch.load(BOOSTERS, judge=True) as sim:
            self.assertEqual(sim.sensors["gyro"].shape, (3,))
            self.assertEqual({s.name: s.unit for s in sim.sensor_items}["gyro"], "rad/s")
            self.assertEqual(sim.channels["rudder2"], -0.02)
            for i in range(1, 5):
                sim.channels[f"cut_ties{i}"] = 1
            self.assertEqual(sim.run(ticks=50, stop_at_events=True), 1)
            self.assertEqual([(e.name, e.subject, e.tick) for e in sim.events], [("ties_cut", f"booster{i}", 0) for i in range(1, 5)])
            verdict = sim.verdicts[0]
            self.assertEqual((verdict.id, verdict.unit, verdict.limit), ("distance1", "m", 0.1))
            self.assertEqual((verdict.uncertainty, verdict.at_ticks), (0, False))  # a clearance is exact
            self.assertGreater(sim.clearances["core – booster1"][0], 0)
        with unlatch.load(BOOSTERS) as sim:
            self.assertRaises(unlatch.OrderError, lambda: sim.verdicts)

    def test_states_are_saved_restored_and_recorded(self):
        log = self.folder / "own.log"
        with unlatch.load(REFERENCE, {"bodies.core.mass": 99000.0}) as sim:
            sim.run(until=0.2)
            state = sim.save()
            sim.start_recording(log)
            sim.run(until=0.5)
            ended = sim.hash
        with unlatch.load(REFERENCE, {"bodies.core.mass": "99 t"}) as other:
            other.restore(state)
            other.run(until=0.5)
            self.assertEqual(other.hash, ended)
            self.assertRaises(unlatch.StateError, other.restore, state[:-1] + bytes([state[-1] ^ 1]))
            other.reset()
            self.assertEqual(other.tick, 0)
        with unlatch.open_recording(log) as replay:
            self.assertEqual(replay.run(ticks=1000), 300)
            self.assertEqual(replay.hash, ended)

    # Parameters of tables as overrides, the channel of a table, quantities of flight as sensors: the bits of the program.
    def test_tables_expressions_and_air_have_the_bits_of_the_program(self):
        path, changes = self.folder / "dart.yaml", {"tables.pitching.scale": 1.25, "tables.pitching.offset": 0.01, "constants.fineness": 1.75}
        path.write_text(FLIGHT)
        for overrides in ({}, changes):
            options = [option for name, value in overrides.items() for option in ("--set", f"{name}={value}")]
            wanted = self.run_json(BIN / "unlatch", "run", path, "--outputs", "sensor.*@400", *options)
            with unlatch.load(path, overrides) as sim:
                sim.run(until=1)
                state = sim.save()
                sim.run(until=2)
                self.assertEqual(sim.hash, wanted["hash"])
                table = wanted["outputs"][0]
                self.assertEqual([sim.sensors["alpha"][0], sim.sensors["load"][0]], table["rows"][-1])
                sim.restore(state)
                sim.channels["gain"] = 0.5
                sim.run(until=2)
                self.assertNotEqual(sim.hash, wanted["hash"])
        with unlatch.load(path, {"channels.gain.initial": 0.5}) as half, unlatch.load(path, {"tables.pitching.scale": 0.5}) as scaled:
            half.run(until=2)
            scaled.run(until=2)
            self.assertTrue(np.array_equal(half.bodies["dart"].position, scaled.bodies["dart"].position))

    def test_exceptions_have_file_line_and_key(self):
        path = self.folder / "wrong.yaml"
        path.write_text(WRONG, encoding="utf-8")
        for load in (lambda: unlatch.load(path), lambda: unlatch.load_text(WRONG, str(path))):
            with self.assertRaises(unlatch.ScenarioError) as caught:
                load()
            error = caught.exception
            self.assertEqual((error.file, error.line, error.key), (str(path), 6, "bodies.core.mass"))
            self.assertIn("mass", str(error))
        self.assertRaises(unlatch.FileError, unlatch.open_recording, path)
        with unlatch.load(BOOSTERS) as sim:
            for value in (2, math.nan, math.inf):
                with self.assertRaises(unlatch.RangeError) as caught:
                    sim.channels["throttle1"] = value
                self.assertEqual(caught.exception.key, "channels.throttle1")
            with self.assertRaisesRegex(KeyError, "known: throttle1"):
                sim.channels["throtle1"] = 1
            self.assertRaises(ValueError, sim.run, until=math.nan)

    def test_numbers_of_messages_and_overrides_have_a_point_whatever_the_locale(self):
        with unlatch.load(BOOSTERS, {"bodies.core.mass": 12345.5}) as sim:
            sim.step()
        with self.assertRaises(unlatch.Error) as raised:
            unlatch.load(BOOSTERS, {"bodies.core.inertia": [1, 1, 9999.5]})
        self.assertIn("9999.5", str(raised.exception))
        self.assertNotIn("9.999", str(raised.exception))

    def test_other_threads_run_while_it_steps(self):
        with unlatch.load(REFERENCE) as sim:
            native, refused = sim._native, False

            def advance():
                while True:
                    try:
                        return native.advance(400_000, False)
                    except unlatch.OrderError:  # the other thread was asking at that moment
                        pass
            worker = threading.Thread(target=advance)
            worker.start()
            while worker.is_alive() and not refused:
                try:
                    native.get_tick()
                except unlatch.OrderError:  # in use by the other thread, without the interpreter's lock
                    refused = True
            worker.join()
            self.assertTrue(refused)

    def test_ctrl_c_interrupts_a_run_that_can_go_on(self):
        program = ("import os, signal, sys, threading, time, unlatch\n"
                   "sim, begun = unlatch.load(sys.argv[1]), threading.Event()\n"
                   "def press():\n"
                   "    begun.wait()\n"
                   "    os.kill(os.getpid(), signal.SIGINT)\n"
                   "threading.Thread(target=press, daemon=True).start()\n"
                   "try:\n"
                   "    begun.set()\n"
                   "    sim.run(ticks=10**12)\n"
                   "except KeyboardInterrupt:\n"
                   "    sim.run(ticks=5)\n"
                   "    print('went on')\n")
        self.assertIn("went on", self.run_python("-c", program, REFERENCE))

    def test_a_batch_has_the_results_of_single_runs(self):
        with unlatch.Batch(REFERENCE, judge=True) as batch:
            masses = [99e3, 100e3, -1.0, 101e3]
            for mass in masses:
                batch.add({"bodies.core.mass": mass})
            with self.assertWarnsRegex(unlatch.SampleWarning, "1 of 4 samples have no results: sample 2: "):
                batch.run(until=0.9)
            self.assertEqual(list(batch.ok), [True, True, False, True])
            self.assertIn("mass", batch.why(2))
            self.assertEqual(batch.final_bodies.shape, (4, 5, 13))
            for i in (0, 3):
                with unlatch.load(REFERENCE, {"bodies.core.mass": masses[i]}, judge=True) as sim:
                    sim.run(until=0.9)
                    self.assertEqual(batch.hashes[i], sim.hash)
                    self.assertEqual(batch.margins["distance1"][i], sim.verdicts[0].margin)
                    self.assertEqual(tuple(batch.final_bodies[i, 0, :3]), tuple(sim.bodies["core"].position))
                    releases = [e.time for e in sim.events if (e.name, e.subject) == ("release", "booster1")]
                    self.assertEqual(batch.event_times["release:booster1"][i], releases[0])
            view = batch.ticks
            self.assertRaises(BufferError, batch.add)
            self.assertEqual(list(view), [900, 900, 0, 900])

    def test_errors_come_through_a_pickle(self):
        with self.assertRaises(unlatch.ScenarioError) as caught:
            unlatch.load(REFERENCE, {"bodies.cor.mass": 3})
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertIs(type(again), unlatch.ScenarioError)
        self.assertEqual((str(again), again.mistakes), (str(caught.exception), caught.exception.mistakes))
        missing = pickle.loads(pickle.dumps(unlatch.MissingFileError(again.mistakes)))
        self.assertIsInstance(missing, FileNotFoundError)
        self.assertEqual(missing.line, again.line)

    def test_overrides_that_are_no_mapping_are_a_type_error(self):
        with unlatch.Batch(REFERENCE) as batch:
            self.assertRaisesRegex(TypeError, "mapping of paths to values, not int", batch.add, 3)
            self.assertRaisesRegex(TypeError, "'str' object cannot be interpreted as an integer", batch.run, 0, "2")
        self.assertRaisesRegex(TypeError, "mapping of paths to values, not list", unlatch.load, REFERENCE, ["a=1"])

    def test_a_table_with_equal_columns_is_refused(self):
        path = self.folder / "twice.csv"
        path.write_text("a [m],b,a [m]\n1,2,3\n", encoding="utf-8")
        with self.assertRaisesRegex(unlatch.FileError, r"more than one column 'a \[m\]'"):
            unlatch.read_table(path)
        path.write_text("a [m],b,a [s]\n1,2,3\n", encoding="utf-8")  # equal without their units, by which columns are not known
        with self.assertRaisesRegex(unlatch.FileError, "more than one column 'a'"):
            unlatch.read_table(path)

    def test_a_missing_file_is_a_file_not_found_error(self):
        for task in (lambda: unlatch.load("nix.yaml"), lambda: unlatch.Batch("nix.yaml"), lambda: unlatch.open_recording("nix.log"),
                     lambda: unlatch.read_table("nix.csv"), lambda: unlatch.read_recording("nix.log")):
            with self.assertRaises(FileNotFoundError) as caught:
                task()
            self.assertIsInstance(caught.exception, unlatch.Error)
            self.assertIn("nix.", str(caught.exception))

    def test_numbers_of_numpy_are_values_of_overrides(self):
        with unlatch.load(REFERENCE, {"bodies.core.mass": np.int64(100000), "step.until": np.float32(1)}) as sim:
            self.assertEqual(sim.until, 1)

    def test_the_example_studies_run(self):
        picture = self.folder / "dispersion.png"
        said = self.run_python(EXAMPLES / "dispersion.py", REFERENCE, picture, 6, environment={**ENVIRONMENT, "MPLCONFIGDIR": str(self.folder)})
        self.assertIn("distance1: margin from", said)
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        said = self.run_python(EXAMPLES / "compare_designs.py", REFERENCE)
        self.assertIn("heavier core: release at", said)

    def test_types_are_checked(self):
        if not shutil.which("mypy"):
            self.skipTest("mypy is not installed (tools/setup test)")
        check = ["mypy", "--strict", f"--cache-dir={self.folder}/types"]  # the second run takes NumPy from what the first has read
        self.run_ok(*check, SOURCE / "library/python/unlatch")
        user = self.folder / "user.py"
        user.write_text("import unlatch\nwith unlatch.load('x.yaml') as sim:\n    sim.run(until='late')\n    sim.bodies['core'].positon\n",
                        encoding="utf-8")
        done = subprocess.run([*check, user], capture_output=True, text=True, timeout=HANG, env={**ENVIRONMENT, "MYPYPATH": str(BUILD / "python")})
        self.assertIn('has incompatible type "str"', done.stdout)
        self.assertIn('has no attribute "positon"', done.stdout)
        self.assertIn("Found 2 errors", done.stdout)

    def test_the_installed_package_and_the_wheel_work_where_they_are(self):
        show = "import unlatch, sys; sim = unlatch.load(sys.argv[1], judge=True); sim.run(until=0.1); print(unlatch.__file__, sim.hash)"
        with unlatch.load(REFERENCE) as sim:
            sim.run(until=0.1)
            wanted = sim.hash
        prefix, moved = self.folder / "prefix", self.folder / "moved"
        for component in ("library", "python"):
            self.run_ok("cmake", "--install", BUILD, "--prefix", prefix, "--component", component)
        prefix.rename(moved)
        folder = next(moved.glob("lib/python*/dist-packages"))
        said = self.run_python("-c", show, REFERENCE, environment={**ENVIRONMENT, "PYTHONPATH": str(folder)})
        self.assertEqual(said.split(), [str(folder / "unlatch/__init__.py"), wanted])

        source = self.folder / "library/python"  # setup.py looks for CMakeLists.txt two folders above
        shutil.copytree(SOURCE / "library/python", source)
        shutil.copy(SOURCE / "CMakeLists.txt", self.folder)
        done = subprocess.run([sys.executable, "setup.py", "-q", "bdist_wheel"], cwd=source, capture_output=True, text=True, timeout=HANG,
                              env={**ENVIRONMENT, "UNLATCH_BUILD": str(BUILD)})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        wheel = next((source / "dist").glob("unlatch-*-cp3*-linux_*.whl"))
        unpacked = self.folder / "unpacked"
        shutil.unpack_archive(wheel, unpacked, "zip")
        said = self.run_python("-c", show, REFERENCE, environment={**ENVIRONMENT, "PYTHONPATH": str(unpacked)})
        self.assertEqual(said.split(), [str(unpacked / "unlatch/__init__.py"), wanted])


if __name__ == "__main__":
    main()
