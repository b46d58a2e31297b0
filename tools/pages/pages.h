// HTML pages with data in them: one file each, without a network. A page is bundled from its folder web/ and compiled
// into the program by unlatch_add_page, with one place, %UNLATCH_DATA%, for the data as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace unlatch::tools {

// False if this program was built without Node.js: then it has no pages.
[[nodiscard]] bool has_pages();
// What is missing then, and how to mend it.
extern const char* const kNoPages;

// The whole file. Texts of the data stay data: no `<` of them is left in the HTML. Throws std::logic_error if the page
// has no place for them.
[[nodiscard]] std::string build_page(std::string_view page, const nlohmann::ordered_json& data);

}  // namespace unlatch::tools
