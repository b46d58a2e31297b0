// Inside of validate(): the parts that look at joints and at events, and what they share.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "kernel/math/number_text.h"
#include "unlatch/model.h"

namespace unlatch {

using ModelErrors = std::vector<ModelError>;

void validate_joints(const Model& model, ModelErrors& errors);
// Pushers, stops, cords, friction in joints, and impulses.
void validate_one_sided(const Model& model, ModelErrors& errors);
void validate_events(const Model& model, ModelErrors& errors);
void validate_contacts(const Model& model, ModelErrors& errors);
void validate_quantities(const Model& model, ModelErrors& errors);
// A quantity that the model, a condition or a sensor names. `single`: of one value.
void check_quantity(const Model& model, const Quantity& quantity, bool single, const std::string& where,
                    const std::string& key, ModelErrors& errors);
// Shape sets a and b exist, are of two bodies, and have a distance.
void check_shape_pair(const Model& model, const std::string& where, int a, int b, const std::string& key,
                      ModelErrors& errors);

inline bool is_index(int index, std::size_t size) { return index >= 0 && static_cast<std::size_t>(index) < size; }

inline std::string quoted(const std::string& kind, const std::string& name) { return kind + " '" + name + "'"; }

inline std::string show(const Eigen::Vector3d& v) {
  return "[" + show(v.x()) + ", " + show(v.y()) + ", " + show(v.z()) + "]";
}

}  // namespace unlatch
