#!/usr/bin/python3
"""Tight-tolerance references of the elastic fairing halves, independent of unlatch's code: no inertia invariants, no constraint
rows, no step. Every mass point of fairing.modes is summed at every evaluation, M(q) = sum m J'J, bias sum m J' (dJ/dt) u, in
coordinates that satisfy the hinges by themselves: the core's six, each half's hinge angle and modal coordinates; free frames
after the release. SciPy's DOP853 at rtol 1e-11, events by root-finding. Conditioning of the modes as hil/MODES.md says, with
SciPy's eigensolver.

    fairing_reference.py [CASE]...   writes tests/data/fairing_jettison.json, all runs or these anew; needs python3-scipy; some minutes
    fairing_reference.py --check     differentiates the points' places numerically and compares
"""
import json
import pathlib
import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from boosters_reference import rotation

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Constants of hil/scenarios/fairing/scenario.yaml, copied by hand.
CORE_MASS, CORE_INERTIA, CORE_START = 12000.0, np.array([60000.0, 60000.0, 20000.0]), np.array([0, 0, -3.0])
HINGES = np.array([[0, 2.0, 3], [0, -2.0, 3]])        # in the core's axes
TURNS = [np.eye(3), np.diag([-1.0, -1, 1])]           # half to core at angle zero
PUSHERS = [("push_left", "push_right")] * 2           # along y of their markers
PUSHED, PUSH, PUSH_END = 0.2, 50000.0, 10000.0        # s, N, N
RELEASE, SIDE = np.radians(60), (-1, 1)               # half 1 opens to negative angles
SELECT, DAMPING = 5, 0.005
SAMPLES = [0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.25, 1.5, 1.6, 1.7, 1.9, 2.2, 2.6, 3.0, 3.3, 3.6]
LOOKED_AT = ("base_left", "base_right", "middle_left", "top_left", "nose")
TOUCH = 1e-9  # rad; mirror images release together
# unzip.yaml: markers of half 1 and 2, m along the joint, m between them at the start; N/m, m/s.
LOCKS = [("base_left", "base_right", 0, 0), ("base_right", "base_left", 0, 0), ("middle_left", "middle_right", 4, 0),
         ("middle_right", "middle_left", 4, 0), ("push_left", "push_right", 6.86892, 0), ("push_right", "push_left", 6.86892, 0),
         ("top_left", "top_right", 8, 0), ("top_right", "top_left", 8, 0), ("nose", "nose", 13.97, -0.02)]
LOCK, SPEED = 15e6, 200.0
CASES = {"scenario": {"until": 3.0}, "dead-pusher": {"until": 3.6, "dead": (0, "push_left")}, "unzip": {"until": 3.0, "locked": True},
         "unzip-nose": {"until": 3.0, "locked": True, "begin": 13.97}}


def cross(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def crosses(a):
    """Returns (n, 3, 3) of (n, 3)."""
    out = np.zeros((len(a), 3, 3))
    out[:, 2, 1], out[:, 0, 2], out[:, 1, 0] = a.T
    return out - out.transpose(0, 2, 1)


def quaternion(m):
    k = 0.25 * np.array([[m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0], [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
                         [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
                         [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)]])
    q = np.linalg.eigh(k)[1][:, -1]  # Bar-Itzhack
    return np.array([q[3], *q[:3]]) * (1 if q[3] >= 0 else -1)


def about_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


class Half:
    """Mass points and markers relative to the undeformed centre of mass: shapes without momentum, orthonormal by mass."""

    def __init__(self, path):
        words = [line.split("#")[0].split() for line in path.read_text().splitlines()]
        hz = np.array([float(x) for line in words if line[:1] == ["frequencies"] for x in line[1:]])
        count, places, shapes, turns, names, rows, i = len(hz), [], [], [], [], None, 0
        while i < len(words):
            if words[i][:1] == ["marker"]:
                names.append(words[i][1])
                places.append([float(x) for x in words[i][2:]])
                block = np.array([[float(x) for x in line] for line in words[i + 1:i + 1 + count]])
                shapes.append(block[:, :3].T)
                turns.append(block[:, 3:].T)
            elif words[i][:1] == ["points"]:
                rows = np.array([[float(x) for x in line] for line in words[i + 1:i + 1 + int(words[i][1])]])
            i += 1
        self.m, r = rows[:, 0], rows[:, 1:4]
        self.mass, self.centre = self.m.sum(), self.m @ r / self.m.sum()
        marked = np.array(places) - self.centre
        r = r - self.centre
        phi = rows[:, 4:].reshape(-1, count, 3).transpose(0, 2, 1)  # point, axis, mode
        at, turn = np.array(shapes), np.array(turns)
        scale = 1 / np.sqrt(np.einsum("i,iak,iak->k", self.m, phi, phi))
        phi, at, turn = phi * scale, at * scale, turn * scale
        inertia = np.einsum("i,iab->ab", self.m, np.array([x @ x * np.eye(3) - np.outer(x, x) for x in r]))
        for _ in range(2):
            shift = np.einsum("i,iak->ak", self.m, phi) / self.mass
            spin = np.linalg.solve(inertia, np.einsum("i,iak->ak", self.m, np.cross(r[:, :, None], phi, axis=1)))
            phi = phi - shift - np.cross(spin.T[None], r[:, None]).transpose(0, 2, 1)
            at = at - shift - np.cross(spin.T[None], marked[:, None]).transpose(0, 2, 1)
            turn = turn - spin
        gram, stiffness = np.einsum("i,iak,ial->kl", self.m, phi, phi), np.diag((2 * np.pi * hz) ** 2)
        square, a = eigh(stiffness, gram)
        a = a * np.sign(a[np.abs(a).argmax(axis=0), range(count)])
        self.omega = np.sqrt(square[:SELECT])
        self.r, self.phi = r, (phi @ a)[:, :, :SELECT]
        self.at = {name: (marked[k], (at[k] @ a)[:, :SELECT], (turn[k] @ a)[:, :SELECT]) for k, name in enumerate(names)}

    def turn_of(self, name, eta, rate):
        """Returns S of a marker (its axes to the body's), its derivative by each mode, dS/dt, and d2S/dt2 at constant rates: the
        Rodrigues vector is half of the small rotations' sum."""
        psi = self.at[name][2]
        g, d = cross(psi @ eta / 2), cross(psi @ rate / 2)
        v, dv = psi @ eta / 2, psi @ rate / 2
        c, a = 2 / (1 + v @ v), g + g @ g
        by_mode = []
        for k in range(SELECT):
            e = cross(psi[:, k] / 2)
            by_mode.append(-(c * c) * (v @ psi[:, k] / 2) * a + c * (e + e @ g + g @ e))
        dc, da = -(c * c) * (v @ dv), d + d @ g + g @ d
        ddc = -(c * c) * (dv @ dv) + 2 * c**3 * (v @ dv) ** 2
        return np.eye(3) + c * a, by_mode, dc * a + c * da, ddc * a + 2 * dc * da + 2 * c * (d @ d)


class Jettison:
    """State y: core p q v w, then of each half: angle, its rate (hinged) or p q v w (free), and always eta, its rate."""

    def __init__(self, half, until=0.0, dead=None, locked=False, begin=0.0):
        opens = [(one, other, abs(z - begin) / SPEED, rest) for one, other, z, rest in LOCKS]
        self.locks = [lock for lock in opens if locked and lock[2] > 0]  # active locks; times at which they open, s
        self.half, self.until, self.dead, self.hinged, self.pushing = half, until, dead, [True, True], True
        self.start = np.concatenate([CORE_START, [1, 0, 0, 0], np.zeros(6), *[np.zeros(2 + 2 * SELECT)] * 2])

    def unpack(self, y):
        """Returns core (p, R, v, w, q); each half's (own coordinates, eta, rate)."""
        core, i, halves = (y[:3], rotation(y[3:7]), y[7:10], y[10:13], y[3:7]), 13, []
        for hinged in self.hinged:
            own = 2 if hinged else 13
            halves.append((y[i:i + own], y[i + own:i + own + SELECT], y[i + own + SELECT:i + own + 2 * SELECT]))
            i += own + 2 * SELECT
        return core, halves

    def motion(self, core, own, eta, rate, k, r, phi):
        """Returns positions, Jacobians and biases (d/dt of them at constant speeds) of points of half k; the speeds are the core's v
        (inertial) and w (its axes), angle rate, eta rate when hinged; v, w, eta rate when free."""
        s, flow = r + phi @ eta, phi @ rate
        if len(own) == 13:
            p, R, W = own[:3], rotation(own[3:7]), cross(own[10:13]).T
            J = np.concatenate([np.tile(np.eye(3), (len(s), 1, 1)), -R @ crosses(s), R @ phi], axis=2)
            return p + s @ R.T, J, (s @ W @ W + 2 * flow @ W) @ R.T
        arm, arm_phi, _ = self.half.at["hinge"]
        S, by_mode, dS, ddS = self.half.turn_of("hinge", eta, rate)
        u, du = s - (arm + arm_phi @ eta), flow - arm_phi @ rate
        # In the hinge's axes before its turn, then in the core's, then W.
        z, dz, ddz = u @ S, u @ dS + du @ S, u @ ddS + 2 * du @ dS
        z_eta = np.stack([u @ by_mode[j] + (phi[:, :, j] - arm_phi[:, j]) @ S for j in range(SELECT)], axis=2)
        angle, speed = own
        T, X, W = about_x(angle) @ TURNS[k], cross([1.0, 0, 0]).T, cross(core[3]).T
        z, dz, ddz, z_eta = z @ T.T, dz @ T.T, ddz @ T.T, T @ z_eta
        p, R = core[:2]
        x, out = HINGES[k] + z, z @ X
        dx = speed * out + dz
        ddx = speed**2 * out @ X + 2 * speed * dz @ X + ddz
        J = np.concatenate([np.tile(np.eye(3), (len(x), 1, 1)), -R @ crosses(x), (out @ R.T)[:, :, None], R @ z_eta], axis=2)
        return p + x @ R.T, J, (x @ W @ W + 2 * dx @ W + ddx) @ R.T

    def pose(self, core, own, eta, rate, k):
        """Returns p, R, v, w of the half's frame; by the rigid motion of its undeformed axes."""
        if len(own) == 13:
            return own[:3], rotation(own[3:7]), own[7:10], own[10:13]
        p, R, v, w, _ = core
        arm, arm_phi, _ = self.half.at["hinge"]
        S, _, dS, _ = self.half.turn_of("hinge", eta, rate)
        d, dd = arm + arm_phi @ eta, arm_phi @ rate
        marker = R @ about_x(own[0]) @ TURNS[k]
        w_marker = marker.T @ R @ (w + [own[1], 0, 0])
        relative = dS @ S.T  # skew: the marker's rate in the half's axes
        w_half = S @ w_marker - np.array([relative[2, 1], relative[0, 2], relative[1, 0]])
        R_half = marker @ S.T
        p_hinge, v_hinge = p + R @ HINGES[k], v + R @ np.cross(w, HINGES[k])
        return p_hinge - R_half @ d, R_half, v_hinge - R_half @ (np.cross(w_half, d) + dd), w_half

    def edge(self, own, eta, k, name):
        """Returns position and y of a marker of half k on its hinge, core's axes, each with derivatives by angle and eta (3, 1 + SELECT)."""
        (place, phi, _), (arm, arm_phi, _), still = self.half.at[name], self.half.at["hinge"], np.zeros(SELECT)
        (S, by_mode, _, _), (A, a_by_mode, _, _) = self.half.turn_of("hinge", eta, still), self.half.turn_of(name, eta, still)
        T, X, u = about_x(own[0]) @ TURNS[k], cross([1.0, 0, 0]), place + phi @ eta - arm - arm_phi @ eta
        out, y = T @ S.T @ u, T @ S.T @ A[:, 1]
        by_place = [T @ (by_mode[j].T @ u + S.T @ (phi[:, j] - arm_phi[:, j])) for j in range(SELECT)]
        by_y = [T @ (by_mode[j].T @ A[:, 1] + S.T @ a_by_mode[j][:, 1]) for j in range(SELECT)]
        return HINGES[k] + out, np.stack([X @ out, *by_place], axis=1), y, np.stack([X @ y, *by_y], axis=1)

    def lock_forces(self, halves):
        """Returns forces on angle and eta of half 1, then of half 2: minus the derivatives of the springs' energy."""
        force = np.zeros((2, 1 + SELECT))
        for one, other, _, rest in self.locks:
            ends = [self.edge(own, eta, k, name) for k, ((own, eta, _), name) in enumerate(zip(halves, (one, other)))]
            for base in (0, 1):  # a spring along y of either half
                (p, dp, y, dy), (q, dq, _, _) = ends[base], ends[1 - base]
                pull = 0.5 * LOCK * (y @ (q - p) - rest)
                force[base] -= pull * ((q - p) @ dy - y @ dp)
                force[1 - base] -= pull * (y @ dq)
        return force

    def calc_core_load(self, core):
        """Returns force (inertial) and moment (its axes) about the core's centre of mass: none here."""
        return np.zeros(6)

    def calc_half_load(self, core, halves, k, flat):
        """Returns what else acts on half k, by the speeds of its points' Jacobian `flat`: nothing here."""
        return 0

    def solve(self, t, y):
        """Returns d(speeds)/dt, ordered: core 6, then for each half its own (1 or 6) and eta's."""
        core, halves = self.unpack(y)
        w, half = core[3], self.half
        counts = [(1 if hinged else 6) + SELECT for hinged in self.hinged]
        size = 6 + sum(counts)
        M, F, first = np.zeros((size, size)), np.zeros(size), 6
        M[:3, :3], M[3:6, 3:6] = CORE_MASS * np.eye(3), np.diag(CORE_INERTIA)
        F[3:6] = -np.cross(w, CORE_INERTIA * w)
        F[:6] += self.calc_core_load(core)
        locked = self.lock_forces(halves) if self.locks else None
        for k, (own, eta, rate) in enumerate(halves):
            columns = np.r_[0:6 if self.hinged[k] else 0, first:first + counts[k]]
            _, J, bias = self.motion(core, own, eta, rate, k, half.r, half.phi)
            flat, weight = J.reshape(-1, len(columns)), np.repeat(half.m, 3)
            M[np.ix_(columns, columns)] += flat.T @ (weight[:, None] * flat)
            F[columns] -= flat.T @ (weight * bias.ravel())
            F[columns] += self.calc_half_load(core, halves, k, flat)
            last = slice(first + counts[k] - SELECT, first + counts[k])
            F[last] -= half.omega**2 * eta + 2 * DAMPING * half.omega * rate
            if self.locks:
                F[first:first + counts[k]] += locked[k]
            for name in PUSHERS[k] if self.pushing else ():
                if self.dead == (k, name):
                    continue
                size_N = PUSH + (PUSH_END - PUSH) * t / PUSHED
                place, phi, _ = half.at[name]
                _, J, _ = self.motion(core, own, eta, rate, k, place[None], phi[None])
                along = self.pose(core, own, eta, rate, k)[1] @ half.turn_of(name, eta, rate)[0][:, 1]
                F[columns] += J[0].T @ (size_N * along)
            first += counts[k]
        return np.linalg.solve(M, F)

    def rate(self, t, y):
        core, halves = self.unpack(y)
        a, out, i = self.solve(t, y), [], 6

        def frame(s, acceleration):
            q, w = s[3:7], s[10:13]
            return [s[7:10], [-0.5 * w @ q[1:]], 0.5 * (q[0] * w + np.cross(q[1:], w)), acceleration]

        out += frame(y[:13], a[:6])
        for own, _, rate in halves:
            count = 1 if len(own) == 2 else 6
            out += [[own[1]], a[i:i + 1]] if count == 1 else frame(own, a[i:i + 6])
            out += [rate, a[i + count:i + count + SELECT]]
            i += count + SELECT
        return np.concatenate(out)

    def release(self, y, due):
        """Returns the same motion with those halves in their own coordinates."""
        core, halves = self.unpack(y)
        out = [y[:13]]
        for k, (own, eta, rate) in enumerate(halves):
            if k in due:
                p, R, v, w = self.pose(core, own, eta, rate, k)
                own = np.concatenate([p, quaternion(R), v, w])
            out += [own, eta, rate]
        for k in due:
            self.hinged[k] = False
        return np.concatenate(out)

    def describe(self, y):
        """Returns core and halves: p q v w; then eta of each half; then the displacement of the observed points, half's axes."""
        core, halves = self.unpack(y)
        bodies, modal, elastic = [np.concatenate([core[0], core[4] / np.linalg.norm(core[4]), core[2], core[3]])], [], []
        for k, (own, eta, rate) in enumerate(halves):
            p, R, v, w = self.pose(core, own, eta, rate, k)
            bodies.append(np.concatenate([p, quaternion(R), v, w]))
            modal.append(eta)
            elastic.append(np.concatenate([self.half.at[name][1] @ eta for name in LOOKED_AT]))
        return {name: [x.tolist() for x in values] for name, values in
                (("bodies", bodies), ("modal", modal), ("elastic", elastic))}

    def run(self):
        t, y, events, samples = 0.0, self.start, [], {}
        while t < self.until:
            stop = min(s for s in SAMPLES + [opens for _, _, opens, _ in self.locks] if s > t)  # the pushers' end is among them
            guards, held = [], [k for k in (0, 1) if self.hinged[k]]
            for k in held:
                def guard(_, z, k=k):
                    return SIDE[k] * self.unpack(z)[1][k][0][0] - RELEASE
                guard.terminal, guard.direction = True, 1
                guards.append(guard)
            out = solve_ivp(self.rate, (t, stop), y, method="DOP853", rtol=1e-11, atol=1e-12, events=guards or None)
            t, y = (out.t[-1], out.y[:, -1]) if out.status == 1 else (stop, out.y[:, -1])
            if out.status == 1:
                due = [k for k, guard in zip(held, guards) if guard(t, y) >= -TOUCH]
                events += [[t, k + 1] for k in due]
                y = self.release(y, due)
            elif t in SAMPLES:
                samples[str(t)] = self.describe(y)
            self.locks = [lock for lock in self.locks if lock[2] > t]
            if t == PUSHED:
                self.pushing = False
        return {"events": events, "samples": samples}


def check():
    """Compares the Jacobian times speeds, and the bias, with differences of positions along a smooth motion; likewise the pose."""
    dice, half = np.random.default_rng(2003), Half(ROOT / "hil/scenarios/fairing/fairing.modes")
    for hinged in (True, False):
        for k in (0, 1):
            it = Jettison(half)
            it.hinged = [hinged, hinged]
            own = 2 if hinged else 13
            y = dice.uniform(-1, 1, 13 + 2 * (own + 2 * SELECT))
            h, some = 1e-4, dice.integers(0, len(half.m), 20)

            def at(time):
                """Moves at constant generalised speeds: p linear, q turning about w, the rest linear."""
                out = y.copy()
                frames = [0] + ([] if hinged else [13 + k * (13 + 2 * SELECT)])
                for f in frames:
                    w, q = y[f + 10:f + 13], y[f + 3:f + 7] / np.linalg.norm(y[f + 3:f + 7])
                    angle = np.linalg.norm(w) * time / 2
                    d = np.array([np.cos(angle), *(np.sin(angle) * w / np.linalg.norm(w))])
                    out[f:f + 3] = y[f:f + 3] + time * y[f + 7:f + 10]
                    out[f + 3:f + 7] = [q[0] * d[0] - q[1:] @ d[1:], *(q[0] * d[1:] + d[0] * q[1:] + np.cross(q[1:], d[1:]))]
                i = 13 + k * (own + 2 * SELECT)
                if hinged:
                    out[i] = y[i] + time * y[i + 1]
                out[i + own:i + own + SELECT] = y[i + own:i + own + SELECT] + time * y[i + own + SELECT:i + own + 2 * SELECT]
                core, halves = it.unpack(out)
                return core, *halves[k]

            def places(time):
                return it.motion(*at(time), k, half.r[some], half.phi[some])

            now, before, after = places(0), places(-h), places(h)
            core, own_now, eta, rate = at(0)
            speeds = np.concatenate([core[2], core[3], [own_now[1]], rate] if hinged else [own_now[7:10], own_now[10:13], rate])
            first = np.abs((after[0] - before[0]) / (2 * h) - now[1] @ speeds).max()
            second = np.abs((after[0] - 2 * now[0] + before[0]) / h**2 - now[2]).max()
            p, R, v, w = it.pose(*at(0), k)
            a, b = it.pose(*at(h), k), it.pose(*at(-h), k)
            turn = R.T @ (a[1] - b[1]) / (2 * h)
            pose = max(np.abs((a[0] - b[0]) / (2 * h) - v).max(), np.abs(turn - cross(w)).max())
            seen = p + (half.r[some] + half.phi[some] @ eta) @ R.T
            print(f"hinged {hinged}, half {k + 1}: speeds {first:.1e}, biases {second:.1e}, pose {pose:.1e}, places "
                  f"{np.abs(seen - now[0]).max():.1e}")
            assert first < 1e-5 and second < 1e-4 and pose < 1e-5 and np.abs(seen - now[0]).max() < 1e-12


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        sys.exit(check())
    model = Half(ROOT / "hil/scenarios/fairing/fairing.modes")
    result = {"about": "tests/references/fairing_reference.py: mass points summed, DOP853 at rtol 1e-11. Events: t, half released. "
                       "Samples: core, half 1, half 2 (p, q body to inertial, v, w in body axes); eta of the halves; elastic "
                       "displacements of the points looked at, half's axes", "looked_at": LOOKED_AT}
    file = ROOT / "tests/data/fairing_jettison.json"
    if sys.argv[1:]:
        result = json.loads(file.read_text())
    for name in sys.argv[1:] or CASES:
        result[name] = Jettison(model, **CASES[name]).run()
        print(name, result[name]["events"], flush=True)
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in result.items()]
    file.write_text("{" + ",\n".join(lines) + "}\n")
