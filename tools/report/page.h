// The page of `unlatch report`: HTML, style and script in one piece, bundled by web/build.mjs and compiled into the
// program, with a place for the data.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace unlatch::tools {

// False if this program was built without Node.js: then there is no page.
[[nodiscard]] bool has_page();

// The whole file. Whatever the document's texts are, they stay data: no `<` of them is left in the HTML.
[[nodiscard]] std::string build_page(const nlohmann::ordered_json& document);

}  // namespace unlatch::tools
