#include "hil/study/evaluation/step_settings.h"

#include <algorithm>
#include <cmath>

#include "hil/study/evaluation/step_search.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch::hil {
namespace {

constexpr double kRounding = 1e-12;  // of a ratio of two steps

}  // namespace

std::vector<Setting> make_step_settings(const Scenario& scenario, double step) {
  const Model& model = scenario.model;
  std::vector<Setting> settings{make_step_setting(step)};
  const double ratio = std::ceil(scenario.dt / step * (1 - kRounding));
  if (model.contacts.empty() || !has_automatic_parts(model.contact_substeps) || !(ratio > 1)) return settings;
  const double refinement = get_contact_refinement(model.contact_substeps) * ratio;
  settings.push_back(make_setting("step.contact_refinement", std::min<double>(refinement, kMaxContactRefinement)));
  return settings;
}

}  // namespace unlatch::hil
