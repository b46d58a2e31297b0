// The page of `unlatch report`: one HTML file, without a network.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace unlatch::tools {

// The whole file, in a program that has pages (tools/pages/pages.h).
[[nodiscard]] std::string build_report_page(const nlohmann::ordered_json& document);

}  // namespace unlatch::tools
