#!/usr/bin/python3
"""Tight-tolerance references of the boosters' cyclogram and its failures, independent of unlatch's code and scenario files.

Five bodies in Cartesian coordinates, angular velocities in inertial axes, a dense KKT matrix solved by LAPACK, SciPy's
DOP853 at rtol 1e-12, events by root-finding on its dense output. Physical constants from tests/data/soyuz_nominal.json; the
preparatory stage as hil/scenarios/boosters/README.md describes it.

    boosters_reference.py [CASE]...    writes tests/data/boosters_cyclogram.json, all runs or these anew; needs python3-scipy; some minutes
"""
import json
import math
import pathlib
import sys

import numpy as np
from scipy.integrate import solve_ivp

DATA = pathlib.Path(__file__).parent.parent / "data"
P = json.loads((DATA / "soyuz_nominal.json").read_text())["params"]
END, SAMPLES = 2.5, [0.0, 0.2, 0.4, 0.6, 0.9, 1.2, 1.25, 1.28, 1.3, 1.4, 1.7, 2.0, 2.5]
TOUCH = {"release": 1e-4, "liftoff": 1e-4, "contact": 1e-12}  # N, N, m: events of mirror images are simultaneous
TIED, HINGE, SLIDER, FREE = range(4)
ROWS = {TIED: "xyzabc", HINGE: "xyzac", SLIDER: "yzac", FREE: ""}  # a, b, c: rotation about x, y, z of the node
# Times of the cyclogram, s.
THROTTLE, THROTTLED, VERNIERS, VERNIERS_OFF, RUDDERS, NEUTRAL, TIES, CUTOFF = 0.1, 0.2, 0.25, 0.29, 0.3, 0.4, 0.45, 0.5
# The nozzle of a fuel tank, in booster axes: N, s, m.
FUEL_JET = {"nozzle_force": 4000.0, "nozzle_tau": 0.05, "nozzle_point": [2.0, 0, 0], "nozzle_dir": [-0.8, 0.6, 0]}
# Propellant burnt, kg/(N s), and the remaining part of mass and inertia for each kg of it; central field, m3/s2; m/s along x.
CONSUMPTION = {"core": 1 / (315 * 9.80665), "boosters": 1 / (310 * 9.80665)}
MU, SPEED = 398600.4418e9, 1750.0
# The core's attitude loop: s, ticks of 1 ms, N, m; rad/rad and s, about x, y, z; parts of thrust, rad.
PERIOD, LOOP_DELAY, LOOP_END = 0.01, 20, 8.0
CHAMBER, CHAMBER_X, CHAMBER_RADIUS, SWING = 35000.0, -19.5, 1.025, 0.6
ATTITUDE_GAIN, RATE_GAIN = np.array([3.0, 35, 35]), np.array([2.0, 24, 24])
MISALIGNED = np.array([1, 0.002, 0.001])
FULL, VERNIER, TRIM = P["boosters"][0]["thrust0"] / 0.84, 70000.0, 100.0
CASES = {
    "cyclogram": {},
    "late-valve": {"delay": {0: 0.412}},
    "uncut-tie": {"uncut": {1}},
    "imbalance": {"thrust": {0: 1.05, 2: 0.95}},
    "dead-nozzle": {"dead": {0}},
    # dispersed.yaml: no preparatory stage, individual tail-offs (N, s).
    # both-nozzles.yaml: with the nozzles of the fuel tanks, too.
    "both-nozzles": {"fuel": True},
    "oxidizer-shut": {"fuel": True, "dead": {0}},
    "fuel-shut": {"fuel": True, "fuel_dead": {0}},
    "both-shut": {"fuel": True, "dead": {0}, "fuel_dead": {0}},
    # open-loop.yaml and attitude-loop.yaml: commanded by flight software, whose commands take 20 ms.
    "open-loop": {"fuel": True, "thrust": {0: 1.05, 2: 0.95}, "loop": 0},
    "attitude-loop": {"fuel": True, "thrust": {0: 1.05, 2: 0.95}, "loop": 1},
    # variable-mass.yaml, central-field.yaml, no-assumptions.yaml: without simplifications of the paper.
    "variable-mass": {"burns": True},
    "central-field": {"central": True},
    "no-assumptions": {"burns": True, "central": True},
    "dispersed": {"tails": [(300000, 0.35), (306000, 0.33), (294000, 0.37), (303000, 0.39)], "until": 2.0},
}


def rotation(q):
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def quaternion(m):
    w = np.sqrt(max(0, 1 + np.trace(m))) / 2
    if w > 0.1:
        return np.array([w, (m[2, 1] - m[1, 2]) / (4 * w), (m[0, 2] - m[2, 0]) / (4 * w), (m[1, 0] - m[0, 1]) / (4 * w)])
    x = np.sqrt(1 + m[0, 0] - m[1, 1] - m[2, 2]) / 2  # a half turn
    return np.array([(m[2, 1] - m[1, 2]) / (4 * x), x, (m[0, 1] + m[1, 0]) / (4 * x), (m[0, 2] + m[2, 0]) / (4 * x)])


def ramp(t, begin, end, to):
    return 1 + (to - 1) * min(1, max(0, (t - begin) / (end - begin)))


class Boosters:
    tolerance = 1e-12  # of the integration

    def __init__(self, case):
        self.mass = [P["core"]["m"]] + [b["m"] for b in P["boosters"]]
        self.inertia = [np.array(P["core"]["J"])] + [np.array(b["J"]) for b in P["boosters"]]
        self.tails, self.until, self.samples = case.get("tails"), case.get("until", END), SAMPLES
        self.mode, self.t_contact, self.t_open = [HINGE if self.tails else TIED] * 4, [None] * 4, [np.inf] * 4
        self.thrust = [case.get("thrust", {}).get(k, 1) for k in range(4)]
        self.delay = [case.get("delay", {}).get(k, P["nozzle_delay"]) for k in range(4)]
        self.uncut = case.get("uncut", set())
        # Jets of all boosters, each with the set of boosters on which it stays shut.
        self.jets = [(None, case.get("dead", set()))] + ([(FUEL_JET, case.get("fuel_dead", set()))] if "fuel" in case else [])
        self.burns, self.centre = "burns" in case, None
        velocity = np.zeros(3)
        if "central" in case:  # as strong as the uniform field at the core's initial position
            field = np.array(P["gravity"])
            self.centre = field / np.linalg.norm(field) * np.sqrt(MU / np.linalg.norm(field))
            velocity = np.array([SPEED, 0, 0])
        self.nodes, states = [], [np.concatenate([np.zeros(3), [1, 0, 0, 0], velocity, np.zeros(3)])]
        ex = np.array([1.0, 0, 0])
        for b in P["boosters"]:
            er = np.array([0, np.cos(b["azimuth"]), np.sin(b["azimuth"])])
            nx = np.cos(b["beta"]) * ex + np.sin(b["beta"]) * er
            nz = -np.sin(b["beta"]) * ex + np.cos(b["beta"]) * er
            hinge = b["hinge_axial"] * ex + b["hinge_radius"] * er
            self.nodes.append((hinge, np.stack([nx, np.cross(nz, nx), nz])))
            xb = np.cos(b["delta"]) * ex - np.sin(b["delta"]) * er
            yb = np.sin(b["delta"]) * ex + np.cos(b["delta"]) * er
            c = np.stack([xb, yb, np.cross(xb, yb)], axis=1)
            states.append(np.concatenate([hinge - c @ np.array(b["r_nose"]), quaternion(c), velocity, np.zeros(3)]))
        self.start = np.concatenate([*states, np.zeros(5)])  # last entries: burnt mass

    def forces(self, t, k, c):
        """Returns force and moment about the centre of mass of booster k, inertial axes, without gravity."""
        b = P["boosters"][k]
        main, vernier, trim = self.calc_thrusts(t, k)
        tail = main * np.array(b["thrust_dir"]) + [vernier, 0, trim]
        if self.tails:
            tail = self.tails[k][0] * np.exp(-t / self.tails[k][1]) * np.array(b["thrust_dir"])
        force, moment = tail.copy(), np.cross(b["thrust_point"], tail)
        for nozzle, shut in self.jets:
            if self.t_open[k] <= self.now_open and k not in shut:
                n = nozzle or b
                jet = n["nozzle_force"] * (1 - np.exp(-(t - self.t_open[k]) / n["nozzle_tau"])) * np.array(n["nozzle_dir"])
                force, moment = force + jet, moment + np.cross(n["nozzle_point"], jet)
        return c @ force, c @ moment

    def calc_load(self, t, i, s, c):
        """Returns force and moment about the centre of mass of body i, inertial axes, without gravity."""
        if i > 0:
            return self.forces(t, i - 1, c[i])
        force, moment = self.calc_core_load()
        return c[0] @ force, c[0] @ moment

    def calc_gravity(self, place):
        if self.centre is None:
            return np.array(P["gravity"])
        return MU * (self.centre - place) / np.linalg.norm(self.centre - place)**3

    def calc_flows(self, t):
        """Returns the mass burnt in a second by each body."""
        if not self.burns:
            return np.zeros(5)
        thrusts = [sum(self.calc_thrusts(t, k)[:2]) for k in range(4)]
        return np.array([P["core"]["thrust"] * CONSUMPTION["core"], *(f * CONSUMPTION["boosters"] for f in thrusts)])

    def calc_thrusts(self, t, k):
        """Thrusts of the main engine and of the verniers, and the force of the rudder, of booster k."""
        throttle, vernier, rudder = self.calc_commands(t)
        main = FULL * self.thrust[k] * throttle
        if t >= self.phase_cutoff:
            main = P["boosters"][k]["thrust0"] * self.thrust[k] * np.exp(-(t - self.phase_cutoff) / P["boosters"][k]["thrust_tau"])
        return main, VERNIER * vernier, (TRIM if k % 2 == 0 else -TRIM) * rudder

    def calc_commands(self, t):
        """Returns parts of the main thrust, of the verniers' and of the rudders' force before the cut-off."""
        return ramp(t, THROTTLE, THROTTLED, 0.84), ramp(t, VERNIERS, VERNIERS_OFF, 0), ramp(t, RUDDERS, NEUTRAL, 0)

    def calc_core_load(self):
        """Returns force and moment about the centre of mass of the core, its axes."""
        return np.array([P["core"]["thrust"], 0, 0]), np.zeros(3)

    def solve(self, t, y):
        """Returns accelerations (5 × 6, angular ones in inertial axes) and multipliers by (booster, row)."""
        s, left = y[:65].reshape(5, 13), 1 - y[65:] / self.mass  # mass and inertia decrease in the same proportion
        c = [rotation(s[i, 3:7]) for i in range(5)]
        w = s[:, 10:13]
        m, f = np.zeros((30, 30)), np.zeros(30)
        for i in range(5):
            j = left[i] * c[i] @ self.inertia[i] @ c[i].T
            m[6 * i:6 * i + 3, 6 * i:6 * i + 3] = left[i] * self.mass[i] * np.eye(3)
            m[6 * i + 3:6 * i + 6, 6 * i + 3:6 * i + 6] = j
            force, moment = self.calc_load(t, i, s, c)
            f[6 * i:6 * i + 3] = force + left[i] * self.mass[i] * self.calc_gravity(s[i, :3])
            f[6 * i + 3:6 * i + 6] = moment - np.cross(w[i], j @ w[i])
        rows, rhs, names = [], [], []
        for k in range(4):
            _, n_core = self.nodes[k]
            b = k + 1
            rho = c[b] @ np.array(P["boosters"][k]["r_nose"])
            arm = s[b, :3] + rho - s[0, :3]
            arm_rate = s[b, 7:10] + np.cross(w[b], rho) - s[0, 7:10]
            for row in ROWS[self.mode[k]]:
                g = np.zeros(30)
                n = c[0] @ n_core["xyzabc".index(row) % 3]
                n_rate = np.cross(w[0], n)
                if row in "xyz":
                    g[:3], g[6 * b:6 * b + 3] = -n, n
                    g[3:6], g[6 * b + 3:6 * b + 6] = np.cross(n, arm), np.cross(rho, n)
                    known = n @ np.cross(w[b], np.cross(w[b], rho)) + 2 * n_rate @ arm_rate + np.cross(w[0], n_rate) @ arm
                else:
                    g[3:6], g[6 * b + 3:6 * b + 6] = -n, n
                    known = n_rate @ (w[b] - w[0])
                rows.append(g)
                rhs.append(-known)
                names.append((k, row))
        if not rows:
            return np.linalg.solve(m, f).reshape(5, 6), {}
        g = np.array(rows)
        kkt = np.block([[m, -g.T], [g, np.zeros((len(g), len(g)))]])
        x = np.linalg.solve(kkt, np.concatenate([f, rhs]))
        return x[:30].reshape(5, 6), dict(zip(names, x[30:]))

    def rate(self, t, y):
        s, out = y[:65].reshape(5, 13), np.zeros((5, 13))
        a, _ = self.solve(t, y)
        for i in range(5):
            w, q = s[i, 10:13], s[i, 3:7]
            out[i, :3], out[i, 7:10], out[i, 10:13] = s[i, 7:10], a[i, :3], a[i, 3:]
            out[i, 3] = -0.5 * w @ q[1:]
            out[i, 4:7] = 0.5 * (q[0] * w + np.cross(w, q[1:]))
        return np.concatenate([out.ravel(), self.calc_flows(t)])

    def slip(self, y, k):
        s = y[:65].reshape(5, 13)
        hinge, n = self.nodes[k]
        nose = s[k + 1, :3] + rotation(s[k + 1, 3:7]) @ np.array(P["boosters"][k]["r_nose"])
        return n[0] @ (rotation(s[0, 3:7]).T @ (nose - s[0, :3]) - hinge)

    def guards(self):
        """Returns (name, booster, function that rises through zero)."""
        out = []
        for k in range(4):
            if self.mode[k] == HINGE:
                out.append(("release", k, lambda t, y, k=k: self.solve(t, y)[1][k, "x"]))
            if self.mode[k] == SLIDER:
                out.append(("liftoff", k, lambda t, y, k=k: -self.solve(t, y)[1][k, "z"]))
            if self.mode[k] in (SLIDER, FREE) and self.t_contact[k] is None:
                out.append(("contact", k, lambda t, y, k=k: -P["kr_distance"] - self.slip(y, k)))
        return out

    def act(self, name, k, t):
        if name == "release":
            self.mode[k] = SLIDER
        elif name == "liftoff":
            self.mode[k] = FREE
        else:
            self.t_contact[k] = t
            self.t_open[k] = self.calc_opening(t, k)

    def calc_opening(self, t, k):
        return t + self.delay[k]

    def list_times(self):
        """Times of switching."""
        return {THROTTLE, THROTTLED, VERNIERS, VERNIERS_OFF, RUDDERS, NEUTRAL, TIES, CUTOFF}

    def switch(self, t, y):
        if t == TIES and not self.tails:
            self.mode = [TIED if k in self.uncut else HINGE for k in range(4)]
        if t == CUTOFF:
            self.phase_cutoff = CUTOFF

    def run(self):
        t, y, events, samples = 0.0, self.start, [], {}
        self.phase_cutoff, self.now_open = np.inf, -1.0
        known = sorted({*self.list_times(), self.until, *self.samples[1:]})
        while True:
            if any(abs(t - s) < 1e-15 for s in self.samples):
                samples[str(t)] = self.describe(y)
            if t >= self.until:
                return events, samples
            self.switch(t, y)
            self.now_open = t
            while True:  # conditions that are true already
                due = [(n, k) for n, k, g in self.guards() if g(t, y) >= 0]
                for n, k in due:
                    events.append([t, n, k + 1])
                    self.act(n, k, t)
                if not due:
                    break
            stop = min([x for x in known if x > t] + [x for x in self.t_open if x > t])
            guards = self.guards()
            functions = []
            for _, _, g in guards:
                def function(u, v, g=g):
                    return g(u, v)
                function.terminal, function.direction = True, 1
                functions.append(function)
            out = solve_ivp(self.rate, (t, stop), y, method="DOP853", rtol=self.tolerance, atol=self.tolerance, events=functions)
            t, y = out.t[-1], out.y[:, -1]
            if out.status == 1:
                due = [(n, k) for n, k, g in guards if g(t, y) >= -TOUCH[n]]
                for n, k in due:
                    events.append([t, n, k + 1])
                    self.act(n, k, t)
            else:
                t = stop

    def describe(self, y):
        bodies = []
        for s in y[:65].reshape(5, 13):
            c = rotation(s[3:7])
            bodies.append([*s[:3], *(s[3:7] / np.linalg.norm(s[3:7])), *s[7:10], *(c.T @ s[10:13])])
        return [[float(x) for x in body] for body in bodies]


class Loop(Boosters):
    """Boosters commanded by flight software: its commands act LOOP_DELAY ticks after the tick to which they respond."""

    def __init__(self, case):
        super().__init__(case)
        self.gain, self.until = case["loop"], LOOP_END
        self.samples = [0.0, 0.1, 0.3, 0.6, 1.0, 1.3, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        self.late = LOOP_DELAY / 1000
        self.swing, self.pending = np.zeros(3), {}

    def calc_commands(self, t):
        return tuple(after if t >= since + self.late - 1e-12 else 1
                     for since, after in ((THROTTLE, 0.84), (VERNIERS, 0), (RUDDERS, 0)))

    def calc_core_load(self):
        # Chamber k at azimuth k 90 degrees from y to z, its force along the circumference.
        force, moment = P["core"]["thrust"] * MISALIGNED, np.cross([CHAMBER_X, 0, 0], P["core"]["thrust"] * MISALIGNED)
        for k in range(4):
            azimuth = k * math.pi / 2
            side = self.swing[1 + k % 2] * (1 if k < 2 else -1)
            jet = CHAMBER * np.clip(self.swing[0] + side, -SWING, SWING) * np.array([0, -math.sin(azimuth), math.cos(azimuth)])
            point = np.array([CHAMBER_X, CHAMBER_RADIUS * math.cos(azimuth), CHAMBER_RADIUS * math.sin(azimuth)])
            force, moment = force + jet, moment + np.cross(point, jet)
        return force, moment

    def calc_opening(self, t, k):
        seen = math.ceil(t * 1000 - 1e-6)  # the first tick with the contact
        return (seen + round(self.delay[k] * 1000) + LOOP_DELAY) / 1000

    def list_times(self):
        switched = {round(t + self.late, 9) for t in (THROTTLE, VERNIERS, RUDDERS, TIES, CUTOFF)}
        return switched | {round(j * PERIOD, 9) for j in range(1, round(self.until / PERIOD))}

    def switch(self, t, y):
        if t == round(TIES + self.late, 9):
            self.mode = [HINGE] * 4
        if t == round(CUTOFF + self.late, 9):
            self.phase_cutoff = t
        tick = round(t * 1000)
        if abs(t * 1000 - tick) > 1e-6 or tick % round(PERIOD * 1000) != 0:
            return
        q, w = y[3:7] / np.linalg.norm(y[3:7]), rotation(y[3:7]).T @ y[10:13]
        error = 2 * math.copysign(1, q[0]) * q[1:]
        self.pending.setdefault(tick + LOOP_DELAY, -self.gain * (ATTITUDE_GAIN * error + RATE_GAIN * w))
        self.swing = self.pending.get(tick, self.swing)


if __name__ == "__main__":
    file = DATA / "boosters_cyclogram.json"
    result = {"about": "tests/references/boosters_reference.py: dense KKT, DOP853 at rtol 1e-12. State: R, q (w x y z, body to "
                       "inertial), V, w in body axes; core, then boosters. Events: t, name, booster"}
    if sys.argv[1:]:
        result = json.loads(file.read_text())
    for name in sys.argv[1:] or CASES:
        case = CASES[name]
        events, samples = (Loop if "loop" in case else Boosters)(case).run()
        result[name] = {"events": events, "samples": samples}
        print(name, events, flush=True)
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in result.items()]
    file.write_text("{" + ",\n".join(lines) + "}\n")
