// The systems of tests/data as models, built from their JSON parameters.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "unlatch/model.h"

namespace unlatch::test {

nlohmann::json load_reference(const std::string& name);  // tests/data/<name>.json

Model build_soyuz(const nlohmann::json& reference);  // bodies core, booster1 … 4; joints nose1 … 4; events release,
                                                     // contact, nozzle, liftoff
Model build_solar(
    const nlohmann::json& reference);  // bodies bus, panel1, panel2; joints hinge1, hinge2; events latch1, latch2
Model build_tree3(const nlohmann::json& reference);
Model build_tree20(const nlohmann::json& reference);

// Sets one body's 13 numbers in the order of the references: R, q (w, x, y, z), V, w.
void set_state(Body& body, const nlohmann::json& state);
Eigen::Vector3d to_vector(const nlohmann::json& a);
Eigen::Matrix3d to_matrix(const nlohmann::json& rows);

}  // namespace unlatch::test
