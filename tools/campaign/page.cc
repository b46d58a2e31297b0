#include "tools/campaign/page.h"

#include <cmath>
#include <stdexcept>
#include <string_view>

// The assembler reads the file.
asm(R"(
  .section .rodata
  .global unlatch_campaign_page, unlatch_campaign_page_end
unlatch_campaign_page:
  .incbin ")" UNLATCH_CAMPAIGN_PAGE R"("
unlatch_campaign_page_end:
  .byte 0
  .text
)");
extern "C" const char unlatch_campaign_page[], unlatch_campaign_page_end[];

namespace unlatch::tools {
namespace {

constexpr std::string_view kPlace = "%UNLATCH_DATA%";  // of the data in the page; once
constexpr std::size_t kMostPoints = 20'000;            // of a plot

Json thin(const std::vector<double>& values, std::size_t every) {
  Json json = Json::array();
  for (std::size_t i = 0; i < values.size(); i += every)
    json.push_back(std::isnan(values[i]) ? Json(nullptr) : Json(values[i]));
  return json;
}

}  // namespace

std::string build_campaign_page(const CampaignData& data, const Json& summary) {
  const std::string_view page(unlatch_campaign_page,
                              static_cast<std::size_t>(unlatch_campaign_page_end - unlatch_campaign_page));
  const std::size_t place = page.find(kPlace);
  if (place == std::string_view::npos) throw std::logic_error("the page has no place for the data");
  const std::size_t every = (data.records.size() + kMostPoints - 1) / kMostPoints;
  Json document = {{"summary", summary}, {"manifest", data.manifest}, {"every", every}};
  document["samples"] = Json::array();
  for (std::size_t i = 0; i < data.records.size(); i += every) document["samples"].push_back(data.records[i].sample);
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k)
    document["inputs"].push_back(thin(data.get_input(k), every));
  for (std::size_t k = 0; k < data.manifest.at("columns").size(); ++k)
    document["columns"].push_back(thin(data.get_column(k), every));
  std::string text(page.substr(0, place));
  for (const char c : document.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";  // only strings of the JSON can hold one
    else
      text += c;
  }
  text += page.substr(place + kPlace.size());
  return text;
}

}  // namespace unlatch::tools
