#include "tools/campaign/page.h"

#include <cmath>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED(unlatch_campaign_page, UNLATCH_CAMPAIGN_PAGE);

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostPoints = 20'000;  // of a plot

Json thin(const std::vector<double>& values, std::size_t every) {
  Json json = Json::array();
  for (std::size_t i = 0; i < values.size(); i += every)
    json.push_back(std::isnan(values[i]) ? Json(nullptr) : Json(values[i]));
  return json;
}

}  // namespace

std::string build_campaign_page(const CampaignData& data, const Json& summary) {
  const std::size_t every = (data.records.size() + kMostPoints - 1) / kMostPoints;
  Json document = {{"summary", summary}, {"manifest", data.manifest}, {"every", every}};
  document["samples"] = Json::array();
  for (std::size_t i = 0; i < data.records.size(); i += every) document["samples"].push_back(data.records[i].sample);
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k)
    document["inputs"].push_back(thin(data.get_input(k), every));
  for (std::size_t k = 0; k < data.manifest.at("columns").size(); ++k)
    document["columns"].push_back(thin(data.get_column(k), every));
  return build_page(UNLATCH_EMBEDDED(unlatch_campaign_page), document);
}

}  // namespace unlatch::tools
