// A model moved to a point of a trajectory.
#include "kernel/environment/environment.h"
#include "kernel/model/from_eigen.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// A turn about x, y or z.
Quat turn_about(int axis, double angle) {
  double sine, cosine;
  elementary::sincos(0.5 * angle, sine, cosine);
  return {cosine, axis == 0 ? sine : 0, axis == 1 ? sine : 0, axis == 2 ? sine : 0};
}

// Of a frame from north, east, down.
Quat get_attitude(const Start& start) {
  const Vec3 v = to_vec(start.velocity);
  const Eigen::Vector3d euler = start.euler.value_or(Eigen::Vector3d(0, calc_path_angle(v), calc_azimuth(v)));
  return turn_about(2, euler.z()) * turn_about(1, euler.y()) * turn_about(0, euler.x());
}

// Angular velocity of the axes north, east, down that fly over the planet with the velocity v in them; in them, seen
// from the planet, rad/s. M and N: radii of curvature along the meridian and across it.
Vec3 calc_transport(const PlanPlanet& planet, const PlanetPlace& place, const Vec3& v) {
  const Geodetic& g = place.geodetic;
  const double e2 = planet.flattening * (2 - planet.flattening), root = 1 - e2 * (g.sine * g.sine);
  const double N = planet.radius / std::sqrt(root), M = N * (1 - e2) / root;
  const double east = v.y / (N + g.altitude);
  return {east, -v.x / (M + g.altitude), -east * (g.sine / g.cosine)};
}

// A frame that moves in W.
struct MovingFrame {
  Vec3 p, v;  // m, m/s
  Quat q;     // to W
  Vec3 w_W;   // angular velocity, W, rad/s
};

MovingFrame get_frame(const Model& model, int body) {
  if (body == kGround) return {{0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}};
  const Body& b = model.bodies[static_cast<std::size_t>(body)];
  const Quat q = to_quat(b.q_WB);
  return {to_vec(b.p_WB), to_vec(b.v_WB), q, rotation_matrix(q) * to_vec(b.w_WB_B)};
}

// Moves a body with the frame, which goes from `old` to `now`.
void move(Body& body, const MovingFrame& old, const MovingFrame& now) {
  const Quat turn = now.q * conjugate(old.q);
  const Mat3 R = rotation_matrix(turn);
  const Vec3 arm = R * (to_vec(body.p_WB) - old.p), spin = now.w_W - R * old.w_W;
  const Quat q = normalized(turn * to_quat(body.q_WB));
  body.p_WB = to_eigen(now.p + arm);
  body.v_WB = to_eigen((now.v + R * (to_vec(body.v_WB) - old.v)) + cross(spin, arm));
  body.w_WB_B = to_eigen(to_vec(body.w_WB_B) + transpose_times(rotation_matrix(q), spin));
  body.q_WB = Attitude(q.w, q.x, q.y, q.z);
}

}  // namespace

Model place_start(const Model& model, const Start& start) {
  Model out = model;
  Planet& planet = *out.environment.planet;
  const PlanPlanet own = compile_planet(planet);
  const double longitude = start.longitude + planet.meridian;
  const PlanetPlace place = place_at(own, start.latitude, longitude, start.altitude);
  constexpr double kRightAngle = 1.5707963267948966;
  const Quat down = turn_about(2, longitude) * turn_about(1, -(start.latitude + kRightAngle));
  const Quat pole = to_quat(Eigen::Quaterniond(
      (Eigen::Matrix3d() << to_eigen(own.axes.x), to_eigen(own.axes.y), to_eigen(own.axes.z)).finished()));
  const Vec3 surface = calc_surface_velocity(own, place.r), given = place.axes * to_vec(start.velocity);
  const Vec3 v = start.inertial ? given : given + surface;

  MovingFrame now;
  now.p = own.axes * place.r;
  now.v = own.axes * v;
  now.q = normalized(pole * down * get_attitude(start));
  now.w_W = rotation_matrix(now.q) * to_vec(start.rate);
  if (start.turns != Start::Turns::kInertial) now.w_W += planet.rate * own.axes.z;
  if (start.turns == Start::Turns::kLocal)
    now.w_W += own.axes * (place.axes * calc_transport(own, place, transpose_times(place.axes, v - surface)));
  if (start.origin == Start::Origin::kKept) {
    const OriginMotion origin = calc_origin(own, 0);
    now.p -= origin.r;
    if (planet.falling) now.v -= origin.v;
  } else {
    planet.centre = -to_eigen(now.p);
    planet.falling = start.origin == Start::Origin::kFalling;
    planet.velocity = planet.falling ? to_eigen(now.v) : Eigen::Vector3d::Zero();
    now.p = {0, 0, 0};
    if (planet.falling) now.v = {0, 0, 0};
  }
  const MovingFrame old = get_frame(model, start.body);
  for (Body& body : out.bodies) move(body, old, now);
  return out;
}

}  // namespace unlatch
