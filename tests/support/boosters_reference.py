#!/usr/bin/python3
"""Tight-tolerance references of the boosters' cyclogram and its failures, independent of unlatch's code and scenario files.

Five bodies in Cartesian coordinates, angular velocities in inertial axes, a dense KKT matrix solved by LAPACK, SciPy's
DOP853 at rtol 1e-12, events by root-finding on its dense output. Physical constants from tests/data/soyuz_nominal.json; the
preparatory stage as hil/scenarios/boosters/README.md describes it.

    boosters_reference.py    writes tests/data/boosters_cyclogram.json (six runs); needs python3-scipy; some minutes
"""
import json
import pathlib

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
FULL, VERNIER, TRIM = P["boosters"][0]["thrust0"] / 0.84, 70000.0, 100.0
CASES = {
    "cyclogram": {},
    "late-valve": {"delay": {0: 0.412}},
    "uncut-tie": {"uncut": {1}},
    "imbalance": {"thrust": {0: 1.05, 2: 0.95}},
    "dead-nozzle": {"dead": {0}},
    # dispersed.yaml: no preparatory stage, tail-offs of their own (N, s).
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
    def __init__(self, case):
        self.mass = [P["core"]["m"]] + [b["m"] for b in P["boosters"]]
        self.inertia = [np.array(P["core"]["J"])] + [np.array(b["J"]) for b in P["boosters"]]
        self.tails, self.until = case.get("tails"), case.get("until", END)
        self.mode, self.t_contact, self.t_open = [HINGE if self.tails else TIED] * 4, [None] * 4, [np.inf] * 4
        self.thrust = [case.get("thrust", {}).get(k, 1) for k in range(4)]
        self.delay = [case.get("delay", {}).get(k, P["nozzle_delay"]) for k in range(4)]
        self.uncut, self.dead = case.get("uncut", set()), case.get("dead", set())
        self.nodes, states = [], [np.concatenate([np.zeros(3), [1, 0, 0, 0], np.zeros(6)])]
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
            states.append(np.concatenate([hinge - c @ np.array(b["r_nose"]), quaternion(c), np.zeros(6)]))
        self.start = np.concatenate(states)

    def forces(self, t, k, c):
        """Force and moment about the centre of mass of booster k, inertial axes, without gravity."""
        b = P["boosters"][k]
        main = FULL * self.thrust[k] * ramp(t, THROTTLE, THROTTLED, 0.84)
        if t >= self.phase_cutoff:
            main = b["thrust0"] * self.thrust[k] * np.exp(-(t - CUTOFF) / b["thrust_tau"])
        trim = (TRIM if k % 2 == 0 else -TRIM) * ramp(t, RUDDERS, NEUTRAL, 0)
        tail = main * np.array(b["thrust_dir"]) + [VERNIER * ramp(t, VERNIERS, VERNIERS_OFF, 0), 0, trim]
        if self.tails:
            tail = self.tails[k][0] * np.exp(-t / self.tails[k][1]) * np.array(b["thrust_dir"])
        force, moment = tail.copy(), np.cross(b["thrust_point"], tail)
        if self.t_open[k] <= self.now_open:
            jet = b["nozzle_force"] * (1 - np.exp(-(t - self.t_open[k]) / b["nozzle_tau"])) * np.array(b["nozzle_dir"])
            force, moment = force + jet, moment + np.cross(b["nozzle_point"], jet)
        return c @ force, c @ moment

    def solve(self, t, y):
        """Accelerations (5 × 6, angular ones in inertial axes) and multipliers by (booster, row)."""
        s = y.reshape(5, 13)
        c = [rotation(s[i, 3:7]) for i in range(5)]
        w = s[:, 10:13]
        m, f = np.zeros((30, 30)), np.zeros(30)
        for i in range(5):
            j = c[i] @ self.inertia[i] @ c[i].T
            m[6 * i:6 * i + 3, 6 * i:6 * i + 3] = self.mass[i] * np.eye(3)
            m[6 * i + 3:6 * i + 6, 6 * i + 3:6 * i + 6] = j
            if i == 0:
                force, moment = c[0] @ [P["core"]["thrust"], 0, 0], np.zeros(3)
            else:
                force, moment = self.forces(t, i - 1, c[i])
            f[6 * i:6 * i + 3] = force + self.mass[i] * np.array(P["gravity"])
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
        s, out = y.reshape(5, 13), np.zeros((5, 13))
        a, _ = self.solve(t, y)
        for i in range(5):
            w, q = s[i, 10:13], s[i, 3:7]
            out[i, :3], out[i, 7:10], out[i, 10:13] = s[i, 7:10], a[i, :3], a[i, 3:]
            out[i, 3] = -0.5 * w @ q[1:]
            out[i, 4:7] = 0.5 * (q[0] * w + np.cross(w, q[1:]))
        return out.ravel()

    def slip(self, y, k):
        s = y.reshape(5, 13)
        hinge, n = self.nodes[k]
        nose = s[k + 1, :3] + rotation(s[k + 1, 3:7]) @ np.array(P["boosters"][k]["r_nose"])
        return n[0] @ (rotation(s[0, 3:7]).T @ (nose - s[0, :3]) - hinge)

    def guards(self):
        """(name, booster, function that rises through zero)."""
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
            if k not in self.dead:
                self.t_open[k] = t + self.delay[k]

    def run(self):
        t, y, events, samples = 0.0, self.start, [], {}
        self.phase_cutoff, self.now_open = np.inf, -1.0
        known = sorted({THROTTLE, THROTTLED, VERNIERS, VERNIERS_OFF, RUDDERS, NEUTRAL, TIES, CUTOFF, END, *SAMPLES[1:]})
        while True:
            if any(abs(t - s) < 1e-15 for s in SAMPLES):
                samples[str(t)] = self.describe(y)
            if t >= self.until:
                return events, samples
            if t == TIES and not self.tails:
                self.mode = [TIED if k in self.uncut else HINGE for k in range(4)]
            if t == CUTOFF:
                self.phase_cutoff = CUTOFF
            self.now_open = t
            while True:  # what already holds
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
            out = solve_ivp(self.rate, (t, stop), y, method="DOP853", rtol=1e-12, atol=1e-12, events=functions)
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
        for s in y.reshape(5, 13):
            c = rotation(s[3:7])
            bodies.append([*s[:3], *(s[3:7] / np.linalg.norm(s[3:7])), *s[7:10], *(c.T @ s[10:13])])
        return [[float(x) for x in body] for body in bodies]


if __name__ == "__main__":
    result = {"about": "tests/support/boosters_reference.py: dense KKT, DOP853 at rtol 1e-12. State: R, q (w x y z, body to "
                       "inertial), V, w in body axes; core, then boosters. Events: t, name, booster"}
    for name, case in CASES.items():
        events, samples = Boosters(case).run()
        result[name] = {"events": events, "samples": samples}
        print(name, events, flush=True)
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in result.items()]
    (DATA / "boosters_cyclogram.json").write_text("{" + ",\n".join(lines) + "}\n")
