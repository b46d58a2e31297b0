// Parts of validate(): joints, surfaces, quantities, events. Elements are checked by their kinds
// (kernel/elements/kinds).
#pragma once

#include <string>

#include "kernel/model/check.h"

namespace unlatch {

void validate_joints(const Model& model, ModelErrors& errors);
void validate_surfaces(const Model& model, ModelErrors& errors);
void validate_events(const Model& model, ModelErrors& errors);
void validate_quantities(const Model& model, ModelErrors& errors);
// A quantity that the model, a condition or a sensor names. `single`: of one value.
void check_quantity(const Model& model, const Quantity& quantity, bool single, const std::string& where,
                    const std::string& key, ModelErrors& errors);
// Shape sets a and b exist, are of two bodies, and have a distance.
void check_shape_pair(const Model& model, const std::string& where, int a, int b, const std::string& key,
                      ModelErrors& errors);

}  // namespace unlatch
