// ElementCompiler: the plan as kinds of elements see it while they are compiled, with coordinates of joints, profiles.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

class ElementCompiler {
 public:
  ElementCompiler(const Model& own_model, PlanDraft& own_plan);

  const Model& model;  // valid, with its markers placed
  PlanDraft& plan;     // bodies with their auxiliary states, joints, modes, surfaces, implicit springs are compiled

  // Number of the element that is being compiled, in the one numbering of all elements.
  [[nodiscard]] std::int32_t get_element() const { return static_cast<std::int32_t>(plan.element_scales.size()) - 1; }
  // Place in PlanData::coordinates of a joint's axis; only coordinates for which this was called are computed.
  std::int32_t find_coordinate(int joint, int axis);
  // Place in PlanData::profiles. Loads with one law share its profile: four boosters have one thrust curve.
  std::int32_t find_profile(const Profile& profile);
  // Place of a joint spring in PlanData::compliant; kNone if it is integrated explicitly.
  [[nodiscard]] std::int32_t find_compliant(std::size_t spring) const;

 private:
  std::map<std::pair<int, int>, std::int32_t> coordinates_;
  std::map<std::vector<double>, std::int32_t> profiles_;
};

}  // namespace unlatch
