#include "hil/run/audit/contact_jumps.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "hil/run/motion/contact_history.h"
#include "hil/scenario/base/index.h"
#include "unlatch/contacts.h"

namespace unlatch::hil {
namespace {

// A point that moves by more than this multiple of what its bodies slip and turn in a step has jumped.
constexpr double kMargin = 4;
// Jumps below this part of the shapes' size are none: where a rounding is small, its points are close to each other.
constexpr double kLeastPart = 1e-3;

// A body's placement and velocities in W; of the ground, at rest.
struct Carrier {
  geometry::Placement at;
  Vec3 v{0, 0, 0}, w{0, 0, 0};
};

Carrier get_carrier(const State& state, int body) {
  if (body == kGround) return {};
  const BodyState& own = state.bodies[at(body)];
  Carrier out{{own.p, rotation_matrix(own.q)}, own.v, {0, 0, 0}};
  out.w = out.at.R_WB * own.w;
  return out;
}

Vec3 to_body(const Carrier& carrier, const Vec3& point) {
  return transpose_times(carrier.at.R_WB, point - carrier.at.p_WB);
}

// 1/(kg m²) about the axis of the least inertia.
double calc_mobility(const Model& model, int body) {
  if (body == kGround) return 0;
  const Body& own = model.bodies[at(body)];
  const Body& carrier = own.marker ? model.bodies[at(own.marker->body)] : own;
  return 1 / Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(carrier.inertia, Eigen::EigenvaluesOnly)
                 .eigenvalues()
                 .minCoeff();
}

}  // namespace

ContactJumps::ContactJumps(const Simulation& simulation) : simulation_(simulation) {
  const Model& model = simulation.model();
  for (std::size_t c = 0; c < model.contacts.size(); ++c) {
    const Contact& contact = model.contacts[c];
    const Surface &base = model.surfaces[at(contact.base)], &follower = model.surfaces[at(contact.follower)];
    Watched watched{.base = base.body,
                    .follower = follower.body,
                    .mobility = std::max(calc_mobility(model, base.body), calc_mobility(model, follower.body)),
                    .pairs = {},
                    .sum = {.contact = static_cast<int>(c)}};
    int number = 0;
    for (const auto& [i, k] : list_contact_pairs(model, contact)) {
      const geometry::Shape &a = base.shapes[at(i)], &b = follower.shapes[at(k)];
      using enum geometry::ShapeKind;
      if (a.kind != kSphere && b.kind != kSphere)
        watched.pairs.push_back({number, geometry::build_group("", {&a, 1}), geometry::build_group("", {&b, 1}), {}});
      ++number;
    }
    if (!watched.pairs.empty()) watched_.push_back(std::move(watched));
  }
}

double ContactJumps::calc_jump(const Watched& watched, Pair& pair) const {
  const Carrier base = get_carrier(simulation_.state(), watched.base),
                follower = get_carrier(simulation_.state(), watched.follower);
  const geometry::Distance distance = geometry::calc_distance(pair.base, base.at, pair.follower, follower.at).least;
  const std::optional<Witnesses> before = pair.latest;
  pair.latest = {to_body(base, distance.on_a), to_body(follower, distance.on_b)};
  if (!before) return 0;
  const double way =
      std::min(norm(pair.latest->on_base - before->on_base), norm(pair.latest->on_follower - before->on_follower));
  const double size = 2 * std::min(pair.base.bound, pair.follower.bound);
  if (!(way > kLeastPart * size)) return 0;
  const Vec3 slip = follower.v + cross(follower.w, distance.on_a - follower.at.p_WB) - base.v -
                    cross(base.w, distance.on_a - base.at.p_WB);
  const double speed = norm(slip) + norm(follower.w - base.w) * size;
  return way > kMargin * simulation_.plan().get_options().dt * speed ? way : 0;
}

std::span<const ContactJumpSum> ContactJumps::update() {
  jumped_.clear();
  const Plan& plan = simulation_.plan();
  const State& state = simulation_.state();
  for (Watched& watched : watched_) {
    const auto add_speed = [&](int body) {
      if (body != kGround) watched.sum.fastest = std::max(watched.sum.fastest, norm(state.bodies[at(body)].w));
    };
    add_speed(watched.base);
    add_speed(watched.follower);
    const std::span<const ContactState> closed = get_contact_pairs(plan, state, watched.sum.contact);
    double longest = 0;
    for (Pair& pair : watched.pairs) {
      if (closed[at(pair.number)].closed != 0)
        longest = std::max(longest, calc_jump(watched, pair));
      else
        pair.latest.reset();
    }
    if (!(longest > 0)) continue;
    ++watched.sum.count;
    watched.sum.way = std::max(watched.sum.way, longest);
    watched.sum.turned +=
        longest * calc_contact(plan, state, watched.sum.contact).normal * plan.get_options().dt * watched.mobility;
    jumped_.push_back(watched.sum);
  }
  return jumped_;
}

}  // namespace unlatch::hil
