// Elements at the initial poses of a model, all bodies at rest: for reports before a run.
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/model/from_eigen.h"

namespace unlatch {

// Bodies' frames at the model's initial poses.
struct StartMotion {
  const Model& model;

  [[nodiscard]] BodyFrame get_frame(int body) const {
    if (body == kGround) return get_ground<double>();
    return {to_mat(get_attitude(model, body)), to_vec(place(model, body, Eigen::Vector3d::Zero())), {}, {}};
  }
};

// Effort of an element between two points or axes of bodies, switched on.
template <class Kind, class Item>
Effort calc_start_effort(const Model& model, const Item& item) {
  PlanDraft plan;
  plan.element_scales = {1};
  ElementCompiler compiler(model, plan);
  return Kind::calc(StartMotion{model}, Kind::compile(item, compiler), 0, 1);
}

}  // namespace unlatch
