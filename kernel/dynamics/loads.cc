#include "kernel/dynamics/loads.h"

#include <algorithm>
#include <limits>

#include "unlatch/elementary.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();  // equal to no time

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double calc_table(std::span<const Knot> knots, double s) {
  if (s <= knots.front().time) return knots.front().value;
  if (s >= knots.back().time) return knots.back().value;
  std::size_t low = 0, high = knots.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (knots[middle].time <= s ? low : high) = middle;
  }
  const Knot &a = knots[low], &b = knots[high];
  return a.value + (b.value - a.value) * ((s - a.time) / (b.time - a.time));
}

// Loads with one law have often begun at one time.
double find_profile(const Plan& plan, int profile, double s, Workspace& ws) {
  KeptProfile& kept = ws.profiles[at(profile)];
  if (kept.s != s) kept = {s, calc_profile(plan, plan.profiles[at(profile)], s)};
  return kept.value;
}

// The wrench of a load that is fixed in its body, added to those before it or in their place.
template <bool kAdd>
UNLATCH_INLINE void apply(const PlanLoad& load, double size, double* lanes) {
  const Vec3 force = size * load.wrench.lin, torque = size * load.wrench.ang;
  double* to = lanes + load.applied;
  for (const double number : {force.x, force.y, force.z, torque.x, torque.y, torque.z}) {
    *to = kAdd ? *to + number : number;
    to += kOctet;
  }
}

// Bodies without loads in octets that have some.
void clear_wrenches(const Plan& plan, Workspace& ws) {
  for (const LaneOctet& octet : plan.octets)
    if (octet.loaded)
      std::fill_n(ws.lanes.data() + octet.body + kApplied * kOctet, (kLoadedEnd - kApplied) * kOctet, 0.0);
}

}  // namespace

double calc_profile(const Plan& plan, const PlanProfile& profile, double s) noexcept {
  switch (profile.kind) {
    case Profile::Kind::kConstant:
      return profile.value;
    case Profile::Kind::kExponential:
      return profile.final + (profile.initial - profile.final) * elementary::exp(-s / profile.tau);
    case Profile::Kind::kTable:
      return calc_table(std::span(plan.knots).subspan(at(profile.first), at(profile.count)), s);
    case Profile::Kind::kHarmonic: {
      double sum = 0;
      for (const Profile::Harmonic& h : std::span(plan.harmonics).subspan(at(profile.first), at(profile.count)))
        sum += h.amplitude * elementary::sin(h.frequency * s + h.phase);
      return sum;
    }
  }
  return 0;
}

void update_loads(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  if (plan.loads.empty() || ws.loads_time == t) return;
  ws.loads_time = t;
  const ElementState* elements = state.elements.data();
  double *sizes = ws.load_sizes.data(), *lanes = ws.lanes.data();
  for (const PlanLoad& load : plan.loads) {
    const ElementState& element = elements[load.element];
    const double scale = calc_scale(element, t);
    double size = 0;
    if (scale != 0) {
      size = find_profile(plan, load.profile, t - element.switched_on, ws) * scale;
      if (load.channel != kNone) size *= inputs.commands[at(load.channel)];
    }
    *sizes++ = size;
    if (load.first)
      apply<false>(load, size, lanes);
    else if (!load.world && size != 0)
      apply<true>(load, size, lanes);
  }
}

void forget_sizes(Workspace& ws) noexcept { ws.loads_time = kNever; }

void forget_loads(const Plan& plan, Workspace& ws) noexcept {
  forget_sizes(ws);
  clear_wrenches(plan, ws);
  for (KeptProfile& kept : ws.profiles) kept.s = kNever;
}

}  // namespace unlatch
