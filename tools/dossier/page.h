// The page of `unlatch dossier`: one HTML file, without a network.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace unlatch::tools {

// `document`: as --json writes it.
std::string build_dossier_page(const nlohmann::ordered_json& document);

}  // namespace unlatch::tools
