#include "hil/run/findings/spring_start.h"

namespace unlatch::hil {

std::vector<SpringStart> list_springs(const Scenario& scenario) {
  const Model model = place_markers(scenario.model);
  std::vector<SpringStart> springs;
  for (int element = 0; element < model.element_count(); ++element) {
    const ElementStart start = calc_element_start(model, element);
    if (start.kind == nullptr) continue;
    const ElementTraits traits = describe_element(model, element);
    springs.push_back({model.element_name(element), traits.on, traits.angular, start});
  }
  return springs;
}

}  // namespace unlatch::hil
