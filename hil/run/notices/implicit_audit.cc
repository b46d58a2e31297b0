#include "hil/run/notices/implicit_audit.h"

#include <algorithm>
#include <cmath>

#include "hil/run/audit/step_audit.h"
#include "hil/run/notices/resolution.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

constexpr double kSteadyPart = 1e-3;       // of a force: a smaller change of it is none
constexpr double kLeastDeflection = 1e-9;  // m or rad, likewise, and that of rounding
constexpr double kLeastSpeed = 1e-6;       // m/s or rad/s
constexpr double kRoundings = 64;

// Error of the swing after an abrupt change of force, as a part of it: the overshoot of the true spring, or that of the
// method, −R(z) of ROS2 for a decay (kernel/THEORY.md, 5), whose largest value is at z = −8.2.
double calc_overshoot(double damping_ratio) {
  constexpr double kPi = 3.14159265358979323846, kOfMethod = 0.21;
  if (!(damping_ratio < 1)) return kOfMethod;
  return std::max(kOfMethod, std::exp(-kPi * damping_ratio / std::sqrt(1 - damping_ratio * damping_ratio)));
}

constexpr double kGamma = 0.29289321881345254;  // 1 − 1/√2

// What ROS2 leaves of an error in one step: |R(i·size)| of an oscillation, |R(−size)| of a decay (kernel/THEORY.md, 5).
double calc_memory_of_swing(double size) {
  const double turned = (1 - 2 * kGamma) * size, damped = kGamma * size;
  return std::sqrt(1 + turned * turned) / (1 + damped * damped);
}
double calc_memory_of_decay(double size) {
  const double damped = 1 + kGamma * size;
  return std::abs(1 - (1 - 2 * kGamma) * size) / (damped * damped);
}

// The same for a spring; `omega`, `decay`: times the step. An overdamped one has a slow and a fast rate.
double calc_memory(double omega, double decay) {
  if (decay < 2 * omega) return calc_memory_of_swing(omega);
  const double root = std::sqrt(decay * decay - 4 * omega * omega);
  const double slow = 2 * omega * omega / (decay + root), fast = 0.5 * (decay + root);
  return std::max(calc_memory_of_decay(slow), calc_memory_of_decay(fast));
}

}  // namespace

ImplicitAudit::ImplicitAudit(const Simulation& simulation) : simulation_(simulation) {
  const double dt = simulation.plan().get_options().dt;
  const std::vector<Body>& bodies = simulation.model().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b].flexible || bodies[b].flexible->frequencies.size() == 0) continue;
    const FlexibleBody& flexible = *bodies[b].flexible;
    const double size = dt * flexible.frequencies.maxCoeff();
    if (!(size > kResolved)) continue;
    Modes modes{.body = static_cast<int>(b), .size = size};
    for (int i = 0; i < flexible.frequencies.size(); ++i) {
      const double omega = flexible.frequencies[i];
      modes.squares.push_back(omega * omega);
      modes.overshoots.push_back(dt * omega > kAccurate ? calc_overshoot(flexible.damping[i]) : 0);
      modes.memories.push_back(calc_memory(dt * omega, 2 * flexible.damping[i] * dt * omega));
    }
    modes.courses.resize(modes.squares.size());
    modes.own_forces.resize(modes.squares.size());
    modes.own_speeds.resize(modes.squares.size());
    modes_.push_back(std::move(modes));
  }
}

void ImplicitAudit::set_rates(std::span<const ElementFrequency> frequencies) {
  const Model& model = simulation_.model();
  const int first = static_cast<int>(model.loads.size() + model.point_springs.size());
  const double dt = simulation_.plan().get_options().dt;
  for (const ElementFrequency& own : frequencies) {
    if (!own.implicit) continue;
    auto spring = std::ranges::find(springs_, own.element, &Spring::element);
    if (spring == springs_.end()) {
      Spring added;
      added.element = own.element;
      added.stiffness = model.joint_springs[at(own.element - first)].stiffness;
      spring = springs_.insert(springs_.end(), added);
    }
    spring->omega = own.omega;
    spring->decay = own.decay;
    if (simulation_.state().elements[at(own.element)].to != 0)
      spring->size = std::max(spring->size, dt * std::max(own.omega, own.decay));
  }
}

void ImplicitAudit::update() {
  for (Spring& spring : springs_) update(spring);
  for (Modes& modes : modes_) update(modes);
  begun_ = true;
}

double ImplicitAudit::calc_least_force(const Spring& spring) const {
  double farthest = 0;
  const ElementTraits traits = describe_element(simulation_.model(), spring.element);
  for (const int body : {traits.base, traits.follower})
    if (body != kGround) farthest = std::max(farthest, norm(simulation_.state().bodies[at(body)].p));
  const double rounding = kRoundings * std::numeric_limits<double>::epsilon() * farthest;
  return std::max(kSteadyPart * spring.greatest, spring.stiffness * std::max(kLeastDeflection, rounding));
}

void ImplicitAudit::update(Spring& spring) {
  const ElementReading now = calc_element(simulation_.plan(), simulation_.workspace(), spring.element);
  if (!begun_) {
    spring.start = now.force;
    spring.start_rate = now.rate;
  }
  spring.greatest = std::max(spring.greatest, std::abs(now.force));
  spring.forces.change = std::max({spring.forces.change, std::abs(now.force - spring.start), calc_least_force(spring)});
  spring.speeds.change = std::max({spring.speeds.change, std::abs(now.rate - spring.start_rate), kLeastSpeed});
  const double dt = simulation_.plan().get_options().dt;
  // Off, or held by its joint, it has no motion of its own.
  if (!begun_ || now.scale == 0 || dt * std::max(spring.omega, spring.decay) <= kAccurate) {
    spring.force.restart(now.force);
  } else {
    const double difference = 0.5 * std::abs(spring.force.move(now.force));
    spring.jump = std::max(spring.jump, difference * calc_overshoot(0.5 * spring.decay / spring.omega));
  }
  judge(spring.forces, std::max(spring.forces.error, spring.jump), 1);
}

void ImplicitAudit::update(Modes& modes) {
  const std::span<const double> eta = get_modal_coordinates(simulation_.plan(), simulation_.state(), modes.body);
  const std::span<const double> rates = get_modal_rates(simulation_.plan(), simulation_.state(), modes.body);
  if (!begun_) {
    modes.starts.assign(eta.begin(), eta.end());
    modes.start_rates.assign(rates.begin(), rates.end());
  }
  double force = 0, change = 0, jump = 0, speed = 0;
  for (std::size_t i = 0; i < modes.squares.size(); ++i) {
    const double own = modes.squares[i] * eta[i], moved = modes.squares[i] * (eta[i] - modes.starts[i]);
    force += own * own;
    change += moved * moved;
    speed += (rates[i] - modes.start_rates[i]) * (rates[i] - modes.start_rates[i]);
    if (!begun_) modes.courses[i].restart(own);
    const double difference = 0.5 * modes.overshoots[i] * modes.courses[i].move(own);
    jump += difference * difference;
  }
  modes.greatest = std::max(modes.greatest, std::sqrt(force));
  modes.forces.change = std::max({modes.forces.change, std::sqrt(change), kSteadyPart * modes.greatest});
  modes.speeds.change = std::max({modes.speeds.change, std::sqrt(speed), kLeastSpeed});
  modes.jump = std::max(modes.jump, std::sqrt(jump));
  judge(modes.forces, std::max(modes.forces.error, modes.jump), 1);
}

void ImplicitAudit::compare(const Plan& halved, const State& state, const Workspace& workspace, double between) {
  for (Spring& spring : springs_) {
    const ElementReading full = calc_element(simulation_.plan(), simulation_.workspace(), spring.element);
    const ElementReading half = calc_element(halved, workspace, spring.element);
    const double force = std::abs(full.force - half.force), rate = std::abs(full.rate - half.rate);
    const double dt = simulation_.plan().get_options().dt;
    if (spring.omega == 0 && spring.decay == 0) {  // held by its joint, it has no swing any more
      spring.forces.error = spring.speeds.error = 0;
    } else {
      const double memory = calc_memory(dt * spring.omega, dt * spring.decay);
      spring.forces.add(force, memory, between);
      spring.speeds.add(rate, memory, between);
    }
    judge(spring.forces, std::max(spring.forces.error, spring.jump), between + 1);
    judge(spring.speeds, spring.speeds.error, between + 1);
  }
  for (Modes& modes : modes_) {
    const auto subtract = [&](const auto& get, std::vector<double>& to) {
      const std::span<const double> full = get(simulation_.plan(), simulation_.state(), modes.body);
      const std::span<const double> half = get(halved, state, modes.body);
      to.resize(full.size());
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = full[i] - half[i];
    };
    subtract(get_modal_coordinates, modes.differences);
    for (std::size_t i = 0; i < modes.squares.size(); ++i) modes.differences[i] *= modes.squares[i];
    modes.forces.error = add(modes.own_forces, modes, between);
    subtract(get_modal_rates, modes.differences);
    modes.speeds.error = add(modes.own_speeds, modes, between);
    judge(modes.forces, std::max(modes.forces.error, modes.jump), between + 1);
    judge(modes.speeds, modes.speeds.error, between + 1);
  }
}

// Adds the differences of all modes to their errors, each as it forgets them; returns the size of all.
double ImplicitAudit::add(std::vector<Sum>& own, const Modes& modes, double between) {
  double all = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    own[i].add(std::abs(modes.differences[i]), modes.memories[i], between);
    all += own[i].error * own[i].error;
  }
  return std::sqrt(all);
}

// `ticks`: within which the error came up.
void ImplicitAudit::judge(Sum& sum, double error, double ticks) const {
  const double time = simulation_.get_time();
  const bool was_beyond = sum.time != kNever, is_beyond = error > StepAudit::kLimit * sum.change;
  if (is_beyond && !was_beyond) {
    sum.time = time;
    sum.from = time - ticks * simulation_.plan().get_options().dt;
  } else if (!is_beyond && was_beyond) {
    sum.passed_from = std::min(sum.passed_from, sum.from);
    sum.passed_until = time;
    sum.time = sum.from = kNever;
  }
}

void ImplicitAudit::list(const Sum& sum, double error, ImplicitError own, bool passed,
                         std::vector<ImplicitError>& list) {
  own.error = error;
  own.change = sum.change;
  own.time = passed ? sum.passed_until : sum.time;
  own.from = passed ? sum.passed_from : sum.from;
  own.until = passed ? sum.passed_until : kNever;
  if (own.time != kNever && (!passed || sum.passed_from != kNever)) list.push_back(own);
}

std::vector<ImplicitError> ImplicitAudit::list(bool passed) const {
  // The error of the force lasts as long as that of the speed, which then says no more.
  const auto covers = [](const ImplicitError& force, const Sum& speed, bool is_passed) {
    return is_passed ? force.from <= speed.passed_from && force.until >= speed.passed_until : force.from <= speed.from;
  };
  std::vector<ImplicitError> all;
  for (const Spring& spring : springs_) {
    const ImplicitError own{.element = spring.element, .size = spring.size};
    list(spring.forces, std::max(spring.forces.error, spring.jump), own, passed, all);
    ImplicitError speed = own;
    speed.of_speed = true;
    if (all.empty() || all.back().element != spring.element || !covers(all.back(), spring.speeds, passed))
      list(spring.speeds, spring.speeds.error, speed, passed, all);
  }
  for (const Modes& modes : modes_) {
    const ImplicitError own{.body = modes.body, .size = modes.size};
    list(modes.forces, std::max(modes.forces.error, modes.jump), own, passed, all);
    ImplicitError speed = own;
    speed.of_speed = true;
    if (all.empty() || all.back().body != modes.body || !covers(all.back(), modes.speeds, passed))
      list(modes.speeds, modes.speeds.error, speed, passed, all);
  }
  return all;
}

std::vector<ImplicitError> ImplicitAudit::list_unresolved() const { return list(false); }
std::vector<ImplicitError> ImplicitAudit::list_passed() const { return list(true); }

}  // namespace unlatch::hil
