#include "hil/run/notices/contact_resolution.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "hil/run/notices/format.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {
namespace {

const Body* find_body(const Model& model, int surface) {
  const int body = model.surfaces[static_cast<std::size_t>(surface)].body;
  if (body == kGround) return nullptr;
  const Body& own = model.bodies[static_cast<std::size_t>(body)];
  return own.marker ? &model.bodies[static_cast<std::size_t>(own.marker->body)] : &own;
}

// Mobility, 1/kg: acceleration along u of a point of a body, per force along u there.
double calc_mobility(const Model& model, const State& state, int surface, const Vec3& point, const Vec3& u) {
  const Body* const body = find_body(model, surface);
  if (body == nullptr) return 0;
  const BodyState& at = state.bodies[static_cast<std::size_t>(body - model.bodies.data())];
  const Vec3 arm = transpose_times(rotation_matrix(at.q), cross(point - at.p, u));
  const Eigen::Vector3d lever(arm.x, arm.y, arm.z);
  return 1 / body->mass + lever.dot(body->inertia.ldlt().solve(lever));
}

}  // namespace

ContactRates calc_rates(const Model& model, const State& state, const Contact& contact, const ContactReading& reading) {
  ContactRates rates;
  if (!reading.closed || !(reading.normal > 0)) return rates;
  const auto calc = [&](const Vec3& u) {
    return calc_mobility(model, state, contact.base, reading.point, u) +
           calc_mobility(model, state, contact.follower, reading.point, u);
  };
  // Friction turns the force away from the normal by less than atan μ.
  const Vec3 n = (1 / norm(reading.force)) * reading.force;
  const Vec3 helper = std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 across = cross(n, helper), t = (1 / norm(across)) * across;
  const double along_n = calc(n), along_t = std::max(calc(t), calc(cross(n, t)));
  rates.omega = std::sqrt(reading.stiffness * along_n);
  const double speed = std::hypot(reading.slip, contact.slip_speed);
  rates.decay = contact.friction * reading.normal / speed * along_t;
  return rates;
}

double estimate_speed(const Model& model, const State& state, const Contact& contact) {
  constexpr double kLeast = 1e-3, kAssumed = 1;  // m/s
  if (contact.restitution) return contact.speed;
  const auto get_body = [&](int surface) -> const BodyState* {
    const int body = model.surfaces[static_cast<std::size_t>(surface)].body;
    return body == kGround ? nullptr : &state.bodies[static_cast<std::size_t>(body)];
  };
  const BodyState *base = get_body(contact.base), *follower = get_body(contact.follower);
  const Vec3 none{0, 0, 0};
  const Vec3 gap = (follower ? follower->p : none) - (base ? base->p : none);
  const Vec3 v = (follower ? follower->v : none) - (base ? base->v : none);
  return dot(gap, v) < 0 && norm(v) > kLeast ? norm(v) : kAssumed;
}

double calc_least_mobility(const Model& model, const Contact& contact) {
  const auto get_mobility = [&](int surface) {
    const Body* const body = find_body(model, surface);
    return body == nullptr ? 0 : 1 / body->mass;
  };
  return get_mobility(contact.base) + get_mobility(contact.follower);
}

double calc_most_mobility(const Model& model, const Contact& contact) {
  const auto get_mobility = [&](int surface) {
    const Body* const body = find_body(model, surface);
    if (body == nullptr) return 0.0;
    const geometry::ShapeGroup group =
        geometry::build_group("", model.surfaces[static_cast<std::size_t>(surface)].shapes);
    const double arm = norm(group.centre) + group.bound;
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body->inertia, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
    return 1 / body->mass + (std::isfinite(arm) ? arm * arm / least : 0);
  };
  return get_mobility(contact.base) + get_mobility(contact.follower);
}

ContactRates estimate_rates(const Model& model, const Contact& contact, double speed) {
  const double mobility = calc_least_mobility(model, contact);
  // ½ m v² = k δ^(n+1) / (n+1) at the greatest depth of an elastic impact
  const double n = contact.exponent, energy = speed * speed / (2 * mobility);
  const double depth = std::pow((n + 1) * energy / contact.stiffness, 1 / (n + 1));
  const double slope = contact.exponent > 1 ? contact.stiffness * n * std::pow(depth, n - 1) : contact.stiffness;
  // Friction stops the slip the fastest where it is slow and the force the greatest.
  const double force = contact.stiffness * std::pow(depth, n);
  return {std::sqrt(slope * mobility), contact.friction * force * mobility / contact.slip_speed};
}

std::string describe_unresolved(const ContactRates& rates, double dt, int parts) {
  const double need = rates.calc_need(), h = dt / parts;
  if (!(h * need > 1)) return "";
  const bool blow = rates.omega / kAccurate > rates.decay / kStable;
  const double size = h * (blow ? rates.omega : rates.decay);
  return format("%s %.3g: %s; a step of %.3g s would do%s",
                blow ? "sqrt(k/m)·h" : "h times the rate at which friction stops the slip", size,
                size > kStable ? "beyond what is stable" : "not resolved accurately", parts / need * kRoundedDown,
                parts < kMaxContactSubsteps ? ", or more contact_substeps" : "");
}

}  // namespace unlatch::hil
