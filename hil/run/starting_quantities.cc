#include "hil/run/starting_quantities.h"

#include "hil/run/run.h"
#include "hil/scenario/quantities.h"

namespace unlatch::hil {

std::vector<StartingQuantity> list_starting_quantities(const Scenario& scenario) {
  // The quantities are added to a copy: reading a coordinate belongs to a model.
  Scenario copy = scenario;
  Model& model = copy.model;
  for (unlatch::Quantity& quantity : list_possible_quantities(scenario.model)) {
    quantity.name = "possible#" + std::to_string(model.quantities.size());
    model.quantities.push_back(quantity);
  }
  const auto simulation = build_simulation(copy);
  std::vector<StartingQuantity> list;
  for (std::size_t i = 0; i < model.quantities.size(); ++i) {
    const unlatch::Quantity& quantity = model.quantities[i];
    const bool named = i < scenario.named_quantities;
    if (!named && i < scenario.model.quantities.size()) continue;  // of conditions: the possible ones list its kind
    list.push_back({named ? quantity.name : "", get_unit(model, quantity), write_quantity(model, quantity),
                    simulation->workspace().quantities[i]});
  }
  return list;
}

}  // namespace unlatch::hil
