#include "tools/campaign/page.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED(unlatch_campaign_page, UNLATCH_CAMPAIGN_PAGE);

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostPoints = 20'000;  // of a plot

// Places of the records that plots show: every n-th, and the worst.
std::vector<std::size_t> choose_records(const CampaignData& data, const Json& worst, std::size_t every) {
  std::set<std::int64_t> kept;
  for (const Json& sample : worst) kept.insert(sample.get<std::int64_t>());
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < data.records.size(); ++i)
    if (i % every == 0 || kept.contains(data.records[i].sample)) places.push_back(i);
  return places;
}

Json pick(const std::vector<double>& values, const std::vector<std::size_t>& places) {
  Json json = Json::array();
  for (const std::size_t i : places) json.push_back(std::isnan(values[i]) ? Json(nullptr) : Json(values[i]));
  return json;
}

}  // namespace

std::string build_campaign_page(const CampaignData& data, const Json& summary, const Json& flights) {
  const std::size_t every = std::max<std::size_t>(1, (data.records.size() + kMostPoints - 1) / kMostPoints);
  const std::vector<std::size_t> places = choose_records(data, summary.at("worst"), every);
  Json document = {{"summary", summary}, {"manifest", data.manifest}, {"every", every}, {"flights", flights}};
  document["samples"] = Json::array();
  for (const std::size_t i : places) document["samples"].push_back(data.records[i].sample);
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k)
    document["inputs"].push_back(pick(data.get_input(k), places));
  for (std::size_t k = 0; k < data.count_plain_columns(); ++k)
    document["columns"].push_back(pick(data.get_column(k), places));
  return build_page(UNLATCH_EMBEDDED(unlatch_campaign_page), document);
}

}  // namespace unlatch::tools
