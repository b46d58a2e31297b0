#include "kernel/step/velocities.h"

#include <cmath>
#include <utility>

#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

Vec3 to_vec3(const Eigen::Ref<const Eigen::Vector3d>& a) { return {a[0], a[1], a[2]}; }

}  // namespace

Velocities::Velocities(const PlanData& plan) : plan_(plan), first_(plan.bodies.size(), kNone) {
  std::vector<bool> marker(plan.bodies.size(), false);
  for (const PlanMarker& own : plan.markers) marker[at(own.body)] = true;
  for (std::size_t b = 0; b < first_.size(); ++b)
    if (!marker[b]) first_[b] = std::exchange(size_, size_ + 6);
  for (const PlanFlexible& own : plan.flexible) modal_.push_back(std::exchange(size_, size_ + own.modes));
}

Eigen::VectorXd Velocities::read(const State& state) const {
  Eigen::VectorXd v(size_);
  for (std::size_t b = 0; b < first_.size(); ++b) {
    if (first_[b] == kNone) continue;
    v.segment<3>(first_[b]) = to_eigen(state.bodies[b].v);
    v.segment<3>(first_[b] + 3) = to_eigen(state.bodies[b].w);
  }
  for (std::size_t i = 0; i < modal_.size(); ++i) {
    const PlanFlexible& own = plan_.flexible[i];
    for (int k = 0; k < own.modes; ++k) v[modal_[i] + k] = state.auxiliary[at(own.auxiliary + own.modes + k)];
  }
  return v;
}

void Velocities::write(const Eigen::VectorXd& v, State& state) const {
  for (std::size_t b = 0; b < first_.size(); ++b) {
    if (first_[b] == kNone) continue;
    state.bodies[b].v = to_vec3(v.segment<3>(first_[b]));
    state.bodies[b].w = to_vec3(v.segment<3>(first_[b] + 3));
  }
  for (std::size_t i = 0; i < modal_.size(); ++i) {
    const PlanFlexible& own = plan_.flexible[i];
    for (int k = 0; k < own.modes; ++k) state.auxiliary[at(own.auxiliary + own.modes + k)] = v[modal_[i] + k];
  }
}

void Velocities::move(const Eigen::VectorXd& v, double time, State& state) const {
  for (std::size_t b = 0; b < first_.size(); ++b) {
    if (first_[b] == kNone) continue;
    BodyState& body = state.bodies[b];
    body.p += time * to_vec3(v.segment<3>(first_[b]));
    const Vec3 turn = time * to_vec3(v.segment<3>(first_[b] + 3));
    const double half = 0.5 * norm(turn);
    const double ratio = half < 1e-8 ? 0.5 : std::sin(half) / (2 * half);
    body.q = normalized(body.q * Quat{std::cos(half), ratio * turn.x, ratio * turn.y, ratio * turn.z});
  }
  for (std::size_t i = 0; i < modal_.size(); ++i) {
    const PlanFlexible& own = plan_.flexible[i];
    for (int k = 0; k < own.modes; ++k) state.auxiliary[at(own.auxiliary + k)] += time * v[modal_[i] + k];
  }
}

}  // namespace unlatch
