#include "tools/campaign/steps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace unlatch::tools {

Json describe_steps(const CampaignData& data) {
  Json step = data.manifest.at("step");
  const std::vector<double> steps = data.read_column(data.find_column("step"));
  const std::vector<double> errors = data.read_column(data.find_column("step.error"));
  std::int64_t checked = 0;
  double largest = 0;
  Json again = Json::array();
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (steps[row] < step.at("step").get<double>()) again.push_back(data.get_sample(row));
    if (std::isnan(errors[row])) continue;
    ++checked;
    largest = std::max(largest, errors[row]);
  }
  step["checked"] = checked;
  step["largest_error"] = checked > 0 && std::isfinite(largest) ? Json(largest) : Json(nullptr);
  step["flown_again"] = again;
  return step;
}

}  // namespace unlatch::tools
