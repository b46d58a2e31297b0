#include "kernel/environment/environment.h"

#include "unlatch/elementary.h"

namespace unlatch {

Flight calc_flight(const PlanPlanet& planet, double t, const Vec3& p, const Vec3& v) noexcept {
  const OriginMotion origin = calc_origin(planet, t);
  Flight out;
  out.place = calc_place(planet, transpose_times(planet.axes, origin.r + p));
  out.v = transpose_times(planet.axes, origin.v + v);
  out.over_surface = out.v - calc_surface_velocity(planet, out.place.r);
  return out;
}

AirFlow calc_air_flow(const PlanPlanet& planet, const AirAround& around, const Flight& flight, const Mat3& R) noexcept {
  AirFlow out;
  const double altitude = flight.place.geodetic.altitude;
  out.air = calc_air(around.air, altitude);
  Vec3 v = flight.over_surface;
  if (!around.wind.empty()) v -= flight.place.axes * calc_wind(around.wind, altitude);
  out.velocity = transpose_times(R, planet.axes * v);
  const double v2 = dot(out.velocity, out.velocity);
  out.speed = std::sqrt(v2);
  out.dynamic_pressure = 0.5 * out.air.density * v2;
  return out;
}

double calc_angle_of_attack(const Vec3& velocity) noexcept { return elementary::atan2(velocity.z, velocity.x); }

double calc_sideslip(const Vec3& velocity) noexcept {
  return elementary::atan2(velocity.y, std::sqrt(velocity.x * velocity.x + velocity.z * velocity.z));
}

double calc_path_angle(const Vec3& velocity) noexcept {
  return elementary::atan2(-velocity.z, std::sqrt(velocity.x * velocity.x + velocity.y * velocity.y));
}

double calc_azimuth(const Vec3& velocity) noexcept { return elementary::atan2(velocity.y, velocity.x); }

// Of R = Rz Ry Rx the first column is (cψ cθ, sψ cθ, −sθ), and the last row ends in cθ sφ, cθ cφ.
Vec3 calc_euler(const Mat3& R) noexcept {
  const double across = std::sqrt(R.x.x * R.x.x + R.x.y * R.x.y);
  return {elementary::atan2(R.y.z, R.z.z), elementary::atan2(-R.x.z, across), elementary::atan2(R.x.y, R.x.x)};
}

}  // namespace unlatch
