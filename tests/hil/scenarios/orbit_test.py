#!/usr/bin/env python3
"""A satellite leaves its upper stage in orbit: against Clohessy and Wiltshire, and an integration that is independent of the kernel. Run by ctest:

    orbit_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import math

from processes import SCENARIOS, UNLATCH, ProcessTest, main

ORBIT, DRAG = SCENARIOS / "orbit/scenario.yaml", SCENARIOS / "orbit/drag.yaml"
MU, RADIUS, J2, RATE, HEIGHT = 3.986004418e14, 6378137.0, 1.08262982e-3, 7.292115e-5, 300e3
FREE, END = 10.0, 5440.0  # s: the spring has done its work; the end
POINTS = ["--set", "environment.gradient_torque=false"]  # bodies are points to the references

NONLINEAR = 3.0   # m: the square of 3.6 km by the radius is 2 m, which the linear equations leave out
ROUNDING = 5e-6   # m of 4 km: 5430 steps of the reference with numbers of 6.7e6 m, and 1e-9 m where it starts


def add(a, k, b):
    return [x + k * y for x, y in zip(a, b)]


def integrate(y, t, end, accelerate, step=1.0):
    """Runge–Kutta of the fourth order; y: position and velocity."""
    def flow(time, state):
        return state[3:] + accelerate(time, state[:3], state[3:])
    steps = round((end - t) / step)
    h = (end - t) / steps
    for i in range(steps):
        now = t + i * h
        a = flow(now, y)
        b = flow(now + h / 2, add(y, h / 2, a))
        c = flow(now + h / 2, add(y, h / 2, b))
        d = flow(now + h, add(y, h, c))
        y = [x + h / 6 * (ka + 2 * kb + 2 * kc + kd) for x, ka, kb, kc, kd in zip(y, a, b, c, d)]
    return y


def fall(j2):
    def accelerate(_, r, __):
        d2 = sum(x * x for x in r)
        d = math.sqrt(d2)
        k, s2 = 1.5 * j2 * (RADIUS / d) ** 2, r[2] * r[2] / d2
        return [-MU / d**3 * x * (1 + k * ((1 if i < 2 else 3) - 5 * s2)) for i, x in enumerate(r)]
    return accelerate


def get_state(body):
    return body["p"] + body["v"]


class OrbitTest(ProcessTest):
    def sample(self, scenario, times, *options):
        code = 1 if "--until" in options else 0  # of a revolution that is cut short the last requirement is not met
        return self.run_json(UNLATCH, "run", scenario, "--sample", ",".join(map(str, times)), *POINTS, *options, code=code)["samples"]

    def test_one_revolution_is_that_of_clohessy_and_wiltshire(self):
        first, last = [s["quantities"] for s in self.sample(ORBIT, [FREE, END], "--set", "environment.planet.j2=0")]
        n = math.sqrt(MU / (RADIUS + HEIGHT) ** 3)
        a = n * (END - FREE)
        s, c = math.sin(a), math.cos(a)
        x, y, z, u, v, w = (first[key] for key in ("radial", "along", "across", "radial_speed", "along_speed", "across_speed"))
        self.assertAlmostEqual(last["radial"], (4 - 3 * c) * x + s / n * u + 2 / n * (1 - c) * v, delta=NONLINEAR)
        self.assertAlmostEqual(last["along"], 6 * (s - a) * x + y - 2 / n * (1 - c) * u + (4 * s - 3 * a) / n * v, delta=NONLINEAR)
        self.assertAlmostEqual(last["across"], c * z + s / n * w, delta=NONLINEAR)
        self.assertGreater(abs(last["along"]), 3000)

    def test_it_flies_as_an_independent_integration(self):
        for j2 in (0, J2):
            options = ["--set", f"environment.planet.j2={j2}"]
            # At the planet's centre places are absolute: the start of the reference.
            start = self.sample(ORBIT, [FREE], "--until", "10", "--set", "environment.origin=centre", *options)[-1]["bodies"]
            found = self.sample(ORBIT, [END], *options)[-1]
            ends = {name: integrate(get_state(body), FREE, END, fall(j2)) for name, body in start.items()}
            expected = [a - b for a, b in zip(ends["satellite"][:3], ends["stage"][:3])]
            bodies = found["bodies"]
            for axis in range(3):
                self.assertAlmostEqual(bodies["satellite"]["p"][axis] - bodies["stage"]["p"][axis], expected[axis], delta=ROUNDING)

    # An exponential atmosphere, so that the reference needs no table: ln p and ln ρ are straight.
    def test_drag_of_one_body_is_that_of_an_independent_integration(self):
        low, high, top, scale = 250e3, 350e3, 1e-9, 50e3
        table = f"{{altitude: [{low}, {high}], density: [{top}, {top * math.exp(-(high - low) / scale)}], pressure: [1e-4, 1e-5]}}"
        options = ["--set", f"environment.atmosphere={table}", "--set", "environment.planet.flattening=0", "--set", "environment.planet.j2=0"]
        start = self.sample(DRAG, [FREE], "--until", "10", "--set", "environment.origin=centre", *options)[-1]["bodies"]
        found = self.sample(DRAG, [END], *options)[-1]["bodies"]

        def brake(t, r, v):
            density = top * math.exp(-(math.sqrt(sum(x * x for x in r)) - RADIUS - low) / scale)
            through = [v[0] + RATE * r[1], v[1] - RATE * r[0], v[2]]
            speed = math.sqrt(sum(x * x for x in through))
            return [g - 0.5 * density * speed * 12 * 2.2 / 1600 * u for g, u in zip(fall(0)(t, r, v), through)]
        stage = integrate(get_state(start["stage"]), FREE, END, brake)
        satellite = integrate(get_state(start["satellite"]), FREE, END, fall(0))
        for axis in range(3):
            self.assertAlmostEqual(found["satellite"]["p"][axis] - found["stage"]["p"][axis], satellite[axis] - stage[axis], delta=ROUNDING)

    # 7 km in a revolution: what is far behind in the end was near at first.
    def test_the_air_brakes_the_stage_alone(self):
        without, braked = (self.sample(path, [END])[-1]["quantities"] for path in (ORBIT, DRAG))
        self.assertGreater(abs(without["along"] - braked["along"]), 100)

    def test_recordings_replay_and_checkpoints_resume(self):
        log, point = self.folder / "orbit.log", self.folder / "orbit.state"
        whole = self.run_json(UNLATCH, "run", DRAG, "--until", "400", "--log", log, code=1)
        self.assertEqual(self.run_json(UNLATCH, "replay", log, code=1)["hash"], whole["hash"])
        self.run_ok(UNLATCH, "run", DRAG, "--until", "200", "--checkpoint", "200", point, code=1)
        self.assertEqual(self.run_json(UNLATCH, "run", DRAG, "--until", "400", "--resume", point, code=1)["hash"], whole["hash"])

    def test_a_start_that_cannot_be_is_refused_with_its_place(self):
        text = ORBIT.read_text()
        for old, new, part in (("planet: {radius: radius, mu: mu}        # WGS-84", "planet: wsg84", "did you mean 'wgs84'"),
                               ("altitude: height\n", "altitud: height\n", "did you mean 'altitude'"),
                               ("atmosphere: us1976", "atmosphere: {altitude: [0, 0], density: [1, 1], pressure: [1, 1]}", "do not rise"),
                               ("speed: sqrt(mu / (radius + height))", "speed: 12 km/s", "follows no ellipse")):
            self.assertIn(old, text)
            path = self.folder / "wrong.yaml"
            path.write_text(text.replace(old, new))
            result = self.run_ok(UNLATCH, "check", path, code=2)
            self.assertIn(part, result.stdout + result.stderr, new)


if __name__ == "__main__":
    main()
