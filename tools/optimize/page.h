// The page of `unlatch optimize`: one HTML file, without a network. The result, how the search went, slices through
// the result, and the flights of the start and of the result.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/study/optimize/search.h"
#include "tools/optimize/design_flight.h"

namespace unlatch::tools {

struct DesignPage {
  const hil::DesignProblem& problem;
  const hil::DesignEvaluations& evaluations;
  const hil::DesignResult& result;
  const nlohmann::ordered_json& summary;   // result.json
  const nlohmann::ordered_json& manifest;  // manifest.json
  std::string patch;                       // the text of patch.yaml
  std::vector<DesignCurve> before, after;  // flights of the start and of the result
};

std::string build_design_page(const DesignPage& page);

}  // namespace unlatch::tools
