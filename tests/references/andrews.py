#!/usr/bin/python3
"""Andrews' squeezing mechanism by its planar equations of motion in seven angles (Hairer and Wanner, Solving Ordinary
Differential Equations II, VII.7; IVP test set of the Universities of Bari and Amsterdam), integrated with DOP853.

Not run by the tests: it shows that the constants of tests/kernel/mechanisms_test.cc are the published ones, and that
the published solution is theirs. Needs python3-scipy.    tests/references/andrews.py
"""
import numpy as np
from scipy.integrate import solve_ivp

m1, m2, m3, m4, m5, m6, m7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
i1, i2, i3, i4, i5, i6, i7 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5
xa, ya, xb, yb, xc, yc = -0.06934, -0.00227, -0.03635, 0.03273, 0.014, 0.072
c0, l0, mom = 4530, 0.07785, 0.033
d, da, e, ea, zf, fa, rr, ra = 0.028, 0.0115, 0.02, 0.01421, 0.02, 0.01421, 0.007, 0.00092
ss, sa, sb, sc, sd, ta, tb, u, ua, ub, zt = (0.035, 0.01874, 0.01043, 0.018, 0.02, 0.02308, 0.00916, 0.04, 0.01228,
                                             0.00449, 0.04)
START = [-0.0617138900142764496358948458001, 0, 0.455279819163070380255912382449, 0.222668390165885884674473185609,
         0.487364979543842550225598953530, -0.222668390165885884674473185609, 1.23054744454982119249735015568]
PUBLISHED = [15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
             0.5347301163226948, 1.048080741042263, 1139.920302151208, -1424.379294994111, 11.03291221937134,
             19.29337464421385, 0.5735699284790808, -19.29337464421385, 0.3231791658026955]


def calc_rates(_, y):
    q, v = y[:7], y[7:]
    be, th, ga, ph, de, om, ep = q
    bep, thp, gap, php, dep, omp, epp = v
    s, c = np.sin, np.cos
    M = np.zeros((7, 7))
    M[0, 0] = m1 * ra**2 + m2 * (rr**2 - 2 * da * rr * c(th) + da**2) + i1 + i2
    M[1, 0] = M[0, 1] = m2 * (da**2 - da * rr * c(th)) + i2
    M[1, 1] = m2 * da**2 + i2
    M[2, 2] = m3 * (sa**2 + sb**2) + i3
    M[3, 3] = m4 * (e - ea)**2 + i4
    M[4, 3] = M[3, 4] = m4 * ((e - ea)**2 + zt * (e - ea) * s(ph)) + i4
    M[4, 4] = m4 * (zt**2 + 2 * zt * (e - ea) * s(ph) + (e - ea)**2) + m5 * (ta**2 + tb**2) + i4 + i5
    M[5, 5] = m6 * (zf - fa)**2 + i6
    M[6, 5] = M[5, 6] = m6 * ((zf - fa)**2 - u * (zf - fa) * s(om)) + i6
    M[6, 6] = m6 * ((zf - fa)**2 - 2 * u * (zf - fa) * s(om) + u**2) + m7 * (ua**2 + ub**2) + i6 + i7
    xd, yd = sd * c(ga) + sc * s(ga) + xb, sd * s(ga) - sc * c(ga) + yb
    length = np.hypot(xd - xc, yd - yc)
    force = -c0 * (length - l0) / length
    fx, fy = force * (xd - xc), force * (yd - yc)
    f = np.array([mom - m2 * da * rr * thp * (thp + 2 * bep) * s(th), m2 * da * rr * bep**2 * s(th),
                  fx * (sc * c(ga) - sd * s(ga)) + fy * (sd * c(ga) + sc * s(ga)),
                  m4 * zt * (e - ea) * dep**2 * c(ph), -m4 * zt * (e - ea) * php * (php + 2 * dep) * c(ph),
                  -m6 * u * (zf - fa) * epp**2 * c(om), m6 * u * (zf - fa) * omp * (omp + 2 * epp) * c(om)])
    bt, pd, oe = be + th, ph + de, om + ep
    G = np.zeros((6, 7))
    G[0::2, 0], G[1::2, 0] = -rr * s(be) + d * s(bt), rr * c(be) - d * c(bt)
    G[0::2, 1], G[1::2, 1] = d * s(bt), -d * c(bt)
    G[0, 2], G[1, 2] = -ss * c(ga), -ss * s(ga)
    G[2, 3], G[3, 3] = -e * c(pd), -e * s(pd)
    G[2, 4], G[3, 4] = -e * c(pd) + zt * s(de), -e * s(pd) - zt * c(de)
    G[4, 5], G[5, 5] = zf * s(oe), -zf * c(oe)
    G[4, 6], G[5, 6] = zf * s(oe) - u * c(ep), -zf * c(oe) - u * s(ep)
    crank = np.array([-rr * c(be) * bep**2 + d * c(bt) * (bep + thp)**2,
                      -rr * s(be) * bep**2 + d * s(bt) * (bep + thp)**2])
    drift = np.tile(crank, 3)
    drift += [ss * s(ga) * gap**2, -ss * c(ga) * gap**2,
              e * s(pd) * (php + dep)**2 + zt * c(de) * dep**2, -e * c(pd) * (php + dep)**2 + zt * s(de) * dep**2,
              zf * c(oe) * (omp + epp)**2 + u * s(ep) * epp**2, zf * s(oe) * (omp + epp)**2 - u * c(ep) * epp**2]
    K = np.block([[M, G.T], [G, np.zeros((6, 6))]])
    a = np.linalg.solve(K, np.concatenate([f, -drift]))[:7]
    return np.concatenate([v, a])


def main():
    run = solve_ivp(calc_rates, (0, 0.03), np.array(START + [0.0] * 7), method="DOP853", rtol=1e-12, atol=1e-13)
    for name, ours, theirs in zip(["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"] * 2, run.y[:, -1],
                                  PUBLISHED):
        print(f"{name:8} {ours:22.15g} published {theirs:22.15g}  difference {ours - theirs:9.1e}")


if __name__ == "__main__":
    main()
