#include "tools/unlatch/options/scenario_notes.h"

#include <algorithm>
#include <cstdio>

#include "hil/run/run.h"

namespace unlatch::tools {
namespace {

// The earliest time at which a condition can hold, s.
double calc_earliest(const Condition& when) {
  using Kind = Condition::Kind;
  if (when.kind == Kind::kTime) return when.below ? 0 : when.threshold;
  if ((when.kind != Kind::kAll && when.kind != Kind::kAny) || when.parts.empty()) return 0;
  std::vector<double> times;
  for (const Condition& part : when.parts) times.push_back(calc_earliest(part));
  return when.kind == Kind::kAll ? *std::max_element(times.begin(), times.end())
                                 : *std::min_element(times.begin(), times.end());
}

}  // namespace

std::vector<std::string> list_notes(const hil::Scenario& scenario) {
  std::vector<std::string> notes;
  for (const Event& event : scenario.model.events) {
    const double earliest = calc_earliest(event.when) + event.delay;
    if (earliest <= scenario.until) continue;
    char text[160];
    std::snprintf(text, sizeof text, "cannot happen before %.6g s, and the run ends at %.6g s", earliest,
                  scenario.until);
    notes.push_back("event '" + event.name + "'" + (event.subject.empty() ? "" : " of '" + event.subject + "'") + " " +
                    text);
  }
  return notes;
}

void warn_of_unstable_elements(const hil::Scenario& scenario) {
  const auto simulation = hil::build_simulation(scenario);
  for (const hil::SpringResolution& element : hil::calc_resolutions(*simulation)) {
    if (element.implicit || scenario.dt * element.get_worst() <= kStable) continue;
    std::fprintf(stderr,
                 "warning: element '%s' is too stiff for this step and will be unstable: h*omega %.3g, h*decay %.3g; "
                 "see `unlatch check`\n",
                 scenario.model.element_name(element.element).c_str(), scenario.dt * element.largest_omega,
                 scenario.dt * element.largest_decay);
  }
}

void warn_of_absent_flight_software(const hil::Scenario& scenario) {
  const std::string absent = hil::tell_absence(scenario.flight_software, "a run at full speed");
  if (!absent.empty()) std::fprintf(stderr, "note: %s\n", absent.c_str());
}

}  // namespace unlatch::tools
