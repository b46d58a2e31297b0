#include "kernel/environment/field.h"

namespace unlatch {
namespace {

double cube(double x) { return x * (x * x); }

Vec3 calc_central(const PlanPlanet& planet, const Vec3& o, const Vec3& p, const Vec3& r, double distance) {
  if (!planet.falling) return (-planet.mu / cube(distance)) * r;
  const double o2 = dot(o, o), q = dot(p, p + 2.0 * o) / o2;
  const double power = (1 + q) * std::sqrt(1 + q);
  const double F = q * (3 + q * (3 + q)) / (power * (power + 1));
  return (-planet.mu / (o2 * std::sqrt(o2))) * (p - F * r);
}

// −(3/2) J2 μ a²
double get_zonal(const PlanPlanet& planet) { return -1.5 * planet.j2 * planet.mu * (planet.radius * planet.radius); }

}  // namespace

Vec3 calc_planet_gravity(const PlanPlanet& planet, const Vec3& o, const Vec3& p) noexcept {
  const Vec3 r = o + p;
  const double distance = norm(r);
  Vec3 g = calc_central(planet, o, p, r, distance);
  if (planet.j2 != 0) {
    const Vec3 up = (1 / distance) * r;
    const double s = dot(up, planet.axes.z), d2 = distance * distance;
    g += (get_zonal(planet) / (d2 * d2)) * ((1 - 5 * (s * s)) * up + (2 * s) * planet.axes.z);
  }
  return g;
}

Vec3 calc_gradient_torque(const PlanPlanet& planet, const Vec3& o, const Vec3& p, const Sym3& J) noexcept {
  const Vec3 r = o + p;
  const double distance = norm(r);
  const Vec3 up = (1 / distance) * r, own = cross(up, J * up);
  Vec3 torque = (3 * planet.mu / cube(distance)) * own;
  if (planet.j2 != 0) {
    const Vec3& n = planet.axes.z;
    const double s = dot(up, n);
    const Vec3 mixed = cross(up, J * n) + cross(n, J * up);
    torque += (get_zonal(planet) / (cube(distance) * (distance * distance))) *
              (((35 * (s * s) - 5) * own - (10 * s) * mixed) + 2.0 * cross(n, J * n));
  }
  return torque;
}

}  // namespace unlatch
