#include "tools/pages/pages.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace unlatch::tools {
namespace {

constexpr std::string_view kPlace = "%UNLATCH_DATA%";

}  // namespace

bool has_pages() { return UNLATCH_HAS_PAGES; }

const char* const kNoPages =
    "this program was built without its pages, which need Node.js and npm; install them (tools/setup does), and build "
    "again: cmake --preset release";

std::string build_page(std::string_view page, const nlohmann::ordered_json& data) {
  const std::size_t place = page.find(kPlace);
  if (place == std::string_view::npos) throw std::logic_error("the page has no place for the data");
  std::string text(page.substr(0, place));
  for (const char c : data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";  // only strings of the JSON can hold one
    else
      text += c;
  }
  return text += page.substr(place + kPlace.size());
}

}  // namespace unlatch::tools
