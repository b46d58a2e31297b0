#include "hil/run/analysis/assemblies.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "unlatch/inertia.h"

namespace unlatch::hil {
namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

Vector to_vector(const Vec3& v) { return {v.x, v.y, v.z}; }

struct MassProperties {
  double mass;
  Vector centre;   // from the origin, body axes
  Matrix inertia;  // about the centre, body axes
};

// Mass properties: linear between the knots of a law, constant beyond them.
MassProperties calc_properties(const Body& body, double time, double burnt) {
  if (!body.law) return {body.mass, Vector::Zero(), body.inertia};
  const std::vector<MassLaw::Knot>& knots = body.law->knots;
  const double x = body.law->of == MassLaw::Of::kTime ? time : burnt;
  const auto above = std::find_if(knots.begin(), knots.end(), [&](const MassLaw::Knot& knot) { return knot.at > x; });
  if (above == knots.begin() || above == knots.end()) {
    const MassLaw::Knot& knot = above == knots.end() ? knots.back() : knots.front();
    return {knot.mass, knot.centre, knot.inertia};
  }
  const MassLaw::Knot &b = *above, &a = *(above - 1);
  const double s = (x - a.at) / (b.at - a.at);
  return {a.mass + s * (b.mass - a.mass), a.centre + s * (b.centre - a.centre),
          a.inertia + s * (b.inertia - a.inertia)};
}

}  // namespace

Assemblies::Assemblies(const Model& model, const State& state, Holding holding) : roots_(model.bodies.size() + 1) {
  std::iota(roots_.begin(), roots_.end(), 0);
  const auto find = [&](int i) {
    while (roots_[static_cast<std::size_t>(i)] != i) i = roots_[static_cast<std::size_t>(i)];
    return i;
  };
  const auto unite = [&](int a, int b) {
    const int i = find(a + 1), j = find(b + 1);
    roots_[static_cast<std::size_t>(std::max(i, j))] = std::min(i, j);
  };
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const RowSet rows = joint.modes[static_cast<std::size_t>(state.joints[i].mode)].rows;
    if (holding == Holding::kAny ? rows != 0 : rows == (kPointRows | kRotationRows)) unite(joint.base, joint.follower);
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].marker) unite(model.bodies[b].marker->body, static_cast<int>(b));
  for (std::size_t i = 0; i < roots_.size(); ++i) roots_[i] = find(static_cast<int>(i));
}

std::vector<int> Assemblies::list(int body) const {
  std::vector<int> list;
  for (int i = kGround; i + 1 < static_cast<int>(roots_.size()); ++i)
    if (are_joined(i, body)) list.push_back(i);
  return list;
}

AssemblyMotion calc_motion(const Model& model, const std::vector<int>& list, const std::vector<BodyState>& bodies,
                           double time, std::span<const double> burnt) {
  AssemblyMotion sum;
  if (std::find(list.begin(), list.end(), kGround) != list.end()) return sum;
  struct Part {
    double mass;
    Vector p, v, w;
    Matrix J;
  };
  std::vector<Part> parts;
  std::size_t law = 0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const double gone = body.law && law < burnt.size() ? burnt[law] : 0;
    law += body.law.has_value();
    if (body.marker || std::find(list.begin(), list.end(), static_cast<int>(b)) == list.end()) continue;
    const MassProperties own = calc_properties(body, time, gone);
    const BodyState& state = bodies[b];
    const Matrix R = Eigen::Quaterniond(state.q.w, state.q.x, state.q.y, state.q.z).normalized().toRotationMatrix();
    const Vector w = R * to_vector(state.w), centre = R * own.centre;
    parts.push_back({own.mass, to_vector(state.p) + centre, to_vector(state.v) + w.cross(centre), w,
                     R * own.inertia * R.transpose()});
    sum.mass += own.mass;
    sum.p += own.mass * parts.back().p;
    sum.v += own.mass * parts.back().v;
  }
  if (!(sum.mass > 0)) return {};
  sum.p /= sum.mass;
  sum.v /= sum.mass;
  for (const Part& part : parts) {
    const Vector r = part.p - sum.p;
    sum.angular_momentum += part.J * part.w + part.mass * r.cross(part.v - sum.v);
    sum.inertia += part.J + part.mass * (r.squaredNorm() * Matrix::Identity() - r * r.transpose());
  }
  return sum;
}

Coning calc_coning(const AssemblyMotion& motion) {
  Coning coning{0, std::numeric_limits<double>::infinity()};
  const double size = motion.angular_momentum.norm();
  constexpr double kSlowest = 1e-9;  // rad/s: slower rotation is the rounding of a run
  if (!(motion.mass > 0) || !(size > kSlowest * motion.inertia.trace())) return coning;
  const PrincipalAxes principal = calc_principal_axes(motion.inertia);
  const Vector& moments = principal.moments;
  const int axis = moments[1] - moments[0] > moments[2] - moments[1] ? 0 : 2;
  const double across = axis == 0 ? 0.5 * (moments[1] + moments[2]) : 0.5 * (moments[0] + moments[1]);
  const Vector e = principal.axes.col(axis);
  const double along = std::abs(e.dot(motion.angular_momentum));
  coning.half_angle = std::atan2(e.cross(motion.angular_momentum).norm(), along);
  coning.period = 2 * 3.141592653589793 * across / size;
  return coning;
}

}  // namespace unlatch::hil
