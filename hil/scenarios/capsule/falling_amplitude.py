"""When the nutation of the dual-spin capsule falls: the condition of Anshakov et al. 2003, section 2, and what a run shows.

The axis goes round on a circle of radius G/|W| with G = sqrt(p^2 + q^2), which stays, and W = F' - r0, the rate of the phase F seen
from outside. By (2.6) F' = omega + 2 mu t at the beginning. The radius falls while |W| grows:

    sgn(omega - r0) = sgn(mu)

(the paper has sgn(omega) = sgn(mu), which is this for r0 = 0). Exactly, W = -H/A with the axial angular momentum
H = C2 r0 + C1(t) (r0 + sigma0) and A = A2 + A1(t). SI.
"""
import math

NEAR = 0.1     # s, between samples at the beginning and at the end
SMALL = 1e-5   # rad/s: small angles

class Case:
    """Inertias of the capsule (A2, C2) and of the motor at the beginning (A1, C1) and at the end (A1k, C1k) of a burn of T seconds;
    spin r0 of the capsule, sigma0 of the motor relative to it."""

    def __init__(self, A1=90.0, A1k=30.0, A2=180.0, C1=60.0, C1k=15.0, C2=120.0, T=20.0, r0=0.0, sigma0=6.0):
        self.A1, self.A1k, self.A2, self.C1, self.C1k, self.C2, self.T, self.r0, self.sigma0 = A1, A1k, A2, C1, C1k, C2, T, r0, sigma0

    def calc_omega_mu(self):
        """Of (2.6)."""
        a, c, a0 = (self.A1 - self.A1k) / self.T, (self.C1 - self.C1k) / self.T, self.A1 + self.A2
        k = self.r0 * (a0 - self.C1 - self.C2) - self.C1 * self.sigma0
        n = a * self.r0 - c * (self.r0 + self.sigma0)
        return k / a0, (a * k / a0**2 - n / a0) / 2

    def calc_condition(self):
        """Positive: the amplitude falls at first. The paper's is that with r0 = 0 in place of the first r0."""
        omega, mu = self.calc_omega_mu()
        return (omega - self.r0) * mu

    def calc_turning(self, t):
        """W = -H/A at the time t of the burn."""
        part = t / self.T
        lateral = self.A2 + self.A1 + part * (self.A1k - self.A1)
        axial = self.C2 * self.r0 + (self.C1 + part * (self.C1k - self.C1)) * (self.r0 + self.sigma0)
        return -axial / lateral

    def calc_ratio(self):
        """Amplitude just before the end by that just after the beginning, as calc_run_ratio() of a run."""
        return abs(self.calc_turning(NEAR) / self.calc_turning(self.T - NEAR))

    def list_options(self):
        """Of `unlatch run reference.yaml`, and the times at which calc_run_ratio() needs samples."""
        settings = {**{f"bodies.{body}.rate[{i}]": SMALL * (3 + 2 * i) for body in ("capsule", "motor") for i in (0, 1)},
                    "bodies.capsule.inertia": f"[{self.A2}, {self.A2}, {self.C2}]", "bodies.capsule.rate[2]": self.r0,
                    "bodies.motor.rate[2]": self.r0 + self.sigma0, "bodies.motor.law.at": f"[0, {self.T}]",
                    "bodies.motor.law.inertia": f"[[{self.A1}, {self.A1}, {self.C1}], [{self.A1k}, {self.A1k}, {self.C1k}]]"}
        options = [word for path, value in settings.items() for word in ("--set", f"{path}={value}")]
        times = (0, NEAR, 2 * NEAR, self.T - 2 * NEAR, self.T - NEAR, self.T)
        return [*options, "--until", str(self.T), "--sample", ",".join(f"{t:g}" for t in times)]


def calc_circle(points):
    """Radius of the circle through three points of the plane."""
    a, b, c = (math.dist(points[i], points[(i + 1) % 3]) for i in range(3))
    (x0, y0), (x1, y1), (x2, y2) = points
    return a * b * c / (2 * abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)))


def calc_run_ratio(samples):
    """The same as calc_ratio(), of the path of the axis in a run."""
    path = []
    for sample in samples:
        w, x, y, z = sample["bodies"]["capsule"]["q"]
        path.append((2 * (x * z + w * y), 2 * (y * z - w * x)))
    return calc_circle(path[3:]) / calc_circle(path[:3])
