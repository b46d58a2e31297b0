#include "kernel/elements/kinds/load.h"

#include "kernel/math/table.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

double calc_table(std::span<const Knot> knots, double s) {
  if (s <= knots.front().time) return knots.front().value;
  if (s >= knots.back().time) return knots.back().value;
  const std::size_t low = find_piece(knots.size(), s, [&](std::size_t i) { return knots[i].time; });
  const Knot &a = knots[low], &b = knots[low + 1];
  return a.value + (b.value - a.value) * ((s - a.time) / (b.time - a.time));
}

// Loads with one law have often begun at one time, and stages share instants.
double find_profile(const PlanData& plan, int profile, double s, Evaluation& ev) {
  KeptProfile& kept = ev.profiles[at(profile)];
  if (kept.s != s) kept = {s, calc_profile(plan, plan.profiles[at(profile)], s)};
  return kept.value;
}

// At time t, of the element that it is. `calc_law(profile, s)`: of the profile at the time s since it was switched on.
template <class Law>
UNLATCH_INLINE double calc_size(const PlanLoad& load, const ElementState& element, const Inputs& inputs, double t,
                                const Law& calc_law) {
  const double scale = calc_scale(element, t);
  double size = 0;
  if (scale != 0) {
    size = calc_law(load.profile, t - element.switched_on) * scale;
    if (load.channel != kNone) size *= inputs.commands[at(load.channel)];
  }
  return size;
}

}  // namespace

double calc_profile(const PlanData& plan, const PlanProfile& profile, double s) noexcept {
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
    case Profile::Kind::kLaw:  // see update_law_loads()
      break;
  }
  return 1;
}

double calc_load_size(const Plan& owner, const Inputs& inputs, const State& state, const Workspace& workspace,
                      int load) noexcept {
  const PlanData& plan = get_data(owner);
  const PlanLoad& own = plan.loads[at(load)];
  if (own.law != kNone) return get_data(workspace).kept.evaluation.load_sizes[at(load)];
  return calc_size(own, state.elements[at(own.element)], inputs, plan.get_time(state.header->tick),
                   [&](int profile, double s) { return calc_profile(plan, plan.profiles[at(profile)], s); });
}

void update_loads(const Instant& now, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  if (plan.loads.empty()) return;
  double *blocks = ev.blocks.data(), *sizes = ev.load_sizes.data();
  const ElementState* elements = now.state.elements.data();
  for (const BodyEight& eight : plan.eights)
    if (eight.loaded) eight.get_applied(blocks, 0) = {};
  for (const PlanLoad& load : plan.loads) {
    const double size = calc_size(load, elements[load.element], now.inputs, now.t,
                                  [&](int profile, double s) { return find_profile(plan, profile, s, ev); });
    *sizes++ = size;
    if (!load.apart && size != 0)
      add(blocks, ev.places[at(load.body)], &AppliedBlock<double>::wrench, size * load.wrench);
  }
}

void update_law_loads(const Instant& now, std::span<const double> laws, std::span<double> load_sizes) noexcept {
  for (const std::int32_t i : now.plan.laws.loads) {
    const PlanLoad& load = now.plan.loads[at(i)];
    load_sizes[at(i)] = calc_size(load, now.state.elements[at(load.element)], now.inputs, now.t,
                                  [&](int, double) { return laws[at(load.law)]; });
  }
}

void LoadKind::add_energy(const StageMotion& motion, const PlanLoad& load, std::size_t i, EnergySum& sum) {
  const double size = motion.ev.load_sizes[i];
  if (size == 0) return;
  const BodyFrame body = motion.get_frame(load.body);
  const Vec3 force = size * (load.world ? load.wrench.lin : body.R * load.wrench.lin);
  const Vec3 torque = size * (load.world ? load.wrench.ang : body.R * load.wrench.ang);
  const Vec3 v = load.world ? body.v + cross(body.w, body.R * load.point) : body.v;
  sum.push(PowerSource::kLoads, force, v);
  sum.add(PowerSource::kLoads, dot(torque, body.w));
}

}  // namespace unlatch
