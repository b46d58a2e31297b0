#include "tools/unlatch/results/redundancy.h"

#include <nlohmann/json.hpp>

#include "tools/common/text.h"

namespace unlatch::tools {

std::string list_rows(RowSet rows, const char* none) {
  std::string text;
  for (int row = 0; row < kRows; ++row) {
    if (has_row(rows, row)) text += (text.empty() ? "" : " ") + std::string(kRowNames[row]);
  }
  return text.empty() ? none : text;
}

std::string describe(const Model& model, const RedundantRows& rows) {
  constexpr std::size_t kNamed = 8;
  const std::size_t named = rows.joints.size() <= kNamed ? rows.joints.size() : kNamed - 1;
  std::string text = std::to_string(rows.redundant) + " of " + count(rows.rows, "row") + " of ";
  for (std::size_t i = 0; i < named; ++i)
    text += (i > 0 ? ", " : "") + model.joints[static_cast<std::size_t>(rows.joints[i])].name;
  if (named < rows.joints.size()) text += " and " + std::to_string(rows.joints.size() - named) + " more";
  text +=
      (rows.redundant == 1 ? " is" : " are") +
      std::string(" redundant: the split of their reactions is not unique (by equal stiffnesses, or as `share` says)");
  if (rows.nearly > 0)
    text += "; " + std::to_string(rows.nearly) + " of them only nearly, and " +
            (rows.nearly == 1 ? "that one is" : "those are") +
            " not held: give points and axes with all their digits, so that axes that should be parallel are";
  return text;
}

nlohmann::ordered_json build_json(const Model& model, const RedundantRows& rows) {
  nlohmann::ordered_json joints = nlohmann::ordered_json::array();
  for (const std::int32_t joint : rows.joints) joints.push_back(model.joints[static_cast<std::size_t>(joint)].name);
  return {{"joints", joints}, {"rows", rows.rows}, {"redundant", rows.redundant}, {"nearly_redundant", rows.nearly}};
}

}  // namespace unlatch::tools
