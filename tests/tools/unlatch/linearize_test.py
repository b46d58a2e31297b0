#!/usr/bin/env python3
"""Linear models as users see them: poles, files that other programs read, margins beside closed forms. Run by ctest:

    linearize_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math
import sys
from pathlib import Path

import numpy as np
from processes import SOURCE, UNLATCH, ProcessTest, call, main

sys.path.insert(0, str(SOURCE / "hil/scenarios/boosters"))

# A bar of 1 m and 3 kg that hangs from a hinge about z, with a motor and a damper: 1 kg m2 about the hinge.
PENDULUM = """unlatch: 1
name: pendulum
step: {dt: 1 ms, until: 2}
gravity: {uniform: [9.81, 0, 0]}
channels:
  torque: {initial: 0, range: [-100, 100], unit: N m}
bodies:
  bar: {mass: 3, inertia: [0.01, 0.25, 0.25], position: [0.5, 0, 0]}
joints:
  hinge: {between: [ground, bar], point: [0, 0, 0], follower_point: [-0.5, 0, 0], modes: {hinge: {kind: revolute, axis: z}}, mode: hinge}
elements:
  damper: {type: joint_spring, joint: hinge, axis: rot_z, damping: 0.4}
  motor: {type: torque, body: bar, frame: world, direction: [0, 0, 1], profile: 1 N*m, channel: torque}
sensors:
  angle: {type: angle, joint: hinge, axis: rot_z}
  speed: {type: speed, joint: hinge, axis: rot_z}
events:
  - {name: early, when: {time: 0.25}}
"""
STIFFNESS, DAMPING = 3 * 9.81 * 0.5, 0.4
DIFFERENCES = 1e-7  # relative, of a derivative


class LinearizeTest(ProcessTest):
    def setUp(self):
        super().setUp()
        self.plant = self.folder / "pendulum.yaml"
        self.plant.write_text(PENDULUM, encoding="utf-8")

    def linearize(self, *options):
        return json.loads(self.run_ok(UNLATCH, "linearize", self.plant, *options, "--json", "-").stdout)

    def test_a_pendulum_has_its_matrices_names_and_poles(self):
        linear = self.linearize()
        self.assertEqual([state["name"] for state in linear["states"]], ["joint.hinge.rot_z", "rate.joint.hinge.rot_z"])
        self.assertEqual([state["unit"] for state in linear["states"]], ["rad", "rad/s"])
        np.testing.assert_allclose(linear["A"], [[0, 1], [-STIFFNESS, -DAMPING]], rtol=DIFFERENCES, atol=1e-9)
        np.testing.assert_allclose(linear["B"], [[0], [1]], rtol=DIFFERENCES, atol=1e-9)
        np.testing.assert_allclose(linear["C"], np.eye(2), rtol=DIFFERENCES, atol=1e-9)
        self.assertEqual([output["name"] for output in linear["outputs"]], ["sensor.angle", "sensor.speed"])
        wanted = sorted(np.roots([1, DAMPING, STIFFNESS]), key=lambda pole: pole.imag)
        found = sorted((complex(*pole) for pole in linear["poles"]), key=lambda pole: pole.imag)
        np.testing.assert_allclose(found, wanted, rtol=1e-6)

    # A constant torque turns the bar by torque / stiffness in the end, and no further.
    def test_a_pendulum_has_its_steady_state_gains_and_without_gravity_that_of_its_speed(self):
        linear = self.linearize()
        np.testing.assert_allclose(linear["gains"], [[1 / STIFFNESS], [0]], rtol=DIFFERENCES, atol=1e-9)
        self.assertLessEqual(abs(linear["gains"][0][0] - 1 / STIFFNESS), linear["gains_error"][0][0])
        self.assertLess(np.max(linear["gains_error"]), 1e-6 / STIFFNESS)
        self.assertRegex(self.run_ok(UNLATCH, "linearize", self.plant).stdout, r"steady-state gains\n  torque to sensor.angle +0\.06[78]\d* rad per N m\n\n")
        longer = self.run_json(UNLATCH, "run", self.plant, "--until", "60 s", "--set", "channels.torque.initial=0.01", "--sample", "60")
        self.assertAlmostEqual(2 * longer["samples"][0]["bodies"]["bar"]["q"][3] / 0.01, linear["gains"][0][0], delta=1e-6)
        self.plant.write_text(PENDULUM.replace("gravity: {uniform: [9.81, 0, 0]}\n", ""), encoding="utf-8")
        free = self.linearize()
        self.assertIsNone(free["gains"][0][0])
        self.assertAlmostEqual(free["gains"][1][0], 1 / DAMPING, delta=DIFFERENCES / DAMPING)
        text = self.run_ok(UNLATCH, "linearize", self.plant).stdout
        self.assertIn("1 pole at 0", text)
        self.assertIn("  1 gain without end", text)
        self.run_ok(UNLATCH, "linearize", self.plant, "--out", self.folder / "free.npz")
        with np.load(self.folder / "free.npz") as file:
            np.testing.assert_allclose(file["gains"], [[np.inf], [1 / DAMPING]], rtol=DIFFERENCES)

    # The panel bends by what its own acceleration asks of the spring; bus and panel float freely in all six freedoms.
    def test_a_torque_that_turns_a_satellite_ever_faster_bends_its_panel_by_a_finite_angle(self):
        mass, inertia, panel, own, hinge, arm, stiffness = 40.0, 9.0, 3.0, 0.5, 0.8, 1.1, 5.0
        self.plant.write_text(f"""unlatch: 1
name: satellite
step: {{dt: 1 ms, until: 1}}
channels: {{torque: {{initial: 0, range: [-9, 9], unit: N m}}}}
bodies:
  bus: {{mass: {mass}, inertia: [8, 10, {inertia}]}}
  panel: {{mass: {panel}, inertia: [0.1, 0.6, {own}], position: [{hinge + arm}, 0, 0]}}
joints:
  hinge: {{between: [bus, panel], point: [{hinge}, 0, 0], follower_point: [{-arm}, 0, 0], modes: {{hinge: {{kind: revolute, axis: z}}}}, mode: hinge}}
elements:
  spring: {{type: joint_spring, joint: hinge, axis: rot_z, stiffness: {stiffness}, damping: 0.4}}
  wheel: {{type: torque, body: bus, frame: world, direction: [0, 0, 1], profile: 1 N*m, channel: torque}}
sensors:
  bend: {{type: angle, joint: hinge, axis: rot_z}}
  gyro: {{type: rate, body: bus}}
""", encoding="utf-8")
        linear = self.linearize()
        together = mass * panel / (mass + panel) * (hinge + arm)
        acceleration = 1 / (inertia + own + together * (hinge + arm))
        wanted = -(own + arm * together) * acceleration / stiffness
        gains = {output["name"]: row[0] for output, row in zip(linear["outputs"], linear["gains"])}
        self.assertAlmostEqual(gains["sensor.bend"], wanted, delta=1e-7 * abs(wanted))
        self.assertIsNone(gains["sensor.gyro.z"])
        self.assertAlmostEqual(gains["sensor.gyro.x"], 0, delta=1e-9)
        text = self.run_ok(UNLATCH, "linearize", self.plant).stdout
        self.assertRegex(text, r"12 poles at 0.*free motions")
        self.assertRegex(text, rf"torque to sensor.bend +{wanted:.6g} rad per N m\n  1 gain")

    def test_its_files_are_read_by_numpy_and_as_a_matlab_file(self):
        linear = self.linearize("--at", "0.1")
        self.run_ok(UNLATCH, "linearize", self.plant, "--at", "0.1", "--out", self.folder / "plant.npz")
        with np.load(self.folder / "plant.npz") as file:
            for name in "ABCD":
                np.testing.assert_array_equal(file[name], linear[name])
            np.testing.assert_array_equal(file["gains"], linear["gains"])
            np.testing.assert_array_equal(file["poles"], linear["poles"])
            self.assertEqual(list(file["states"]), [state["name"] for state in linear["states"]])
        self.run_ok(UNLATCH, "linearize", self.plant, "--at", "0.1", "--out", self.folder / "plant.mat")
        found = read_mat((self.folder / "plant.mat").read_bytes())
        for name in "ABCD":
            np.testing.assert_array_equal(found[name], linear[name])
        np.testing.assert_array_equal(found["gains"], linear["gains"])
        self.assertEqual([text.rstrip() for text in found["states"]], [state["name"] for state in linear["states"]])

    def test_an_event_names_the_state(self):
        self.assertEqual(self.linearize("--at", "event:early")["t"], 0.25)

    def test_the_example_of_its_help_works(self):
        example = next(line for line in self.run_ok(UNLATCH, "linearize", "--help").stdout.splitlines() if "--at event:" in line)
        words = [str(SOURCE / word) if word.startswith("hil/") else word for word in example.split()[1:]]
        words[-1] = str(self.folder / words[-1])
        self.run_ok(UNLATCH, *words)
        self.assertIn("A", read_mat(Path(words[-1]).read_bytes()))

    def test_a_time_may_have_its_unit(self):
        self.assertEqual(self.linearize("--at", "250 ms"), self.linearize("--at", "0.25"))
        self.assertEqual(call(UNLATCH, "linearize", self.plant, "--at", "2 m").returncode, 2)

    def test_wrong_names_are_refused_with_those_that_are_there(self):
        for options, text in ((("--at", "event:erly"), "'erly'; did you mean 'early'"), (("--inputs", "thrust"), "there are: torque"),
                              (("--outputs", "sensor.rate"), "sensor.angle"), (("--at", "never"), "neither a time"),
                              (("--loop", "torque=sensor.angle"), "CHANNEL=GAIN*OUTPUT"),
                              (("--loop", "torque=1*sensor.angles"), "'sensor.angles'; did you mean 'sensor.angle'"),
                              (("--loop", "torque=1e400*sensor.angle"), "too large"),
                              (("--at", "9"), "after the end of the run, 2 s")):
            done = call(UNLATCH, "linearize", self.plant, *options)
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn(text, done.stderr)

    # u = -(k angle + d speed) in continuous time with a delay: the phase margin where |k + i d w| = |plant|^-1.
    def test_margins_of_a_continuous_loop_are_those_of_its_closed_form(self):
        k, d, delay = 30.0, 9.0, 0.02
        loop = self.linearize("--loop", f"torque={k}*sensor.angle+{d}*sensor.speed", "--delay", f"{delay}")["loops"][0]
        self.assertTrue(loop["stable"])

        def open_loop(w):
            s = 1j * w
            return (k + d * s) / (s * s + DAMPING * s + STIFFNESS) * np.exp(-s * delay)

        w = loop["phase"]["at"]
        self.assertAlmostEqual(abs(open_loop(w)), 1, places=6)
        self.assertAlmostEqual(abs(np.angle(-open_loop(w))), loop["phase"]["value"], places=6)
        w = loop["gain"]["at"]
        self.assertAlmostEqual(np.angle(-open_loop(w)), 0, places=6)
        self.assertAlmostEqual(1 / abs(open_loop(w)), loop["gain"]["value"], places=5)
        for factor, stable in ((0.99, True), (1.01, False)):
            gain = factor * loop["gain"]["value"]
            again = self.linearize("--loop", f"torque={gain * k}*sensor.angle+{gain * d}*sensor.speed", "--delay", f"{delay}")
            self.assertEqual(again["loops"][0]["stable"], stable, factor)

    # A mass on a rail, u = -(k x + d v), sampled: by the exact discrete plant (T^2/2m, T/m) and the roots of its polynomial.
    def write_mass(self, mass=2.0, sensors="", extra=""):
        self.plant.write_text(f"""unlatch: 1
name: mass
step: {{dt: 1 ms, until: 1}}
channels: {{f: {{initial: 0, range: [-50, 50], unit: N}}}}
bodies: {{b: {{mass: {mass}, inertia: [1, 1, 1]}}}}
joints: {{rail: {{between: [ground, b], modes: {{h: {{kind: prismatic, axis: x}}}}, mode: h}}}}
elements:
  m: {{type: force, body: b, frame: world, direction: [1, 0, 0], profile: 1 N, channel: f}}
{extra}sensors:
  x: {{type: displacement, joint: rail, axis: x{sensors}}}
  v: {{type: speed, joint: rail, axis: x}}
""", encoding="utf-8")

    def calc_roots(self, k, d, mass, period, delay, factor=1.0):
        # z^(m+1) (z - 1)^2 + (numerator of the plant with its two held parts)
        whole, rest = divmod(round(delay / period * 1e9), 10**9)
        late, f = int(whole), rest / 1e9 * period

        def held(t):  # position and speed after a force of 1 N during t, at its end
            return np.array([t * t / 2, t]) / mass
        newer = held(period - f)
        older = held(period) - newer
        state = np.array([[1.0, period], [0.0, 1.0]])
        size = 2 + late + 1
        A = np.zeros((size, size))  # x, v, then u of 1, 2, ... late + 1 periods ago
        A[:2, :2] = state
        gain = -factor * np.array([k, d])
        if late == 0:
            A[:2, :2] += np.outer(newer, gain)
        else:
            A[:2, 2 + late - 1] = newer
        A[:2, 2 + late] += older
        A[2, :2] = gain
        for i in range(1, late + 1):
            A[2 + i, 2 + i - 1] = 1
        return np.linalg.eigvals(A)

    def test_the_gain_margin_of_a_sampled_loop_at_half_the_sampling_frequency_is_found(self):
        self.write_mass()
        loop = self.linearize("--loop", "f=200*sensor.x+30*sensor.v", "--period", "0.1")["loops"][0]
        self.assertTrue(loop["stable"])
        self.assertAlmostEqual(loop["gain"]["value"], 4 / 3, places=6)
        self.assertAlmostEqual(loop["gain"]["at"], math.pi / 0.1, places=6)

    def test_margins_of_sampled_loops_with_any_delay_are_those_of_their_polynomials(self):
        mass = 2.0
        self.write_mass(mass)
        for k, d, period, delay in ((20, 9, 0.1, 0), (20, 9, 0.1, 0.03), (20, 9, 0.1, 0.1), (20, 9, 0.1, 0.25), (3, 4, 0.01, 0.0025),
                                    (3, 4, 0.001, 0.3), (200, 30, 0.1, 0.02), (2, 3, 1e-6, 1e-3)):
            text = f"f={k}*sensor.x+{d}*sensor.v"
            loop = self.linearize("--loop", text, "--period", repr(period), "--delay", repr(delay))["loops"][0]
            if delay / period > 500:  # too large for a dense matrix: continuous but for a period in 1e6
                continuous = self.linearize("--loop", text, "--delay", repr(delay + period / 2))["loops"][0]
                for name in ("gain", "phase", "delay"):
                    self.assertAlmostEqual(loop[name]["value"] / continuous[name]["value"], 1, delta=1e-4, msg=name)
                continue
            radius = max(abs(self.calc_roots(k, d, mass, period, delay)))
            self.assertEqual(loop["stable"], bool(radius < 1), (k, d, period, delay, radius))
            for name in ("gain", "drop"):
                if loop[name]:  # there a root crosses the unit circle
                    roots = abs(self.calc_roots(k, d, mass, period, delay, loop[name]["value"]))
                    self.assertLess(min(abs(roots - 1)), 1e-7, (name, k, d, period, delay))

    # The hold between samples moves with the command, so that the phase margin over its frequency is not the delay (by up to a fifth).
    def test_a_sampled_loop_bears_its_delay_margin_and_no_more(self):
        self.write_mass(3.5748, extra="  s: {type: joint_spring, joint: rail, axis: x, stiffness: 755.4732, damping: 0.7398, implicit: false}\n")
        text, period = "f=949.689*sensor.x+55.956*sensor.v", 0.04194
        for delay in (0, 0.005):
            margin = self.linearize("--loop", text, "--period", str(period), "--delay", str(delay))["loops"][0]["delay"]["value"]
            self.assertAlmostEqual(delay + margin, 0.0174224, delta=1e-6)
            for factor, stable in ((0.999, True), (1.001, False)):
                again = self.linearize("--loop", text, "--period", str(period), "--delay", repr(delay + factor * margin))["loops"][0]
                self.assertEqual(again["stable"], stable, (delay, factor))

    def test_a_long_delay_is_exact_and_what_cannot_be_resolved_is_refused(self):
        self.write_mass()
        # v' = -(3/2) v(t - d): stable below d = pi/2 / 1.5, a factor of 1.5 at most by Padé's approximation
        for delay, stable in ((1.04, True), (1.05, False)):
            loop = self.linearize("--loop", "f=3*sensor.v", "--delay", str(delay))["loops"][0]
            self.assertEqual(loop["stable"], stable, delay)
        for options, text in ((("--period", "1e-300"), "at least 1e-9 s"), (("--delay", "1e9"), "too long beside the motion")):
            done = call(UNLATCH, "linearize", self.plant, "--loop", "f=3*sensor.v", *options)
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn(text, done.stderr)

    # theta'' = a theta + u: stable with k > a, and the gain may fall to a/k, at a frequency of 0.
    def test_the_gain_of_an_unstable_plant_may_fall_to_what_holds_it_at_rest(self):
        self.plant.write_text(PENDULUM.replace("[9.81, 0, 0]", "[-9.81, 0, 0]"), encoding="utf-8")
        loop = self.linearize("--loop", "torque=40*sensor.angle+9*sensor.speed")["loops"][0]
        self.assertTrue(loop["stable"])
        self.assertAlmostEqual(loop["drop"]["value"], STIFFNESS / 40, places=6)
        self.assertEqual(loop["drop"]["at"], 0)
        self.assertFalse(self.linearize("--loop", "torque=14*sensor.angle+9*sensor.speed")["loops"][0]["stable"])

    # Speed and place of a damped mass: poles at 0 and at -c/m, with c/m far below the cube root of the errors.
    def test_a_slow_pole_is_no_pole_at_0_and_its_gains_are_finite(self):
        damping = 1e-3
        self.write_mass(extra=f"  c: {{type: joint_spring, joint: rail, axis: x, damping: {damping}}}\n"
                        "  k: {type: joint_spring, joint: rail, axis: x, stiffness: 0}\n")
        linear = self.linearize()
        self.assertAlmostEqual(linear["poles"][1][0], -damping / 2, delta=1e-9)
        self.assertLessEqual(math.hypot(*linear["poles"][0]), linear["poles_error"][0])
        self.assertGreater(damping / 2, linear["poles_error"][1])
        self.assertIsNone(linear["gains"][0][0])
        self.assertAlmostEqual(linear["gains"][1][0] * damping, 1, delta=1e-5)
        self.assertIn("1 pole at 0", self.run_ok(UNLATCH, "linearize", self.plant).stdout)

    def test_what_a_sensor_has_beside_its_ideal_value_is_said(self):
        self.write_mass(sensors=", errors: {delay: 3, scale: 0.5}")
        self.assertEqual(self.linearize()["left_out"], ["sensor.x: 3 samples late, scale 0.5"])
        self.assertIn("note: not in y: sensor.x: 3 samples late", self.run_ok(UNLATCH, "linearize", self.plant).stdout)
        self.assertEqual(self.linearize("--outputs", "sensor.v")["left_out"], [])

    # The loop of the shipped script, which has its plant from the scenario's text: all chambers swing alike about x.
    def test_margins_of_the_boosters_attitude_loop_are_those_of_its_script(self):
        import loop_margins  # noqa: E402
        script = next(loop for loop in loop_margins.list_loops() if loop.name == "x, boosters tied")
        wanted = script.calc_margins()
        # q.x is half the angle; one chamber has a quarter of the effect of four
        text = f"swing1={4 * 2 * script.attitude}*sensor.attitude.x+{4 * script.rate}*sensor.gyro.x"
        done = self.run_ok(UNLATCH, "linearize", SOURCE / "hil/scenarios/boosters/attitude-loop.yaml", "--inputs", "swing1",
                           "--outputs", "sensor.attitude.*,sensor.gyro.*", "--loop", text, "--period", str(script.period),
                           "--delay", str(script.late * script.period), "--json", "-")
        loop = json.loads(done.stdout)["loops"][0]
        self.assertTrue(loop["stable"])
        # the script leaves products of rates out, and turns about the centre of mass at rest
        for name in ("gain", "phase", "delay"):
            self.assertAlmostEqual(loop[name]["value"] / wanted[name], 1, delta=1e-3, msg=name)
        self.assertAlmostEqual(loop["phase"]["at"] / wanted["phase_at"], 1, delta=1e-3)
        self.assertGreater(math.degrees(loop["phase"]["value"]), 40)


def read_mat(data):
    """The matrices and texts of a MAT file, version 4, by its published layout."""
    out, at = {}, 0
    while at < len(data):
        kind, rows, columns, imaginary, length = np.frombuffer(data, "<i4", 5, at)
        name = data[at + 20:at + 20 + length - 1].decode()
        at += 20 + length
        values = np.frombuffer(data, "<f8", rows * columns, at).reshape((rows, columns), order="F")
        at += 8 * rows * columns * (2 if imaginary else 1)
        out[name] = ["".join(chr(int(c)) for c in row) for row in values] if kind == 1 else values
    return out


if __name__ == "__main__":
    main()
