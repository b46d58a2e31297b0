#!/usr/bin/python3
"""Tight-tolerance references of the shipped solar arrays, independent of unlatch's code and of make-array: the motion is
planar, so bodies have x, y and a turn; a dense KKT matrix by least squares (cables of latched hinges are redundant), SciPy's
DOP853 at rtol 1e-12, events by root-finding, rigid latches by the same matrix as a plastic impulse. Many panels tied by cables have
five freedoms however many they are, and are integrated in those. What a latch shock rings in comes from a linear model of the
unfolded array.

    array_reference.py    writes tests/data/array_panels.json; needs python3-scipy
"""
import json
import pathlib

import numpy as np
from scipy.integrate import solve_ivp

MASS, INERTIA = 8.0, 3.3                 # a panel of 1 m; about z
BUS_MASS, BUS_INERTIA, FOLD = 800.0, 280.0, 1.4
EFFORT, STIFFNESS, DAMPING = 0.6, 0.4, 0.05
LATCH, LATCH_DAMPING, CABLE, CABLE_DAMPING = 900.0, 6.0, 150.0, 3.0
CASES = {"scenario": (4, "rigid", "rows", 10.0), "elastic": (4, "elastic", "none", 20.0),
         "elastic-cables": (4, "elastic", "elastic", 20.0), "two": (2, "rigid", "rows", 20.0),
         "eight": (8, "rigid", "rows", 20.0)}
MANY = {"sixteen": (16, [5.0, 18.5]), "thirty-two": (32, [2.0, 34.0]), "sixty-four": (64, [2.0, 62.5])}
TOUCH = 1e-9  # rad; hinges tied by a cable reach zero together


class Array:
    def __init__(self, n, latches, cables):
        self.n, self.latches, self.cables = n, latches, cables
        self.mass = np.repeat([BUS_MASS] + [MASS] * n, 3)
        self.mass[2::3] = [BUS_INERTIA] + [INERTIA] * n
        self.latched = [False] * n
        q, edge = [np.zeros(3)], np.array([1.0, 0])
        for k in range(n):
            turn = FOLD if k % 2 == 0 else -FOLD
            along = np.array([np.cos(turn), np.sin(turn)])
            q.append(np.array([*(edge + along / 2), turn]))
            edge = edge + along
        self.start = np.concatenate([np.concatenate(q), np.zeros(3 * (n + 1))])

    def rows(self, q, v):
        """Returns G and the right-hand side of G a = c."""
        size, g, c = len(q), [], []
        for k in range(self.n):
            a, b = 3 * k, 3 * (k + 1)
            arm_a = (1.0 if k == 0 else 0.5) * np.array([np.cos(q[a + 2]), np.sin(q[a + 2])])
            arm_b = -0.5 * np.array([np.cos(q[b + 2]), np.sin(q[b + 2])])
            for i in range(2):
                row = np.zeros(size)
                row[a + i], row[b + i] = -1, 1
                row[a + 2], row[b + 2] = -np.array([-arm_a[1], arm_a[0]])[i], np.array([-arm_b[1], arm_b[0]])[i]
                g.append(row)
                c.append(arm_b[i] * v[b + 2] ** 2 - arm_a[i] * v[a + 2] ** 2)
            if self.latched[k] and self.latches == "rigid":
                row = np.zeros(size)
                row[a + 2], row[b + 2] = -1, 1
                g.append(row)
                c.append(0)
        if self.cables == "rows":
            for k in range(2, self.n):
                row = np.zeros(size)
                row[3 * (k - 1) + 2], row[3 * (k + 1) + 2] = -1, 1
                g.append(row)
                c.append(0)
        return np.array(g), np.array(c)

    def torques(self, q, v):
        f = np.zeros(len(q))

        def add(base, follower, torque):
            f[3 * base + 2] -= torque
            f[3 * follower + 2] += torque

        for k in range(self.n):
            angle, rate = q[3 * k + 5] - q[3 * k + 2], v[3 * k + 5] - v[3 * k + 2]
            if not self.latched[k]:
                add(k, k + 1, (-EFFORT if k % 2 == 0 else EFFORT) - STIFFNESS * angle - DAMPING * rate)
            elif self.latches == "elastic":
                add(k, k + 1, -LATCH * angle - LATCH_DAMPING * rate)
        if self.cables == "elastic":
            for k in range(2, self.n):
                a, b = 3 * (k - 1) + 2, 3 * (k + 1) + 2
                add(k - 1, k + 1, -CABLE * (q[b] - q[a]) - CABLE_DAMPING * (v[b] - v[a]))
        return f

    def solve(self, g, f, c):
        kkt = np.block([[np.diag(self.mass), -g.T], [g, np.zeros((len(g), len(g)))]])
        return np.linalg.lstsq(kkt, np.concatenate([f, c]), rcond=1e-12)[0][:len(self.mass)]

    def rate(self, _, y):
        q, v = np.split(y, 2)
        g, c = self.rows(q, v)
        return np.concatenate([v, self.solve(g, self.torques(q, v), c)])

    def opening(self, y, k):
        """Function that rises through zero at the unfolding of hinge k."""
        return (-1 if k % 2 == 0 else 1) * (y[3 * k + 5] - y[3 * k + 2])

    def run(self, until):
        samples = [round(until * i / 20, 9) for i in range(21)]
        t, y, events, states = 0.0, self.start, [], {}
        while True:
            if t in samples:
                states[str(t)] = [float(x) for x in y]
            if t >= until:
                return {"events": events, "samples": states}
            stop = min(s for s in samples if s > t)
            open_hinges = [k for k in range(self.n) if not self.latched[k]]
            guards = []
            for k in open_hinges:
                def guard(_, z, k=k):
                    return self.opening(z, k)
                guard.terminal, guard.direction = True, 1
                guards.append(guard)
            out = solve_ivp(self.rate, (t, stop), y, method="DOP853", rtol=1e-12, atol=1e-13, events=guards or None)
            t, y = (out.t[-1], out.y[:, -1]) if out.status == 1 else (stop, out.y[:, -1])
            if out.status == 1:
                due = [k for k in open_hinges if self.opening(y, k) >= -TOUCH]
                for k in due:
                    events.append([t, k + 1])
                    self.latched[k] = True
                if self.latches == "rigid":
                    q, v = np.split(y, 2)
                    g, _ = self.rows(q, v)
                    y = np.concatenate([q, self.solve(g, self.mass * v, np.zeros(len(g)))])


class Accordion:
    """Coordinates with cables, for which every other panel is parallel: x, y and turn of the bus, the turn of odd panels, that of even ones."""

    def __init__(self, n):
        self.n, self.first, self.others = n, False, False  # latched: hinge 1; all others
        self.turns = [2] + [3 + k % 2 for k in range(n)]    # of bus and panels, as indices of coordinates
        self.start = np.concatenate([[0, 0, 0, FOLD, -FOLD], np.zeros(5)])

    def bodies(self, q, u):
        """Position and turn of bus and panels; Jacobian, 3 x 5; the part of their accelerations that does not depend on q''."""
        along = [np.array([np.cos(q[i]), np.sin(q[i])]) for i in self.turns]
        J, bias = np.zeros((2, 5)), np.zeros(2)
        J[0, 0] = J[1, 1] = 1
        place, out = q[:2].copy(), []
        for k, i in enumerate(self.turns):
            for half in (0, 1):
                if half or k:  # from an edge to the centre, from there to the next edge: 0.5 m, the bus 1 m
                    reach = 0.5 if k else 1.0
                    place = place + reach * along[k]
                    J, bias = J.copy(), bias - reach * u[i] ** 2 * along[k]
                    J[:, i] += reach * np.array([-along[k][1], along[k][0]])
                if not half:
                    out.append((np.array([*place, q[i]]), np.vstack([J, np.eye(5)[i]]), np.array([*bias, 0])))
        return out

    def rows(self):
        return np.array([row for row, holds in (([0, 0, 1, -1, 0], self.first), ([0, 0, 0, 1, -1], self.others)) if holds])

    def solve(self, M, f):
        g = self.rows().reshape(-1, 5)
        kkt = np.block([[M, -g.T], [g, np.zeros((len(g), len(g)))]])
        return np.linalg.solve(kkt, np.concatenate([f, np.zeros(len(g))]))[:5]

    def masses(self):
        return [np.array([BUS_MASS, BUS_MASS, BUS_INERTIA])] + [np.array([MASS, MASS, INERTIA])] * self.n

    def rate(self, _, y):
        q, u = np.split(y, 2)
        M, f = np.zeros((5, 5)), np.zeros(5)
        for m, (_, J, bias) in zip(self.masses(), self.bodies(q, u)):
            M += J.T @ (m[:, None] * J)
            f -= J.T @ (m * bias)
        for k in range(self.n):
            if self.first if k == 0 else self.others:
                continue
            a, b = self.turns[k], self.turns[k + 1]
            torque = (-EFFORT if k % 2 == 0 else EFFORT) - STIFFNESS * (q[b] - q[a]) - DAMPING * (u[b] - u[a])
            f[a] -= torque
            f[b] += torque
        return np.concatenate([u, self.solve(M, f)])

    def run(self, samples):
        t, y, events, states = 0.0, self.start, [], {}
        while t < samples[-1]:
            guards = []
            for name, gap in (("first", lambda z: z[2] - z[3]), ("others", lambda z: z[4] - z[3])):
                if not getattr(self, name):
                    def guard(_, z, gap=gap):
                        return gap(z)
                    guard.terminal, guard.direction, guard.name = True, 1, name
                    guards.append(guard)
            stop = min(s for s in samples if s > t)
            out = solve_ivp(self.rate, (t, stop), y, method="DOP853", rtol=1e-12, atol=1e-13, events=guards or None)
            t, y = (out.t[-1], out.y[:, -1]) if out.status == 1 else (stop, out.y[:, -1])
            if out.status == 0:
                q, u = np.split(y, 2)
                bodies = self.bodies(q, u)
                states[str(t)] = [*(float(x) for place, _, _ in bodies for x in place), *(float(x) for _, J, _ in bodies for x in J @ u)]
                continue
            for guard, found in zip(guards, out.t_events):
                if len(found):
                    setattr(self, guard.name, True)
                    events += [[t, k] for k in ([1] if guard.name == "first" else range(2, self.n + 1))]
            q, u = np.split(y, 2)
            M = sum(J.T @ (m[:, None] * J) for m, (_, J, _) in zip(self.masses(), self.bodies(q, u)))
            y = np.concatenate([q, self.solve(M, M @ u)])
        return {"events": events, "samples": states}


def unfolded_modes(n):
    """Eigenvalues (real, imaginary; 1/s) of small vibrations of the unfolded array on its elastic latches, momenta zero: linear
    in y of the bus, its turn and the hinge angles."""
    y, turn = np.zeros((n + 1, n + 2)), np.zeros((n + 1, n + 2))  # of bodies, by coordinate
    y[:, 0] = turn[:, 1] = 1
    for body in range(1, n + 1):
        y[body, 1] = 0.5 + body
        y[body, 2:2 + body] = 0.5 + body - 1.0 - np.arange(body)  # from each hinge to the body's centre
        turn[body, 2:2 + body] = 1
    M = y.T @ np.diag([BUS_MASS] + [MASS] * n) @ y + turn.T @ np.diag([BUS_INERTIA] + [INERTIA] * n) @ turn
    flexibility = np.linalg.inv(M)[2:, 2:]
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-LATCH * flexibility, -LATCH_DAMPING * flexibility]])
    return sorted([float(x.real), float(x.imag)] for x in np.linalg.eigvals(A) if x.imag > 0)[::-1]


if __name__ == "__main__":
    result = {"about": "tests/references/array_reference.py: planar, DOP853 at rtol 1e-12. Events: t, panel. Samples: x, y, turn of "
                       "bus and panels, then their rates. Modes: eigenvalues of the elastic array, unfolded, 1/s",
              "modes": unfolded_modes(4)}
    for name, (n, latches, cables, until) in CASES.items():
        result[name] = Array(n, latches, cables).run(until)
        print(name, result[name]["events"], flush=True)
    for name, (n, samples) in MANY.items():
        result[name] = Accordion(n).run(samples)
        print(name, result[name]["events"], flush=True)
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in result.items()]
    (pathlib.Path(__file__).parent.parent / "data/array_panels.json").write_text("{" + ",\n".join(lines) + "}\n")
