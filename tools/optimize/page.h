// The page of `unlatch optimize`: one HTML file, without a network. The result, how the search went, slices through
// the result, and the flights of the start and of the result.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/study/optimize/search.h"
#include "tools/optimize/point_flight.h"

namespace unlatch::tools {

struct OptimizePage {
  const hil::OptimizeProblem& problem;
  const hil::OptimizeEvaluations& evaluations;
  const hil::OptimizeResult& result;
  const nlohmann::ordered_json& summary;     // result.json
  const nlohmann::ordered_json& manifest;    // manifest.json
  std::string patch;                         // the text of patch.yaml
  std::vector<OptimizeCurve> before, after;  // flights of the start and of the result
};

std::string build_optimize_page(const OptimizePage& page);

}  // namespace unlatch::tools
