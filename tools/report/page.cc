#include "tools/report/page.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#ifdef UNLATCH_REPORT_PAGE
// The assembler reads the file; a compiler would need half a minute for it as an array.
asm(R"(
  .section .rodata
  .global unlatch_report_page, unlatch_report_page_end
unlatch_report_page:
  .incbin ")" UNLATCH_REPORT_PAGE R"("
unlatch_report_page_end:
  .byte 0
  .text
)");
extern "C" const char unlatch_report_page[], unlatch_report_page_end[];
#endif

namespace unlatch::tools {
namespace {

std::string_view get_template() {
#ifdef UNLATCH_REPORT_PAGE
  return {unlatch_report_page, static_cast<std::size_t>(unlatch_report_page_end - unlatch_report_page)};
#else
  return {};
#endif
}

constexpr std::string_view kPlace = "%UNLATCH_DATA%";  // of the data in the page; once

}  // namespace

bool has_page() { return !get_template().empty(); }

std::string build_page(const nlohmann::ordered_json& document) {
  const std::string_view page = get_template();
  const std::size_t place = page.find(kPlace);
  if (place == std::string_view::npos) throw std::logic_error("the page has no place for the data");
  std::string text(page.substr(0, place));
  for (const char c : document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";  // only strings of the JSON can hold one
    } else {
      text += c;
    }
  }
  text += page.substr(place + kPlace.size());
  return text;
}

}  // namespace unlatch::tools
