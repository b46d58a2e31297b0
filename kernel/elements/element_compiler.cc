#include "kernel/elements/element_compiler.h"

#include <algorithm>

namespace unlatch {
namespace {

std::vector<double> list_numbers(const Profile& p) {
  std::vector<double> all{static_cast<double>(p.kind), p.value, p.initial, p.final, p.tau, static_cast<double>(p.law)};
  all.insert(all.end(), p.times.begin(), p.times.end());
  all.insert(all.end(), p.values.begin(), p.values.end());
  for (const Profile::Harmonic& h : p.harmonics) all.insert(all.end(), {h.amplitude, h.frequency, h.phase});
  return all;
}

void append_profile(const Profile& profile, PlanDraft& plan) {
  PlanProfile out{profile.kind, profile.value, profile.initial, profile.final, profile.tau, 0, 0};
  if (profile.kind == Profile::Kind::kTable) {
    out.first = static_cast<std::int32_t>(plan.knots.size());
    out.count = static_cast<std::int32_t>(profile.times.size());
    for (std::size_t i = 0; i < profile.times.size(); ++i) plan.knots.push_back({profile.times[i], profile.values[i]});
  } else if (profile.kind == Profile::Kind::kHarmonic) {
    out.first = static_cast<std::int32_t>(plan.harmonics.size());
    out.count = static_cast<std::int32_t>(profile.harmonics.size());
    plan.harmonics.insert(plan.harmonics.end(), profile.harmonics.begin(), profile.harmonics.end());
  }
  plan.profiles.push_back(out);
}

}  // namespace

ElementCompiler::ElementCompiler(const Model& own_model, PlanDraft& own_plan) : model(own_model), plan(own_plan) {}

std::int32_t ElementCompiler::find_coordinate(int joint, int axis) {
  const auto next = static_cast<std::int32_t>(plan.coordinates.size());
  const auto [found, is_new] = coordinates_.emplace(std::pair(joint, axis), next);
  if (is_new) {
    plan.coordinates.push_back({.joint = joint, .row = axis});
    if (axis >= kRotX) ++plan.rotation_count;
  }
  return found->second;
}

std::int32_t ElementCompiler::find_profile(const Profile& profile) {
  const auto [found, is_new] = profiles_.emplace(list_numbers(profile), static_cast<std::int32_t>(profiles_.size()));
  if (is_new) append_profile(profile, plan);
  return found->second;
}

std::int32_t ElementCompiler::find_compliant(std::size_t spring) const {
  const auto found = std::lower_bound(plan.compliant.begin(), plan.compliant.end(), spring,
                                      [](const PlanCompliant& c, std::size_t s) { return at(c.spring) < s; });
  const bool is_there = found != plan.compliant.end() && at(found->spring) == spring;
  return is_there ? static_cast<std::int32_t>(found - plan.compliant.begin()) : kNone;
}

}  // namespace unlatch
