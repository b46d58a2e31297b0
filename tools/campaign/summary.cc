#include "tools/campaign/summary.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <span>

#include "hil/language/setting.h"
#include "hil/sampling/sampling.h"
#include "hil/statistics/statistics.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

constexpr double kProbabilities[] = {0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999};
constexpr std::size_t kWorst = 10, kMostOrders = 20;

Json to_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json to_json(const hil::Interval& interval) { return Json::array({interval.low, interval.high}); }

std::vector<double> sort_present(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  std::sort(values.begin(), values.end());
  return values;
}

void add_quantiles(const std::vector<double>& sorted, Json& to) {
  to["quantiles"] = Json::object();
  to["intervals"] = Json::object();
  for (const double p : kProbabilities) {
    to["quantiles"][hil::to_text(p)] = to_json(hil::calc_quantile(sorted, p));
    if (const auto interval = hil::calc_quantile_interval(sorted, p))
      to["intervals"][hil::to_text(p)] = to_json(*interval);
  }
}

Json describe_column(const Json& column, const std::vector<double>& values) {
  const std::vector<double> sorted = sort_present(values);
  Json json = {{"name", column.at("name")},
               {"unit", column.at("unit")},
               {"count", sorted.size()},
               {"missing", values.size() - sorted.size()}};
  double mean = 0, square = 0;
  for (const double x : sorted) mean += x / static_cast<double>(sorted.size());
  for (const double x : sorted) square += (x - mean) * (x - mean);
  json["mean"] = sorted.empty() ? Json(nullptr) : to_json(mean);
  json["deviation"] =
      sorted.size() < 2 ? Json(nullptr) : to_json(std::sqrt(square / static_cast<double>(sorted.size() - 1)));
  json["min"] = sorted.empty() ? Json(nullptr) : to_json(sorted.front());
  json["max"] = sorted.empty() ? Json(nullptr) : to_json(sorted.back());
  add_quantiles(sorted, json);
  return json;
}

// A sample fails a requirement that it does not meet, cannot be judged by, or does not live to be judged by.
bool fails(hil::SampleStatus status, double margin) { return status != hil::SampleStatus::kDone || !(margin >= 0); }

Json describe_requirement(const CampaignData& data, const Json& requirement) {
  const std::string id = requirement.at("id");
  const std::vector<double> margins = data.read_column(data.find_column(id + ".margin"));
  std::int64_t failed = 0, unjudged = 0;
  for (std::size_t i = 0; i < margins.size(); ++i) {
    failed += fails(data.table->get_status(i), margins[i]) ? 1 : 0;
    unjudged += std::isnan(margins[i]) ? 1 : 0;
  }
  const auto count = static_cast<std::int64_t>(margins.size());
  Json json = requirement;
  json["failed"] = failed;
  json["not_evaluated"] = unjudged;  // counted as failed
  json["probability"] = to_json(hil::calc_clopper_pearson(failed, count));
  const std::vector<double> sorted = sort_present(data.read_column(data.find_column(id)));
  add_quantiles(sorted, json);
  // The least and the greatest value that at least 99 % of all runs keep to, with the confidence.
  constexpr double kCoverage = 0.99;
  const std::int64_t rank = hil::calc_wilks_rank(static_cast<std::int64_t>(sorted.size()), kCoverage);
  json["tolerance"] = {{"coverage", kCoverage}, {"samples_needed", hil::calc_wilks_trials(kCoverage)}};
  if (rank > 0) {
    json["tolerance"]["lower"] = sorted[static_cast<std::size_t>(rank - 1)];
    json["tolerance"]["upper"] = sorted[sorted.size() - static_cast<std::size_t>(rank)];
  }
  // Convergence: bounds of the probability after the first samples.
  json["convergence"] = Json::array();
  std::int64_t hits = 0;
  double next = 10;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto row = static_cast<std::size_t>(i);
    hits += fails(data.table->get_status(row), margins[row]) ? 1 : 0;
    if (static_cast<double>(i + 1) < next && i + 1 < count) continue;
    const hil::Interval bounds = hil::calc_clopper_pearson(hits, i + 1);
    json["convergence"].push_back(
        {i + 1, static_cast<double>(hits) / static_cast<double>(i + 1), bounds.low, bounds.high});
    next *= 1.25;
  }
  return json;
}

// Faults first, then by the smallest margin of all that a sample may fail, in units of the spread of that margin over
// all samples.
Json list_worst(const CampaignData& data) {
  std::vector<double> least(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row)
    least[row] = data.table->get_status(row) == hil::SampleStatus::kDone ? HUGE_VAL : -HUGE_VAL;
  const auto take = [&](const std::vector<double>& margins) {
    const std::vector<double> sorted = sort_present(margins);
    const double spread = hil::calc_quantile(sorted, 0.9) - hil::calc_quantile(sorted, 0.1);
    for (std::size_t i = 0; i < margins.size(); ++i) {
      const double scaled = std::isnan(margins[i]) ? -HUGE_VAL : spread > 0 ? margins[i] / spread : margins[i];
      least[i] = std::min(least[i], scaled);
    }
  };
  for (const Json& requirement : data.manifest.at("requirements"))
    take(data.read_column(data.find_column(requirement.at("id").get<std::string>() + ".margin")));
  if (const auto failure = data.get_failure()) take(data.read_failure_margins(*failure));
  std::vector<std::size_t> order(data.rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t count = std::min(kWorst, order.size());
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count), {},
                            [&](std::size_t row) { return std::pair(least[row], row); });
  Json worst = Json::array();
  for (std::size_t i = 0; i < count; ++i) worst.push_back(data.table->get_sample(order[i]));
  return worst;
}

// An order of events as bytes: for each event the relation to the one before it, and its number in two bytes, by which
// orders sort as their texts do.
class EventOrders {
 public:
  explicit EventOrders(const Json& columns) {
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (columns[k].at("kind") == "event") events_.push_back({columns[k].at("name").get<std::string>().substr(6), k});
    std::ranges::stable_sort(events_, {}, &Event::name);
  }

  [[nodiscard]] std::string encode(const std::vector<double>& values) const {
    std::vector<std::pair<std::pair<double, std::size_t>, std::size_t>> came;  // time, column; number
    for (std::size_t number = 0; number < events_.size(); ++number)
      if (const double time = values[events_[number].column]; !std::isnan(time))
        came.emplace_back(std::pair(time, events_[number].column), number);
    std::ranges::sort(came);
    std::string code;
    for (std::size_t i = 0; i < came.size(); ++i) {
      const bool same = i > 0 && came[i].first.first == came[i - 1].first.first;
      code += i == 0 ? kFirst : same ? kSame : kLater;
      code += static_cast<char>(came[i].second >> 8);
      code += static_cast<char>(came[i].second & 0xff);
    }
    return code;
  }
  [[nodiscard]] std::string describe(const std::string& code) const {
    std::string text;
    for (std::size_t i = 0; i + 2 < code.size(); i += 3) {
      const auto get = [&](std::size_t k) { return std::size_t{static_cast<unsigned char>(code[i + k])}; };
      text += (code[i] == kFirst ? "" : code[i] == kSame ? " = " : " > ") + events_[get(1) << 8 | get(2)].name;
    }
    return text;
  }

 private:
  struct Event {
    std::string name;
    std::size_t column;
  };
  static constexpr char kFirst = 0, kSame = 1, kLater = 2;
  std::vector<Event> events_;
};

// Samples by the order of their events: a class for each order, the most frequent first.
Json list_orders(const CampaignData& data) {
  struct Class {
    std::int64_t samples = 0, first = 0;
  };
  const EventOrders orders(data.manifest.at("columns"));
  std::map<std::string, Class> classes;
  for (std::size_t row = 0; row < data.rows; ++row) {
    const hil::SampleRecord record = data.table->read(row);
    Class& own = classes[orders.encode(record.result.values)];
    if (own.samples++ == 0) own.first = record.sample;
  }
  std::vector<const std::pair<const std::string, Class>*> sorted;
  for (const auto& one : classes) sorted.push_back(&one);
  std::ranges::stable_sort(sorted, std::greater(), [](const auto* one) { return one->second.samples; });
  Json json = {{"count", sorted.size()}, {"classes", Json::array()}};
  for (std::size_t i = 0; i < std::min(kMostOrders, sorted.size()); ++i)
    json["classes"].push_back({{"order", orders.describe(sorted[i]->first)},
                               {"samples", sorted[i]->second.samples},
                               {"first", sorted[i]->second.first}});
  return json;
}

// Blocks of a design in which every sample has a value.
struct Blocks {
  std::vector<std::vector<double>> values;  // [place in the block][block]
  std::vector<std::int64_t> numbers;        // of these blocks
  std::int64_t left_out = 0;                // blocks in which one is missing
};

Blocks get_blocks(const CampaignData& data, const std::vector<double>& values, std::size_t size) {
  const auto samples = static_cast<std::int64_t>(size);
  Blocks blocks;
  blocks.values.resize(size);
  const std::int64_t planned = data.manifest.at("samples").get<std::int64_t>() / samples;
  for (std::size_t i = 0; i < values.size();) {
    const std::int64_t number = data.table->get_sample(i) / samples;
    std::vector<double> found(size, std::numeric_limits<double>::quiet_NaN());
    for (; i < values.size() && data.table->get_sample(i) / samples == number; ++i)
      found[static_cast<std::size_t>(data.table->get_sample(i) % samples)] = values[i];
    if (std::ranges::any_of(found, [](double x) { return std::isnan(x); })) continue;
    blocks.numbers.push_back(number);
    for (std::size_t k = 0; k < size; ++k) blocks.values[k].push_back(found[k]);
  }
  blocks.left_out = planned - static_cast<std::int64_t>(blocks.numbers.size());
  return blocks;
}

void describe_blocks(const Blocks& blocks, Json& to) {
  to["blocks"] = {{"used", blocks.numbers.size()}, {"left_out", blocks.left_out}};
}

Json describe_sensitivity(const CampaignData& data, const hil::RankedVariables& inputs,
                          const std::vector<double>& values) {
  Json json = {{"spearman", Json::array()}};
  for (const double rho : inputs.calc_spearman(values)) json["spearman"].push_back(to_json(rho));
  const std::string sampling = data.manifest.at("sampling");
  std::size_t axes = 0;
  Json names = Json::array();
  for (const Json& parameter : data.manifest.at("parameters")) {
    for (std::size_t k = 0; k < parameter.at("axes").get<std::size_t>(); ++k)
      names.push_back(parameter.at("name").get<std::string>() + (parameter.at("axes") == 1 ? ""
                                                                 : k == 0                  ? ".angle"
                                                                                           : ".turn"));
    axes += parameter.at("axes").get<std::size_t>();
  }
  const std::uint64_t seed = data.manifest.at("seed");
  if (sampling == "morris") {
    const Blocks blocks = get_blocks(data, values, axes + 1);
    describe_blocks(blocks, json);
    if (blocks.numbers.empty()) return json;
    const hil::SamplingPlan plan{hil::Sampling::kMorris, seed, data.manifest.at("samples"), axes, {}};
    std::vector<std::vector<double>> effects(axes);
    for (std::size_t i = 0; i < blocks.numbers.size(); ++i)
      for (std::size_t k = 1; k <= axes; ++k) {
        const hil::MorrisStep step = hil::get_morris_step(plan, blocks.numbers[i], k);
        effects[step.axis].push_back(step.sign * (blocks.values[k][i] - blocks.values[k - 1][i]) / hil::kMorrisStep);
      }
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const hil::MorrisEffect effect = hil::calc_morris(effects[axis]);
      json["morris"].push_back({{"parameter", names[axis]},
                                {"mean_size", effect.mean_size},
                                {"mean", effect.mean},
                                {"deviation", effect.deviation}});
    }
  }
  if (sampling == "saltelli") {
    const Blocks blocks = get_blocks(data, values, axes + 2);
    describe_blocks(blocks, json);
    if (blocks.numbers.empty()) return json;
    const std::vector<hil::SobolIndex> indices =
        hil::calc_sobol_indices(blocks.values[0], blocks.values[1], std::span(blocks.values).subspan(2), seed);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const hil::SobolIndex& index = indices[axis];
      json["sobol"].push_back(
          {{"parameter", names[axis]},
           {"first", to_json(index.first)},
           {"first_interval", {to_json(index.first_interval.low), to_json(index.first_interval.high)}},
           {"total", to_json(index.total)},
           {"total_interval", {to_json(index.total_interval.low), to_json(index.total_interval.high)}}});
    }
  }
  return json;
}

// Bands of a curve over the samples at each of its times: null where no sample has a value.
Json describe_curve(const CampaignData& data, const Json& curve) {
  Json json = {{"name", curve.at("name")}, {"unit", curve.at("unit")}, {"times", curve.at("times")}};
  for (const char* key : {"count", "min", "0.05", "0.5", "0.95", "max"}) json[key] = Json::array();
  const auto first = curve.at("first_column").get<std::size_t>();
  for (std::size_t point = 0; point < curve.at("times").size(); ++point) {
    const std::vector<double> sorted = sort_present(data.read_column(first + point));
    json["count"].push_back(sorted.size());
    for (const auto& [key, p] : {std::pair{"min", 0.0}, {"0.05", 0.05}, {"0.5", 0.5}, {"0.95", 0.95}, {"max", 1.0}})
      json[key].push_back(to_json(hil::calc_quantile(sorted, p)));
  }
  return json;
}

// Levels of subset sampling, its estimate, and the probability of each margin: [margin, probability] from 1 down.
Json describe_rare(const CampaignData& data, const hil::RareFailure& failure) {
  hil::SamplingPlan plan;
  plan.seed = data.manifest.at("seed");
  for (const Json& parameter : data.manifest.at("parameters"))
    plan.dimensions += parameter.at("axes").get<std::size_t>();
  hil::SubsetSimulation subset(make_subset_plan(failure, plan));
  std::int64_t failed = 0;
  const std::vector<double> margins = data.read_failure_margins(failure);
  for (std::size_t row = 0; row < data.rows; ++row) {
    subset.note(data.table->get_sample(row), margins[row]);
    failed += margins[row] < 0 ? 1 : 0;
  }
  const hil::SubsetEstimate estimate = subset.calc_estimate();
  Json json = data.manifest.at("subset");
  json.erase("column_index");
  json["finished"] = subset.is_finished();
  json["reached"] = estimate.reached;
  json["probability"] = subset.is_finished() ? to_json(estimate.probability) : Json(nullptr);
  json["deviation"] = to_json(estimate.deviation);
  json["interval"] = {estimate.low, estimate.high};
  json["met"] = subset.is_finished() && estimate.reached && estimate.high <= failure.at_most;
  json["failed_samples"] = failed;
  json["levels_run"] = Json::array();
  json["curve"] = Json::array();
  double before = 1;
  for (const hil::SubsetLevel& level : subset.levels()) {
    json["levels_run"].push_back({{"first", level.first},
                                  {"last", level.last},
                                  {"threshold", to_json(level.threshold)},
                                  {"probability", level.probability},
                                  {"deviation", to_json(level.deviation)},
                                  {"acceptance", level.acceptance},
                                  {"spread", level.spread}});
    // The margins of a level above its threshold; those below it are better known from the next.
    const std::size_t count = level.margins.size(), every = std::max<std::size_t>(1, count / 100);
    const bool last = &level == &subset.levels().back();
    for (std::size_t k = count; k-- > 0;) {
      if (k % every != 0 || !std::isfinite(level.margins[k])) continue;
      if (!last && level.margins[k] <= level.threshold) break;
      json["curve"].push_back({level.margins[k], before * static_cast<double>(k + 1) / static_cast<double>(count)});
    }
    before *= level.probability;
  }
  return json;
}

}  // namespace

Json build_summary(const CampaignData& all) {
  const CampaignData data = all.get_drawn();
  Json statuses = Json::object();
  for (const std::string& name : hil::kSampleStatusNames) statuses[name] = 0;
  statuses.erase("interrupted");
  for (std::size_t row = 0; row < all.rows; ++row) {
    Json& count = statuses[hil::kSampleStatusNames[static_cast<std::size_t>(all.table->get_status(row))]];
    count = count.get<std::int64_t>() + 1;
  }
  Json summary = {{"schema", 1},
                  {"campaign", data.manifest.at("campaign")},
                  {"scenario", data.manifest.at("scenario")},
                  {"samples", all.rows},
                  {"planned", data.manifest.at("samples")},
                  {"hash", to_hex(data.table->hash())},
                  {"confidence", hil::kConfidence},
                  {"statuses", statuses},
                  {"requirements", Json::array()},
                  {"worst", list_worst(all)}};
  if (const auto failure = all.get_failure()) {
    summary["drawn"] = data.rows;
    summary["rare"] = describe_rare(all, *failure);
  }
  for (const Json& requirement : data.manifest.at("requirements"))
    summary["requirements"].push_back(describe_requirement(data, requirement));
  summary["orders"] = list_orders(data);
  hil::RankedVariables ranked;
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) {
    const std::vector<double> values = data.read_input(k);
    ranked.add(values);
    summary["inputs"].push_back(describe_column(data.manifest.at("inputs")[k], values));
  }
  for (std::size_t k = 0; k < data.count_plain_columns(); ++k) {
    const std::vector<double> values = data.read_column(k);
    Json column = describe_column(data.manifest.at("columns")[k], values);
    column["kind"] = data.manifest.at("columns")[k].at("kind");
    column["sensitivity"] = describe_sensitivity(data, ranked, values);
    summary["columns"].push_back(std::move(column));
  }
  if (data.manifest.contains("curves"))
    for (const Json& curve : data.manifest.at("curves")) summary["curves"].push_back(describe_curve(data, curve));
  return summary;
}

namespace {

std::string describe_failure(const Json& rare) {
  return rare.at("column").get<std::string>() + (rare.at("above").get<bool>() ? " above " : " below ") +
         hil::to_text(rare.at("limit").get<double>()) + " " + rare.at("unit").get<std::string>();
}

std::string describe_number(const Json& value, const char* form) {
  return value.is_null() ? std::string("–") : format(form, value.get<double>());
}

// Of each side that has a limit.
std::string describe_tolerance(const Json& requirement) {
  const Json& tolerance = requirement.at("tolerance");
  if (!tolerance.contains("lower")) return format("needs %lld", tolerance.at("samples_needed").get<long long>());
  std::string text;
  if (!requirement.at("at_least").is_null()) text = format("≥ %.5g", tolerance.at("lower").get<double>());
  if (!requirement.at("at_most").is_null())
    text += (text.empty() ? "" : ", ") + format("≤ %.5g", tolerance.at("upper").get<double>());
  return text;
}

void print_rare(std::FILE* to, const Json& rare) {
  const std::string unit = rare.at("unit");
  print_heading(to, "Subset simulation: " + describe_failure(rare));
  std::fprintf(to, "  %-6s %16s %14s %14s %10s %10s\n", "level", "samples", "margin", "probability", "c.o.v.",
               "accepted");
  int number = 0;
  for (const Json& level : rare.at("levels_run")) {
    const std::string range =
        format("%lld to %lld", level.at("first").get<long long>(), level.at("last").get<long long>() - 1);
    std::fprintf(to, "  %-6d %16s %14s %14s %10s %10s\n", number, range.c_str(),
                 describe_number(level.at("threshold"), "%.5g").c_str(),
                 describe_number(level.at("probability"), "%.4g").c_str(),
                 describe_number(level.at("deviation"), "%.3f").c_str(),
                 number == 0 ? "" : describe_number(level.at("acceptance"), "%.2f").c_str());
    ++number;
  }
  if (!rare.at("finished").get<bool>()) {
    std::fprintf(to, "  not finished\n");
    return;
  }
  const std::string text = format("probability %.3g, 95 %%: %.2e … %.2e", rare.at("probability").get<double>(),
                                  rare.at("interval")[0].get<double>(), rare.at("interval")[1].get<double>());
  const bool met = rare.at("met").get<bool>();
  std::fprintf(to, "  %s, coefficient of variation %s%s\n",
               paint(to, met ? Colour::kGreen : Colour::kRed, text).c_str(),
               describe_number(rare.at("deviation"), "%.2f").c_str(),
               rare.at("reached").get<bool>() ? "" : "; the last level had too few failures: more levels");
}

}  // namespace

void print_summary(std::FILE* to, const Json& summary) {
  const auto text = [](const Json& value) {
    return value.is_null() ? std::string("–") : format("%.5g", value.get<double>());
  };
  std::fprintf(to, "%s: %lld of %s, campaign hash %s\n", summary.at("campaign").get<std::string>().c_str(),
               summary.at("samples").get<long long>(), count(summary.at("planned").get<long long>(), "sample").c_str(),
               summary.at("hash").get<std::string>().c_str());
  for (const auto& [name, count] : summary.at("statuses").items())
    if (count > 0) std::fprintf(to, "  %lld %s\n", count.get<long long>(), name.c_str());
  if (summary.contains("rare")) print_rare(to, summary.at("rare"));
  if (summary.at("requirements").empty()) return;
  print_heading(to,
                std::string("Requirements") + (summary.contains("rare") ? ", first level alone" : "") +
                    ": failures, 95 % bounds of their probability (Clopper-Pearson), quantiles of the value, what 99 % "
                    "of all runs keep to with 95 % confidence (Wilks)");
  std::fprintf(to, "  %-16s %8s %8s  %-23s %10s %10s %10s %10s %10s  %s\n", "", "failed", "missing", "probability",
               "1 %", "5 %", "50 %", "95 %", "99 %", "tolerance");
  for (const Json& requirement : summary.at("requirements")) {
    const Json &p = requirement.at("probability"), &q = requirement.at("quantiles");
    const bool failed = requirement.at("failed") > 0;
    const std::string bounds = format("%.2e … %.2e", p[0].get<double>(), p[1].get<double>());
    std::fprintf(
        to, "  %-16s %s %8lld  %-25s %10s %10s %10s %10s %10s  %s %s\n",
        requirement.at("id").get<std::string>().c_str(),
        paint(to, failed ? Colour::kRed : Colour::kGreen, format("%8lld", requirement.at("failed").get<long long>()))
            .c_str(),
        requirement.at("not_evaluated").get<long long>(), bounds.c_str(), text(q.at("0.01")).c_str(),
        text(q.at("0.05")).c_str(), text(q.at("0.5")).c_str(), text(q.at("0.95")).c_str(), text(q.at("0.99")).c_str(),
        describe_tolerance(requirement).c_str(), requirement.at("unit").get<std::string>().c_str());
  }
  std::string worst;
  for (const Json& sample : summary.at("worst"))
    worst += (worst.empty() ? "" : ", ") + std::to_string(sample.get<long long>());
  std::fprintf(to, "\nWorst samples: %s\n", worst.c_str());
  std::fprintf(to, "Orders of events: %lld\n", summary.at("orders").at("count").get<long long>());
}

}  // namespace unlatch::tools
