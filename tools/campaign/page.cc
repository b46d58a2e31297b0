#include "tools/campaign/page.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED_PAGE(unlatch_campaign_page);

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostPoints = 20'000;          // of a plot
constexpr std::size_t kMostSteps = 300, kEnds = 20;  // of a distribution: in all; at its ends, of consecutive samples

// Rows that plots show: every n-th, and the worst.
std::vector<std::size_t> choose_rows(const CampaignData& data, const Json& worst, std::size_t every) {
  std::set<std::int64_t> kept;
  for (const Json& sample : worst) kept.insert(sample.get<std::int64_t>());
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (i % every == 0 || kept.contains(data.get_sample(i))) places.push_back(i);
  return places;
}

Json pick(const std::vector<double>& values, const std::vector<std::size_t>& places) {
  Json json = Json::array();
  for (const std::size_t i : places) json.push_back(std::isnan(values[i]) ? Json(nullptr) : Json(values[i]));
  return json;
}

// Histogram and cumulative distribution of all values: {from, size, counts, steps}. Steps are [value, part of the
// samples up to it], thinned by rank, but complete at both ends.
Json describe_distribution(std::vector<double> sorted) {
  std::erase_if(sorted, [](double value) { return !std::isfinite(value); });
  if (sorted.empty()) return nullptr;
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const auto bins = static_cast<std::size_t>(std::clamp(std::ceil(2 * std::cbrt(n)), 5.0, 60.0));  // Rice's rule
  const double from = sorted.front(), spread = sorted.back() - from;
  const double size = spread > 0 ? spread / static_cast<double>(bins) : 1;
  std::vector<std::int64_t> counts(bins, 0);
  for (const double value : sorted)
    ++counts[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, (value - from) / size)))];
  Json steps = Json::array();
  const std::size_t every = (sorted.size() + kMostSteps - 1) / kMostSteps;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (k % every == 0 || k < kEnds || k + kEnds >= sorted.size())
      steps.push_back({sorted[k], static_cast<double>(k + 1) / n});
  return {{"from", from}, {"size", size}, {"counts", counts}, {"steps", steps}};
}

}  // namespace

std::string build_campaign_page(const CampaignData& data, const Json& summary, const std::string& folder,
                                const Json& flights) {
  const std::size_t every = std::max<std::size_t>(1, (data.rows + kMostPoints - 1) / kMostPoints);
  const std::vector<std::size_t> places = choose_rows(data, summary.at("worst"), every);
  Json document = {
      {"summary", summary}, {"manifest", data.manifest}, {"every", every}, {"folder", folder}, {"flights", flights}};
  document["samples"] = Json::array();
  for (const std::size_t i : places) document["samples"].push_back(data.get_sample(i));
  document["unresolved"] = Json::array();  // places in the list of samples
  for (std::size_t k = 0; k < places.size(); ++k)
    if (data.get_status(places[k]) == hil::SampleStatus::kUnresolved) document["unresolved"].push_back(k);
  const CampaignData drawn = data.get_population().value_or(data);
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) {
    document["inputs"].push_back(pick(data.read_input(k), places));
    document["input_distributions"].push_back(describe_distribution(drawn.read_input(k)));
  }
  for (std::size_t k = 0; k < data.count_plain_columns(); ++k) {
    document["columns"].push_back(pick(data.read_column(k), places));
    document["column_distributions"].push_back(describe_distribution(drawn.read_results(k)));
  }
  return build_page(UNLATCH_EMBEDDED_PAGE(unlatch_campaign_page), document);
}

}  // namespace unlatch::tools
