#include "hil/run/notices/friction_resolution.h"

#include <algorithm>
#include <cmath>

#include "hil/run/notices/format.h"
#include "hil/run/notices/resolution.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// Force or torque of friction per speed, N s/m or N m s/rad.
double calc_resistance(const Simulation& simulation, std::size_t number, const OneSided& force) {
  if (simulation.state().engaged[number] == 0) return 0;
  const OneSidedReading reading = calc_one_sided(simulation.plan(), simulation.workspace(), static_cast<int>(number));
  if (!(reading.force > 0)) return 0;
  return reading.scale * force.friction / std::hypot(reading.depth_rate, force.friction_speed);
}

double calc_resistance(const Simulation& simulation, int element, const JointFriction& friction) {
  const Model& model = simulation.model();
  const Joint& joint = model.joints[at(friction.joint)];
  const RowSet rows = joint.modes[static_cast<std::size_t>(simulation.state().joints[at(friction.joint)].mode)].rows;
  if ((rows & kPointRows) == 0 || has_row(rows, friction.axis)) return 0;
  double square = 0;
  for (std::size_t row = kX; row <= kZ; ++row) {
    const double lambda = simulation.workspace().multipliers.get(at(friction.joint), row);
    square += lambda * lambda;
  }
  const ElementReading reading = calc_element(simulation.plan(), simulation.workspace(), element);
  const double arm = friction.axis >= kRotX ? friction.radius : 1;
  return reading.scale * friction.coefficient * arm * arm * std::sqrt(square) /
         std::hypot(arm * reading.rate, friction.speed);
}

}  // namespace

bool has_friction(const Model& model) {
  return !model.frictions.empty() || std::any_of(model.one_sided.begin(), model.one_sided.end(),
                                                 [](const OneSided& force) { return force.friction > 0; });
}

std::vector<FrictionRate> calc_friction_rates(const Simulation& simulation,
                                              std::span<const ElementMobility> mobilities) {
  const Model& model = simulation.model();
  const auto first = static_cast<std::size_t>(get_first_one_sided(model));
  std::vector<FrictionRate> rates;
  for (const ElementMobility& mobility : mobilities) {
    const std::size_t number = at(mobility.element) - first;
    if (number >= model.one_sided.size()) {
      const JointFriction& friction = model.frictions[number - model.one_sided.size()];
      rates.push_back({mobility.element, calc_resistance(simulation, mobility.element, friction) * mobility.value});
    } else if (model.one_sided[number].friction > 0) {
      rates.push_back(
          {mobility.element, calc_resistance(simulation, number, model.one_sided[number]) * mobility.value});
    }
  }
  return rates;
}

std::string describe_unresolved(const FrictionRate& rate, double h) {
  const double size = h * rate.decay;
  if (!(size > kAccurate)) return "";
  return format(
      "h times the rate at which friction stops the motion %.3g: %s; a step of %.3g s would do, or a speed of "
      "regularisation %.2g times as high",
      size, size > kStable ? "beyond what is stable" : "not resolved accurately", kAccurate / rate.decay * kRoundedDown,
      size / kAccurate / kRoundedDown);
}

}  // namespace unlatch::hil
