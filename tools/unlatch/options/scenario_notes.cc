#include "tools/unlatch/options/scenario_notes.h"

#include <cstdio>

#include "hil/run/run.h"
#include "hil/scenario/earliest.h"

namespace unlatch::tools {
std::vector<std::string> list_notes(const hil::Scenario& scenario) {
  std::vector<std::string> notes;
  const hil::EarliestTimes earliest(scenario.model);
  for (std::size_t e = 0; e < scenario.model.events.size(); ++e) {
    const Event& event = scenario.model.events[e];
    if (const std::string why = earliest.explain(e, scenario.until); !why.empty())
      notes.push_back("event '" + event.name + "'" + (event.subject.empty() ? "" : " of '" + event.subject + "'") +
                      " " + why);
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
  const std::string absent = hil::describe_absence(scenario.flight_software, "a run at full speed");
  if (!absent.empty()) std::fprintf(stderr, "note: %s\n", absent.c_str());
}

}  // namespace unlatch::tools
