#include <cmath>

#include "kernel/elements/kinds/load.h"
#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

void check_table(const Check& check, const Profile& profile) {
  const auto report = [&](const std::string& what, const std::string& mend) { check.report(what, mend, "profile"); };
  const std::vector<double>& t = profile.times;
  if (t.empty() || t.size() != profile.values.size())
    return report("its table has times (" + std::to_string(t.size()) + ") and values (" +
                      std::to_string(profile.values.size()) + ")",
                  "as many of each, at least one");
  for (const std::vector<double>* list : {&profile.times, &profile.values})
    for (const double value : *list)
      if (!std::isfinite(value)) return report("its table has a value that is not finite", "finite times and values");
  for (std::size_t i = 1; i < t.size(); ++i)
    if (!(t[i] > t[i - 1]))
      return report("its table's times do not increase: " + show(t[i - 1]) + ", " + show(t[i]),
                    "each time is later than the one before");
}

void check_profile(const Check& check, const Profile& profile) {
  const auto report = [&](const std::string& what, const std::string& mend) { check.report(what, mend, "profile"); };
  switch (profile.kind) {
    case Profile::Kind::kConstant:
      check.check_finite("profile", std::isfinite(profile.value));
      break;
    case Profile::Kind::kExponential:
      check.check_finite("profile", std::isfinite(profile.initial) && std::isfinite(profile.final));
      if (!(profile.tau > 0) || !std::isfinite(profile.tau))
        report("its time constant tau is " + show(profile.tau) + " s", "greater than 0, and finite");
      break;
    case Profile::Kind::kTable:
      check_table(check, profile);
      break;
    case Profile::Kind::kHarmonic:
      for (const Profile::Harmonic& h : profile.harmonics)
        if (!std::isfinite(h.amplitude) || !std::isfinite(h.frequency) || !std::isfinite(h.phase)) {
          report("a harmonic is not finite", "finite amplitude, frequency and phase");
          break;
        }
      break;
    case Profile::Kind::kLaw:
      if (!is_index(profile.law, check.model.laws.size()))
        report("the law of its profile does not exist", "the index of one law");
      break;
  }
}

}  // namespace

void LoadKind::validate(const Load& load, const Check& check) {
  const std::vector<Body>& bodies = check.model.bodies;
  check.check_body(load.body, "body");
  check.check_channel(load.channel);
  check.check_not_negative("consumption", load.consumption);
  const int tank = load.tank == kNone ? load.body : load.tank;
  if (load.consumption > 0 && (!is_index(tank, bodies.size()) || !bodies[static_cast<std::size_t>(tank)].law))
    check.report("it consumes propellant of a body that has no mass law", "give that body a `law`, or name the tank",
                 "consumption");
  if (load.consumption > 0 && load.kind == Load::Kind::kTorque)
    check.report("a torque consumes nothing", "only a force does", "consumption");
  check.check_finite("point", load.point.allFinite());
  check.check_finite("direction", load.direction.allFinite());
  check_profile(check, load.profile);
}

PlanLoad LoadKind::compile(const Load& l, ElementCompiler& compiler) {
  PlanDraft& plan = compiler.plan;
  const bool world = l.frame == Load::Frame::kWorld, torque = l.kind == Load::Kind::kTorque;
  const Vec3 none{0, 0, 0}, point = torque ? none : to_vec(l.point), size = to_vec(l.direction);
  const bool by_law = l.profile.kind == Profile::Kind::kLaw, apart = world || by_law;
  if (by_law) plan.laws.loads.push_back(static_cast<std::int32_t>(plan.loads.size()));
  if (apart || l.consumption != 0) plan.external_loads.push_back(static_cast<std::int32_t>(plan.loads.size()));
  if (l.channel != kNone) plan.commanded_loads = true;
  return {l.body,
          compiler.get_element(),
          compiler.find_profile(l.profile),
          l.channel,
          world,
          apart,
          point,
          torque ? Spatial{none, size} : Spatial{size, world ? none : cross(point, size)},
          l.direction.norm(),
          l.consumption,
          plan.bodies[at(l.tank == kNone ? l.body : l.tank)].varying,
          l.profile.law};
}

}  // namespace unlatch
