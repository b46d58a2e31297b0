#!/usr/bin/python3
"""Bodies near the Earth, integrated by SciPy (DOP853, rtol 3e-14).

Prints the JSON of tests/data/flight.json. Independent of unlatch: places by the closed form of latitude and longitude and, inwards,
by Newton's method on the altitude; gravity and its gradient as complex-step derivatives of the potential; the standard atmosphere
and all frames written out here. Fixed axes at the centre, whatever the frame of the scenario.
"""
import json

import numpy as np
from scipy.integrate import solve_ivp

A, F, MU, J2, RATE = 6378137.0, 1 / 298.257223563, 3.986004418e14, 1.08262982e-3, 7.292115e-5
B, E2 = A * (1 - F), F * (2 - F)
FOOT, SLUG = 0.3048, 14.593902937206365
DEGREE = np.pi / 180
OMEGA = np.array([0, 0, RATE])


# --- Gravity ---------------------------------------------------------------------------------------------------------

def potential(r):
    d2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    d = np.sqrt(d2)
    s2 = r[2] * r[2] / d2
    return MU / d * (1 - J2 * A * A / d2 * (3 * s2 - 1) / 2)


def gravity(r):
    """Complex steps: no difference is taken."""
    g = np.zeros(3, dtype=complex if np.iscomplexobj(r) else float)
    if np.iscomplexobj(r):  # for the gradient, by the closed form
        d = np.sqrt(r @ r)
        s = r[2] / d
        k = -1.5 * J2 * MU * A * A / d**4
        g = -MU * r / d**3 + k * ((1 - 5 * s * s) * r / d + 2 * s * np.array([0, 0, 1]))
        return g
    for i in range(3):
        step = r.astype(complex)
        step[i] += 1e-20j
        g[i] = potential(step).imag / 1e-20
    return g


def gradient(r):
    G = np.zeros((3, 3))
    for i in range(3):
        step = r.astype(complex)
        step[i] += 1e-20j
        G[:, i] = gravity(step).imag / 1e-20
    return G


def gradient_torque(r, R, inertia):
    """Sum of x × G x over the body, body axes, from the second moments of its mass."""
    second = np.diag(0.5 * np.sum(inertia) - np.array(inertia))
    M = R.T @ gradient(r) @ R @ second  # Σ m (G x) xᵀ
    return np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]])


# --- Places ----------------------------------------------------------------------------------------------------------

def place(latitude, longitude, altitude):
    s, c = np.sin(latitude), np.cos(latitude)
    N = A / np.sqrt(1 - E2 * s * s)
    return np.array([(N + altitude) * c * np.cos(longitude), (N + altitude) * c * np.sin(longitude), ((1 - E2) * N + altitude) * s])


def geodetic(r):
    """Latitude, altitude by fixed-point iteration to rounding."""
    rho = np.hypot(r[0], r[1])
    latitude = np.arctan2(r[2], rho * (1 - E2))
    for _ in range(60):
        s = np.sin(latitude)
        N = A / np.sqrt(1 - E2 * s * s)
        latitude = np.arctan2(r[2] + E2 * N * s, rho)
    s, c = np.sin(latitude), np.cos(latitude)
    return latitude, rho * c + r[2] * s - A * np.sqrt(1 - E2 * s * s)


def local_axes(latitude, longitude):
    """Columns north, east, down."""
    s, c, sl, cl = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    return np.array([[-s * cl, -sl, -c * cl], [-s * sl, cl, -c * sl], [c, 0, -s]])


def euler_matrix(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


# --- Air -------------------------------------------------------------------------------------------------------------

G0, R0, GAS = 9.80665, 6356766.0, 8314.32 / 28.9644
LAYERS = [(0, -6.5e-3), (11e3, 0), (20e3, 1e-3), (32e3, 2.8e-3), (47e3, 0), (51e3, -2.8e-3), (71e3, -2e-3)]


def air(z, layer=None):
    """Density, pressure, temperature up to 86 km. A given layer's law goes on beyond its borders."""
    H = R0 * z / (R0 + z)
    T, p = 288.15, 101325.0
    for i, (base, lapse) in enumerate(LAYERS):
        top = LAYERS[i + 1][0] if i + 1 < len(LAYERS) else np.inf
        last = H <= top if layer is None else i == layer
        rise = (H if last else top) - base
        p *= np.exp(-G0 * rise / (GAS * T)) if lapse == 0 else (1 + lapse * rise / T) ** (-G0 / (GAS * lapse))
        T += lapse * rise
        if last:
            break
    return p / (GAS * T), p, T


# --- Motion ----------------------------------------------------------------------------------------------------------

def matrix(q):
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def quaternion(R):
    w = np.sqrt(max(0, 1 + np.trace(R))) / 2
    if w > 0.1:
        return np.array([w, (R[2, 1] - R[1, 2]) / (4 * w), (R[0, 2] - R[2, 0]) / (4 * w), (R[1, 0] - R[0, 1]) / (4 * w)])
    values, vectors = np.linalg.eigh(np.array([
        [R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]],
        [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]],
        [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]]]))
    return vectors[[3, 0, 1, 2], np.argmax(values)]


class Body:
    """mass, inertia (diagonal); forces(flow) -> force, moment in body axes, or none; wind(altitude) -> north, east, down; air(altitude)."""

    def __init__(self, mass, inertia, forces=None, wind=None, torque=True, air=air):
        self.mass, self.inertia, self.forces, self.wind, self.torque, self.air = mass, np.array(inertia, float), forces, wind, torque, air

    def flow(self, r, v, R, w):
        latitude, altitude = geodetic(r)
        axes = local_axes(latitude, np.arctan2(r[1], r[0]))
        through = v - np.cross(OMEGA, r) - axes @ (self.wind(altitude) if self.wind else np.zeros(3))
        density, pressure, temperature = self.air(altitude)
        return {"u": R.T @ through, "density": density, "sound": np.sqrt(1.4 * pressure / density), "w": w - R.T @ OMEGA,
                "altitude": altitude}

    def __call__(self, _, y):
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:13]
        R = matrix(q)
        force, moment = np.zeros(3), np.zeros(3)
        if self.forces:
            force, moment = self.forces(self.flow(r, v, R, w))
        if self.torque:
            moment = moment + gradient_torque(r, R, self.inertia)
        faster = (moment - np.cross(w, self.inertia * w)) / self.inertia
        return np.concatenate([v, gravity(r) + R @ force / self.mass, turn(q, w), faster])


def look_around(r, v, R, air, wind):
    """Density and pressure; velocity through the air, speed, Mach number, angle of attack, sideslip; roll, pitch, yaw; of body axes R."""
    latitude, altitude = geodetic(r)
    local = local_axes(latitude, np.arctan2(r[1], r[0]))
    density, pressure = air(altitude)[:2]
    u = R.T @ (v - np.cross(OMEGA, r) - local @ wind(altitude))
    V, E = np.linalg.norm(u), local.T @ R
    return {"density": density, "pressure": pressure, "u": u, "V": V, "mach": V / np.sqrt(1.4 * pressure / density),
            "alpha": np.arctan2(u[2], u[0]), "beta": np.arcsin(u[1] / V), "roll": np.arctan2(E[2, 1], E[2, 2]),
            "pitch": np.arctan2(-E[2, 0], np.hypot(E[0, 0], E[1, 0])), "yaw": np.arctan2(E[1, 0], E[0, 0])}


def cross_matrix(x):
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])


def accelerate(parts, r, R, w, force, moment, torque):
    """Accelerations of a point of a rigid body of several parts (mass, centre from the point, inertia about it), and of its rates; body axes.

    `force`, `moment`: about that point, without gravity. `torque`: with that of the gradient of gravity over each part."""
    M = np.zeros((6, 6))
    for mass, centre, inertia in parts:
        X = cross_matrix(centre)
        pull = mass * (R.T @ gravity(r + R @ centre) - np.cross(w, np.cross(w, centre)))
        force, moment = force + pull, moment + np.cross(centre, pull) - np.cross(w, inertia @ w)
        if torque:
            moment = moment + gradient_torque(r + R @ centre, R, np.diag(inertia))
        M += np.block([[mass * np.eye(3), -mass * X], [mass * X, inertia - mass * X @ X]])
    a = np.linalg.solve(M, np.concatenate([force, moment]))
    return a[:3], a[3:]


def turn(q, w):
    """The quaternion's rate."""
    return 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])


def start(latitude, longitude, altitude, velocity, euler, rate, inertial=False, rate_relative_to="inertial"):
    r = place(latitude, longitude, altitude)
    axes = local_axes(latitude, longitude)
    v = axes @ np.array(velocity, float) + (0 if inertial else np.cross(OMEGA, r))
    R = axes @ euler_matrix(*euler)
    w = np.array(rate, float) + (R.T @ OMEGA if rate_relative_to == "planet" else 0)
    return np.concatenate([r, v, quaternion(R), w])


def fly(body, y, end):
    return solve_ivp(body, (0, end), y, "DOP853", rtol=3e-14, atol=1e-12, max_step=1).y[:, -1]


def describe(y, end):
    """What a run's quantities have: place, velocity over the surface, Euler angles, rates."""
    r, v, R = y[:3], y[3:6], matrix(y[6:10])
    latitude, altitude = geodetic(r)
    angle = np.arctan2(r[1], r[0])
    axes = local_axes(latitude, angle)
    over = axes.T @ (v - np.cross(OMEGA, r))
    E = axes.T @ R
    longitude = (angle - RATE * end + np.pi) % (2 * np.pi) - np.pi
    return {"altitude": altitude, "latitude": latitude, "longitude": longitude, "north": over[0], "east": over[1], "down": over[2],
            "roll": np.arctan2(E[2, 1], E[2, 2]), "pitch": np.arctan2(-E[2, 0], np.hypot(E[0, 0], E[1, 0])),
            "yaw": np.arctan2(E[1, 0], E[0, 0]), "p": y[10], "q": y[11], "r": y[12], "inertial_position": list(y[:3]),
            "inertial_velocity": list(y[3:6])}


def drag(area, coefficient):
    return lambda flow: (-0.5 * flow["density"] * np.linalg.norm(flow["u"]) * area * coefficient * flow["u"], np.zeros(3))


SPHERE = (SLUG, np.full(3, 3.6) * SLUG * FOOT**2)
BRICK = (0.155404754 * SLUG, np.array([0.00189422, 0.006211019, 0.007194665]) * SLUG * FOOT**2)
SPHERE_DRAG = drag(0.1963495 * FOOT**2, 0.1)


def damp(area, lengths, derivatives):
    lengths, derivatives = np.array(lengths), np.array(derivatives)
    return lambda flow: (np.zeros(3), 0.25 * flow["density"] * np.linalg.norm(flow["u"]) * area * lengths**2 * derivatives * flow["w"])


def main():
    level, tumbling = (0, 0, 0), np.array([10, 20, 30]) * DEGREE
    high = 30000 * FOOT
    cases = {}

    def add(name, body, end, **kwargs):
        given = {"latitude": 0, "longitude": 0, "altitude": high, "velocity": (0, 0, 0), "euler": level, "rate": (0, 0, 0), **kwargs}
        cases[name] = {"t": end, **describe(fly(body, start(**given), end), end)}

    add("case01", Body(*SPHERE, torque=False), 30)
    add("case02", Body(*BRICK, torque=False), 30, rate=tumbling)
    add("case03", Body(*BRICK, torque=False, forces=damp(0.22222 * FOOT**2, np.array([0.33333, 0.66667, 0.33333]) * FOOT, (-1, -1, -1))), 30,
        rate=tumbling)
    add("case06", Body(*SPHERE, torque=False, forces=SPHERE_DRAG), 30)
    add("case07", Body(*SPHERE, torque=False, forces=SPHERE_DRAG, wind=lambda _: np.array([0, 20 * FOOT, 0])), 30)
    add("case08", Body(*SPHERE, torque=False, forces=SPHERE_DRAG,
                       wind=lambda z: np.array([0, (70 * min(max(z / high, 0), 1) - 20 * min(max(1 - z / high, 0), 1)) * FOOT, 0])), 30)
    add("case09", Body(*SPHERE, torque=False, forces=SPHERE_DRAG), 30, altitude=0, velocity=(0, 1000 * FOOT, -1000 * FOOT),
        euler=(0, 0, np.pi / 2), rate_relative_to="planet")
    global A, B, F, E2, J2, RATE, OMEGA
    kept = A, B, F, E2, J2, RATE, OMEGA
    B, F, E2, J2 = A, 0, 0, 0  # a sphere, with the equator's radius
    add("case05", Body(*SPHERE, torque=False, forces=SPHERE_DRAG), 30)
    RATE, OMEGA = 0, np.zeros(3)
    add("case04", Body(*SPHERE, torque=False, forces=SPHERE_DRAG), 30)
    A, B, F, E2, J2, RATE, OMEGA = kept
    add("case10", Body(*SPHERE, torque=False, forces=SPHERE_DRAG), 30, altitude=0, velocity=(1000 * FOOT, 0, -1000 * FOOT), rate_relative_to="planet")
    add("gradient", Body(400, (40, 90, 100)), 600, latitude=0.4, longitude=-1.2, altitude=400e3, velocity=(4000, 6500, -100),
        euler=(0.3, -0.4, 1.1), rate=(0.002, -0.001, 0.003))
    print(json.dumps({"about": "tests/references/flight_reference.py", "cases": cases}, indent=1))


if __name__ == "__main__":
    main()
