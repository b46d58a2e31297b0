#include "tools/pages/pages.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/pages/embed.h"

UNLATCH_EMBED(unlatch_page_head, UNLATCH_PAGES "/head.html");
UNLATCH_EMBED(unlatch_page_script, UNLATCH_PAGES "/page.js");

namespace unlatch::tools {
namespace {

std::string write_data(const nlohmann::ordered_json& data) {
  std::string text;
  for (const char c : data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";  // only strings of the JSON can hold one
    else
      text += c;
  }
  return text;
}

}  // namespace

std::string build_page(std::string_view page, const nlohmann::ordered_json& data) {
  const std::string written = write_data(data);
  std::string text;
  const auto put = [&](std::string_view place, std::string_view content) {
    const std::size_t at = page.find(place);
    if (at == std::string_view::npos) throw std::logic_error("the page has no " + std::string(place));
    text += page.substr(0, at);
    text += content;
    page.remove_prefix(at + place.size());
  };
  put("%UNLATCH_HEAD%", UNLATCH_EMBEDDED(unlatch_page_head));
  put("%UNLATCH_DATA%", written);
  put("%UNLATCH_SCRIPT%", UNLATCH_EMBEDDED(unlatch_page_script));
  return text += page;
}

}  // namespace unlatch::tools
