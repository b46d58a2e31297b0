// Properties of every step, for any model: bounded work and a status; a new state that is finite, or the old one
// unchanged.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test {

// Traps: invalid operations, divisions by zero and overflows end the process. Inexact results and underflows are
// normal.
class Traps {
 public:
  explicit Traps(int trapped = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW) {
    std::feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(trapped);
  }
  ~Traps() {
    fedisableexcept(FE_ALL_EXCEPT);
    std::feclearexcept(FE_ALL_EXCEPT);
  }
  Traps(const Traps&) = delete;
  Traps& operator=(const Traps&) = delete;
};

inline bool is_finite(std::initializer_list<double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

// Returns true if every number of the state is finite.
inline bool is_finite(const State& state) {
  bool finite = true;
  for (const BodyState& b : state.bodies)
    finite = finite &&
             is_finite({b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z, b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z});
  for (const JointState& j : state.joints)
    finite = finite && is_finite({j.angle[0], j.angle[1], j.angle[2], j.offset.x, j.offset.y, j.offset.z, j.locked.w,
                                  j.locked.x, j.locked.y, j.locked.z});
  for (const ElementState& e : state.elements)
    finite = finite && is_finite({e.switched_on, e.from, e.to, e.start, e.duration});
  for (const EventState& e : state.events) finite = finite && std::isfinite(e.due);
  for (const double signal : state.signals) finite = finite && std::isfinite(signal);
  for (const double extra : state.auxiliary) finite = finite && std::isfinite(extra);
  return finite;
}

struct Survival {
  StepStatus status = StepStatus::kOk;  // status of the last step
  int steps = 0;                        // number of good steps
  int fired = 0;                        // number of events
};

// Steps until `ticks` are done or a step fails, and checks every one.
inline Survival survive(Simulation& s, int ticks) {
  // A split takes a trial and two iterations; the part after the last split takes one more.
  const int most_substeps = 3 * s.plan.get_options().max_splits + 1;
  Survival survival;
  for (; survival.steps < ticks; ++survival.steps) {
    const std::uint64_t before = calc_hash(s.state);
    const std::int64_t tick = s.state.header->tick;
    const StepReport report = s.advance();
    EXPECT_LE(report.substeps, most_substeps) << "tick " << tick;
    survival.status = report.status;
    survival.fired += static_cast<int>(report.events.size());
    if (report.status != StepStatus::kOk) {
      EXPECT_EQ(calc_hash(s.state), before) << "a failed step has changed the state, tick " << tick;
      return survival;
    }
    EXPECT_EQ(s.state.header->tick, tick + 1);
    const auto& sensors = s.workspace.sensors;
    if (!is_finite(s.state) ||
        !std::all_of(sensors.begin(), sensors.end(), [](double x) { return std::isfinite(x); })) {
      ADD_FAILURE() << "a number that is not finite after a good step, in the state or a sensor, tick " << tick;
      return survival;
    }
  }
  return survival;
}

inline Survival survive(const Model& model, int ticks, const PlanOptions& options = {}) {
  Simulation s(model, options);
  return survive(s, ticks);
}

inline PointSpring build_spring(int base, int follower, double stiffness, double damping, double free_length) {
  PointSpring spring;
  spring.name = "spring" + std::to_string(follower);
  spring.base = base;
  spring.follower = follower;
  spring.stiffness = stiffness;
  spring.damping = damping;
  spring.free_length = free_length;
  return spring;
}

inline Joint build_joint(int base, int follower, const Eigen::Vector3d& point_base,
                         const Eigen::Vector3d& point_follower, const std::vector<JointMode>& modes) {
  Joint joint;
  joint.name = "joint" + std::to_string(follower);
  joint.base = base;
  joint.follower = follower;
  joint.point_base = point_base;
  joint.point_follower = point_follower;
  joint.modes = modes;
  return joint;
}

}  // namespace unlatch::test
