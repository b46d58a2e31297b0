// Rows of joints in words; reactions that are not unique, in words and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "unlatch/model.h"
#include "unlatch/redundancy.h"

namespace unlatch::tools {

// "x y rot_z"; `none` if there are none.
std::string list_rows(RowSet rows, const char* none);

// "5 of 8 rows of bolt1, bolt2, bolt3 are redundant: the split of their reactions is not unique …"; of many joints the
// first are named.
std::string describe(const Model& model, const RedundantRows& rows);

// joints, rows, redundant, nearly_redundant.
nlohmann::ordered_json build_json(const Model& model, const RedundantRows& rows);

}  // namespace unlatch::tools
