// HTML pages with data in them: one file each, without a network. A page is a text with three places:
//
//   %UNLATCH_HEAD%     head.html: the policy that allows no connection, and the style
//   %UNLATCH_SCRIPT%   page.js: elements, numbers, tables, plots
//   %UNLATCH_DATA%     the data as JSON, in an element with the id `data`
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace unlatch::tools {

// Texts of the data stay data: no `<` of them is left in the HTML. Throws std::logic_error if a place is missing.
std::string build_page(std::string_view page, const nlohmann::ordered_json& data);

}  // namespace unlatch::tools
