// Outputs of a run as JSON: by kind, subject and key, as in the samples of `unlatch run --json`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "hil/run/outputs/output_reader.h"

namespace unlatch::tools {

// {"bodies": {"core": {"p": […], …}}, "reactions": …, "joints": …, "elements": …, "sensors": …, "signals": …,
// "channels": …, "clearance": […]} of the outputs chosen. `values`: of all outputs of the reader.
nlohmann::ordered_json build_outputs_json(const hil::OutputReader& reader, const Model& model,
                                          std::span<const std::size_t> chosen, std::span<const double> values);
// [{"name", "frame", "columns": [{"name", "unit"}]}] of those chosen.
nlohmann::ordered_json build_output_list_json(std::span<const hil::Output> list, std::span<const std::size_t> chosen);

}  // namespace unlatch::tools
