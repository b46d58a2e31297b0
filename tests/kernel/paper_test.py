#!/usr/bin/env python3
"""The mistakes of the source paper (Anshakov et al. 2003), each shown by its consequence: the result of the formula as printed, and
that of the formula in kernel/README.md and the scenarios. Finite differences, energy and momentum decide; nothing of
unlatch takes part. Run by ctest: paper_test.py
"""
import json
import math
import pathlib
import random
import unittest

FRESNEL = json.loads((pathlib.Path(__file__).parents[1] / "data/capsule_fresnel.json").read_text())
STEP = 1e-4           # s, of the finite differences
DIFFERENCES = 1e-5    # of second differences at that step
ROUND_OFF = 1e-12
WRONG = 0.1           # a formula with this error, where all numbers are about 1, is wrong


def add(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def scale(s, a):
    return [s * x for x in a]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def apply(m, v):
    return [dot(row, v) for row in m]


def transposed(m):
    return [list(row) for row in zip(*m)]


def product(a, b):
    if len(a[0]) != len(b):
        raise ValueError(f"{len(a)} x {len(a[0])} by {len(b)} x {len(b[0])}")
    return [[dot(row, column) for column in transposed(b)] for row in a]


def norm(a):
    return math.sqrt(dot(a, a))


def solve(a, b):
    """Solves by Gauss with row exchanges."""
    m = [[*row, x] for row, x in zip(a, b)]
    n = len(m)
    for i in range(n):
        best = max(range(i, n), key=lambda r: abs(m[r][i]))
        m[i], m[best] = m[best], m[i]
        for r in range(i + 1, n):
            f = m[r][i] / m[i][i]
            m[r] = [x - f * y for x, y in zip(m[r], m[i])]
    out = [0.0] * n
    for i in reversed(range(n)):
        out[i] = (m[i][n] - dot(m[i][i + 1:n], out[i + 1:])) / m[i][i]
    return out


def get_rank(rows):
    rows, rank = [list(row) for row in rows], 0
    for column in range(len(rows[0])):
        best = max(range(rank, len(rows)), key=lambda r: abs(rows[r][column]), default=None)
        if best is None or abs(rows[best][column]) < 1e-9:
            continue
        rows[rank], rows[best] = rows[best], rows[rank]
        for r in range(rank + 1, len(rows)):
            f = rows[r][column] / rows[rank][column]
            rows[r] = [x - f * y for x, y in zip(rows[r], rows[rank])]
        rank += 1
    return rank


class Motion:
    """A body in smooth motion: R(t), and C(t), body to inertial, by three angles; its rates by differences."""

    def __init__(self, dice):
        self.place = [[dice.uniform(-1, 1) for _ in range(3)] for _ in range(3)]
        self.turn = [[dice.uniform(-1, 1) for _ in range(3)] for _ in range(3)]

    def R(self, t):
        return [c[0] + c[1] * t + c[2] * t * t for c in self.place]

    def C(self, t):
        a, b, c = (k[0] + k[1] * t + k[2] * t * t for k in self.turn)
        sa, ca, sb, cb, sc, cc = math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.sin(c), math.cos(c)
        return [[cb * cc, -cb * sc, sb], [ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb],
                [sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb]]

    def A(self, t):
        """Returns the paper's matrix, inertial to body."""
        return transposed(self.C(t))

    def V(self, t):
        return [c[1] + 2 * c[2] * t for c in self.place]

    def acceleration(self):
        return [2 * c[2] for c in self.place]

    def w(self, t):
        """Returns the angular velocity, body axes, from Cᵀ dC/dt."""
        h = 1e-5
        ahead, behind = self.C(t + h), self.C(t - h)
        rate = [[(x - y) / (2 * h) for x, y in zip(r, s)] for r, s in zip(ahead, behind)]
        m = [[dot(column, other) for other in transposed(rate)] for column in transposed(self.C(t))]
        return [(m[2][1] - m[1][2]) / 2, (m[0][2] - m[2][0]) / 2, (m[1][0] - m[0][1]) / 2]

    def e(self, t):
        return scale(1 / (2 * STEP), sub(self.w(t + STEP), self.w(t - STEP)))


class PaperTest(unittest.TestCase):
    def setUp(self):
        dice = random.Random(2003)
        self.i, self.j = Motion(dice), Motion(dice)
        self.n = [0.6, -0.48, 0.64]
        self.r = [0.4, -0.7, 0.5]  # of the point in body j

    def arm(self, t):
        """Returns r_ij: the point of body j in the axes of body i."""
        return apply(self.i.A(t), sub(add(self.j.R(t), apply(self.j.C(t), self.r)), self.i.R(t)))

    def relative(self, t):
        """Returns A_i A_j^-1 w_j."""
        return apply(self.i.A(t), apply(self.j.C(t), self.j.w(t)))

    def test_4_11_has_its_c_on_the_other_side(self):
        i, j, n = self.i, self.j, self.n
        normal = apply(i.C(0), n)  # A_i^-1 n
        arm = self.arm(0)
        left = (dot(scale(-1, normal), i.acceleration()) + dot(scale(-1, cross(arm, n)), i.e(0))
                + dot(normal, j.acceleration()) + dot(cross(self.r, apply(j.A(0), normal)), j.e(0)))
        speed = apply(i.A(0), add(apply(j.C(0), cross(j.w(0), self.r)), sub(j.V(0), i.V(0))))
        arm_rate = add(scale(-1, cross(i.w(0), arm)), speed)
        c = dot(add(cross(i.w(0), arm_rate), cross(i.w(0), speed),
                    scale(-1, apply(i.A(0), apply(j.C(0), cross(j.w(0), cross(j.w(0), self.r)))))), n)
        second = (dot(self.arm(STEP), n) - 2 * dot(arm, n) + dot(self.arm(-STEP), n)) / STEP**2
        self.assertAlmostEqual(left - c, second, delta=DIFFERENCES)
        self.assertGreater(abs(left + c - second), WRONG)  # as printed

    def test_4_12_is_right_up_to_its_sign(self):
        i, j, n = self.i, self.j, self.n
        value = (dot(n, i.e(0)) - dot(apply(j.A(0), apply(i.C(0), n)), j.e(0)) + dot(cross(i.w(0), self.relative(0)), n))
        gap = lambda t: dot(n, sub(self.relative(t), i.w(t)))
        self.assertAlmostEqual(-value, (gap(STEP) - gap(-STEP)) / (2 * STEP), delta=DIFFERENCES)

    def test_1_4_has_the_right_signs_and_lacks_a_transpose(self):
        i, j, n = self.i, self.j, self.n  # the core, a booster
        arm = self.arm(0)
        seen = lambda v: apply(i.A(0), apply(j.C(0), v))  # A_0 A_i^-1
        speed = add(seen(cross(j.w(0), self.r)), apply(i.A(0), sub(j.V(0), i.V(0))))
        arm_rate = sub(speed, cross(i.w(0), arm))
        left = add(seen(cross(j.e(0), self.r)), scale(-1, cross(i.e(0), arm)), apply(i.A(0), sub(j.acceleration(), i.acceleration())))
        right = add(cross(i.w(0), arm_rate), cross(i.w(0), speed), scale(-1, seen(cross(j.w(0), cross(j.w(0), self.r)))))
        second = (dot(self.arm(STEP), n) - 2 * dot(arm, n) + dot(self.arm(-STEP), n)) / STEP**2
        self.assertAlmostEqual(dot(left, n) - dot(right, n), second, delta=DIFFERENCES)
        turning = dot(sub(seen(j.e(0)), i.e(0)), n) - dot(cross(i.w(0), seen(j.w(0))), n)
        gap = lambda t: dot(n, sub(self.relative(t), i.w(t)))
        self.assertAlmostEqual(turning, (gap(STEP) - gap(-STEP)) / (2 * STEP), delta=DIFFERENCES)
        column, normal = [[x] for x in right], [[x] for x in n]
        self.assertAlmostEqual(product([right], normal)[0][0], dot(right, n), delta=ROUND_OFF)
        self.assertRaises(ValueError, product, column, normal)  # as printed: [3 x 1] [3 x 1]

    def test_4_7_needs_second_derivatives_in_its_c(self):
        """One coordinate for each body, for which the printed products of first derivatives are at least numbers."""
        a, b = lambda t: 0.7 + 1.1 * t, lambda t: -0.4 + 0.9 * t  # without accelerations only c is left
        link = lambda t: a(t) ** 2 * b(t) + b(t) ** 2
        second = (link(STEP) - 2 * link(0) + link(-STEP)) / STEP**2
        x, y, u, v = a(0), b(0), 1.1, 0.9
        self.assertAlmostEqual(2 * y * u**2 + 2 * v**2 + 2 * (2 * x) * u * v, second, delta=DIFFERENCES)
        by_a, by_b = 2 * x * y, x**2 + 2 * y
        self.assertGreater(abs(by_a * u**2 + by_b * v**2 + 2 * by_a * u * v - second), WRONG)  # as printed

    # A mass on a rod of length l, planar: position x, g = x.x - l^2 = 0, H = 2 x, second derivative H a + 2 v.v.
    PENDULUM = dict(mass=2.0, x=[0.6, -0.8], v=[0.8, 0.6], force=[0.0, -2 * 9.81])

    def test_1_11_and_4_10_have_wrong_right_hand_sides(self):
        p = self.PENDULUM
        m, h, c = p["mass"], scale(2, p["x"]), 2 * dot(p["v"], p["v"])
        radial = lambda a: dot(a, p["x"])  # a circle: -v^2/l
        right = solve([[m, 0, -h[0]], [0, m, -h[1]], [h[0], h[1], 0]], [*p["force"], -c])
        self.assertAlmostEqual(radial(right[:2]), -dot(p["v"], p["v"]), delta=ROUND_OFF)
        printed = solve([[m, 0, -h[0]], [0, m, -h[1]], [-h[0], -h[1], 0]], [0, 0, -c])  # (1.11): no force at all
        self.assertGreater(abs(radial(printed[:2]) + dot(p["v"], p["v"])), WRONG)
        tension = sub(scale(m, right[:2]), p["force"])
        printed = solve([[m, 0, h[0]], [0, m, h[1]], [h[0], h[1], 0]], [*p["force"], c])  # (4.10): c of (4.9)
        self.assertGreater(abs(radial(printed[:2]) + dot(p["v"], p["v"])), WRONG)
        # The sign of lambda, with c corrected: by (4.5) the reaction is H^T lambda, by (4.10) and (3.8) its opposite.
        mended = solve([[m, 0, h[0]], [0, m, h[1]], [h[0], h[1], 0]], [*p["force"], -c])
        self.assertAlmostEqual(mended[2], -right[2], delta=ROUND_OFF)
        for reaction, by_rod in zip(scale(right[2], h), tension):
            self.assertAlmostEqual(reaction, by_rod, delta=1e-9)

    def test_4_13_repeats_a_row(self):
        n = [[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]

        def row(normal):
            return [*scale(-1, normal), *scale(-1, cross(self.r, normal)), *normal, *cross(self.r, normal)]

        turns = [[0] * 3 + scale(-1, n[k]) + [0] * 3 + n[k] for k in (1, 2)]
        self.assertEqual(get_rank([row(n[1]), row(n[1]), row(n[2]), *turns]), 4)  # as printed
        self.assertEqual(get_rank([row(n[0]), row(n[1]), row(n[2]), *turns]), 5)

    def spring(self, t):
        """Returns d of (4.14), the point p1 of the plane and p2 in body 1 = i; the plane goes through its origin."""
        p2 = self.arm(t)
        return -dot(p2, self.n), sub(p2, scale(dot(p2, self.n), self.n)), p2

    def power(self, force, torque_i, torque_j):
        """Returns the power of a force on body i and its opposite on body j, inertial; torques in the axes of each."""
        return (dot(force, sub(self.i.V(0), self.j.V(0))) + dot(torque_i, self.i.w(0)) + dot(torque_j, self.j.w(0)))

    def test_4_15_pushes_the_wrong_way_and_4_16_mixes_axes(self):
        stiffness = 60.0  # N/m: the plane is 0.1 m off
        d, p1, _ = self.spring(0)
        energy = lambda t: stiffness * self.spring(t)[0] ** 2 / 2
        lost = -(energy(STEP) - energy(-STEP)) / (2 * STEP)

        def wrench(sign):
            force = scale(sign * stiffness * d, apply(self.i.C(0), self.n))  # F1, inertial axes
            turned = (cross(p1, apply(self.i.A(0), force)), scale(-1, cross(self.r, apply(self.j.A(0), force))))
            return force, turned

        force, (torque_i, torque_j) = wrench(-1)
        self.assertAlmostEqual(self.power(force, torque_i, torque_j), lost, delta=DIFFERENCES)
        force, (torque_i, torque_j) = wrench(+1)  # (4.15) as printed
        self.assertAlmostEqual(self.power(force, torque_i, torque_j), -lost, delta=DIFFERENCES)
        # (4.16) as printed uses the inertial F1 as if it were in the axes of body 1: then moments do not balance.
        force, (torque_i, torque_j) = wrench(-1)
        def unbalanced(on_i, on_j):
            about_origin = add(cross(self.i.R(0), force), cross(self.j.R(0), scale(-1, force)))
            return norm(add(about_origin, apply(self.i.C(0), on_i), apply(self.j.C(0), on_j)))
        self.assertLess(unbalanced(torque_i, torque_j), ROUND_OFF)
        as_printed = (cross(p1, force), scale(-1, cross(self.r, apply(self.j.A(0), apply(self.i.C(0), force)))))
        self.assertGreater(unbalanced(*as_printed), WRONG)

    def test_a_damper_of_minus_abs_v_k_drives_one_way(self):
        powers = [speed * -abs(speed) for speed in (-1.0, 1.0)]
        self.assertEqual([power > 0 for power in powers], [True, False])  # as printed: it feeds the motion back
        self.assertTrue(all(speed * -speed < 0 for speed in (-1.0, 1.0)))

    def test_4_17_drives_away_from_the_plane_on_its_far_side(self):
        for angle in (0.3, -0.3):  # of n_j above the plane whose normal is n_i
            n_i, n_j = [0, 0, 1.0], [math.cos(angle), 0, math.sin(angle)]
            axis = cross(n_i, n_j)
            axis = scale(1 / norm(axis), axis)
            printed = math.pi / 2 - math.asin(norm(cross(n_i, n_j)))
            signed = math.atan2(dot(n_i, n_j), norm(cross(n_i, n_j)))
            self.assertGreaterEqual(printed, 0)  # never negative
            rises = lambda moment: dot(cross(scale(moment, axis), n_j), n_i)  # d(n_j . n_i)/dt that the moment begins
            self.assertLess(rises(signed) * dot(n_i, n_j), 0)  # back to the plane from either side
            self.assertEqual(rises(printed) * dot(n_i, n_j) < 0, angle > 0)

    # --- Section 2 --------------------------------------------------------------------------------------------------

    def test_2_1_needs_m_rho_squared_beside_A_in_both_places(self):
        """Eight particles round the axis z, none lost, no relative spin; A and C about a pole on the axis at rho from the centre
        of mass. Euler's equation about the centre of mass is the judge. The text drops "t rho^2", which is no moment of inertia;
        (2.1) subtracts m rho^2 from A beside the derivative, but B = C - A is left without it."""
        points = [[0.7 * math.cos(k * math.pi / 2), 0.7 * math.sin(k * math.pi / 2), 0.9 * (k // 4)] for k in range(8)]
        mass, rho, t = 2.0, 0.6, 1.5
        total = mass * len(points)
        centre = scale(1 / len(points), add(*points))
        moment = lambda about: sum(mass * ((p[1] - about[1]) ** 2 + (p[2] - about[2]) ** 2) for p in points)
        about_centre, A = moment(centre), moment(sub(centre, [0, 0, rho]))
        C = sum(mass * (p[0] ** 2 + p[1] ** 2) for p in points)
        q, r = 0.4, 3.0
        by_euler = -(C - about_centre) * q * r / about_centre
        by_2_1 = lambda beside, in_b: -(C - A + in_b) * q * r / (A - beside)
        square = total * rho**2
        self.assertAlmostEqual(by_2_1(square, square), by_euler, delta=ROUND_OFF)
        self.assertGreater(abs(by_2_1(square, 0) - by_euler), WRONG)  # as printed in (2.1)
        self.assertGreater(abs(by_2_1(t * rho**2, t * rho**2) - by_euler), WRONG)  # the text's

    @staticmethod
    def calc_fresnel(x):
        """Returns C(x), S(x) by Simpson's rule."""
        steps = 4000
        h = x / steps
        weights = [1 if k in (0, steps) else 4 if k % 2 else 2 for k in range(steps + 1)]
        arguments = [math.pi / 2 * (k * h) ** 2 for k in range(steps + 1)]
        return (h / 3 * sum(w * math.cos(a) for w, a in zip(weights, arguments)),
                h / 3 * sum(w * math.sin(a) for w, a in zip(weights, arguments)))

    def calc_angles(self, omega, mu, t, first_case):
        """Returns (2.10) or (2.11) as printed: gamma, psi."""
        amplitude, s0 = 0.75, 0.5
        radius = amplitude * math.sqrt(math.pi / (2 * abs(mu)))
        place = lambda at: math.sqrt(2 * abs(mu) / math.pi) * (at + omega / (2 * mu))
        (c, s), (c0, s_0) = self.calc_fresnel(place(t)), self.calc_fresnel(place(0))
        if first_case:
            a, b = (radius * f(s0 - omega**2 / (4 * mu)) for f in (math.cos, math.sin))
            return a * (s - s_0) + b * (c - c0), a * (c - c0) - b * (s - s_0)
        a, b = (radius * f(s0 + omega**2 / (4 * abs(mu))) for f in (math.cos, math.sin))
        return b * (c - c0) - a * (s - s_0), a * (c - c0) + b * (s - s_0)

    def test_2_10_and_2_11_are_distinguished_by_the_sign_of_mu_alone(self):
        for omega in (10, -10):
            for mu in (2.5, -2.5):
                integrals = [float(x) for x in FRESNEL[f"omega={omega},mu={mu}"]["int_p_dt_int_q_dt"]["2"]]
                right = self.calc_angles(omega, mu, 2, mu > 0)
                self.assertLess(math.dist(right, integrals), 1e-6)
                printed = self.calc_angles(omega, mu, 2, (omega > 0) == (mu > 0))
                self.assertEqual(math.dist(printed, integrals) > 0.05, omega < 0)

    def test_2_10_has_gamma_and_psi_exchanged(self):
        """Rates at phi = 0: by (2.3) gamma grows by q and psi by p; (2.10)'s gamma is the integral of p."""
        t = 1e-4
        gamma, psi = self.calc_angles(10, 2.5, t, True)
        p, q = 0.75 * math.sin(0.5), 0.75 * math.cos(0.5)
        self.assertAlmostEqual(gamma / t, p, delta=1e-3)
        self.assertAlmostEqual(psi / t, q, delta=1e-3)
        self.assertGreater(abs(gamma / t - q), WRONG)


if __name__ == "__main__":
    unittest.main(verbosity=2)
