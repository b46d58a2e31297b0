#include "tools/campaign/campaign_data.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "hil/run/recording/log_format.h"
#include "hil/scenario/yaml/setting.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/common/unfinished_file.h"
#include "tools/export/node_writer.h"

namespace unlatch::tools {
namespace {

namespace fs = std::filesystem;

using Kind = hil::ResultColumn::Kind;

const char* get_kind_name(Kind kind) {
  static const char* const kNames[] = {
      "requirement", "margin",  "event",  "clearance", "clearance_time", "released",   "tip_off",      "separation",
      "peak",        "contact", "output", "curve",     "step",           "step_error", "without_blow", "uncertainty"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Kind::kUncertainty) + 1);
  return kNames[static_cast<std::size_t>(kind)];
}

Json to_limit(double limit) { return std::isfinite(limit) ? Json(limit) : Json(nullptr); }

std::string to_cell(double value) { return std::isnan(value) ? "" : hil::to_text(value); }

// Curves with their times and the first of their columns, which are the last ones.
Json write_curves(const hil::SampleEvaluator& evaluator) {
  const hil::ChosenOutputs& chosen = evaluator.chosen();
  std::size_t first = evaluator.columns().size() - chosen.count() + chosen.count_steps() + chosen.values.size();
  Json curves = Json::array();
  for (const hil::ChosenCurves& group : chosen.curves) {
    Json times = Json::array();
    for (std::size_t point = 0; point < group.points; ++point) times.push_back(group.get_time(point));
    for (const hil::ChosenCurves::Curve& curve : group.curves) {
      curves.push_back({{"name", curve.name}, {"unit", curve.unit}, {"first_column", first}, {"times", times}});
      first += group.points;
    }
  }
  return curves;
}

// What was found for the tolerance.
Json write_step(const hil::StepSearch& search) {
  Json trials = Json::array();
  for (const hil::StepTrial& trial : search.trials)
    trials.push_back(
        {{"step", trial.step}, {"error", to_limit(trial.error)}, {"of", trial.of}, {"flight", trial.flight}});
  return {{"tolerance", search.tolerance},
          {"step", search.step.value_or(search.given)},
          {"scenario_step", search.given},
          {"flights", search.flights},
          {"trials", trials}};
}

// Unit of tables for people; null: the SI unit.
Json write_shown(const std::optional<hil::WrittenUnit>& shown) {
  return shown ? Json{{"unit", shown->name}, {"factor", shown->factor}} : Json(nullptr);
}

Json write_failure(const hil::RareFailure& failure) {
  return {{"column", failure.column}, {"unit", failure.unit},     {"column_index", failure.column_index},
          {"limit", failure.limit},   {"above", failure.above},   {"samples", failure.samples},
          {"chains", failure.chains}, {"levels", failure.levels}, {"at_most", failure.at_most}};
}

// Bytes as they are, checked at the end: a table may be larger than memory for one text.
class File {
 public:
  explicit File(const std::string& path)
      : path_(path), place_(path), stream_(place_.path(), std::ios::binary | std::ios::trunc) {}
  void write(const std::string& text) { stream_ << text; }
  void finish() {
    stream_.close();
    if (!stream_ || !place_.finish()) throw OutputError(path_ + ": it cannot be written");
  }

 private:
  const std::string path_;
  UnfinishedFile place_;
  std::ofstream stream_;
};

}  // namespace

std::string get_manifest_path(const std::string& folder) { return (fs::path(folder) / "manifest.json").string(); }
std::string get_results_path(const std::string& folder) { return (fs::path(folder) / "results.bin").string(); }

Json build_manifest(const hil::Campaign& campaign, const hil::SampleEvaluator& evaluator,
                    const std::vector<std::string>& set) {
  const hil::Scenario& scenario = campaign.tree->get_nominal();
  Json manifest = {{"format", 1},
                   {"campaign", campaign.name},
                   {"title", campaign.title},
                   {"program", "unlatch " UNLATCH_VERSION},
                   {"compiler", hil::get_compiler()},
                   {"fingerprint", to_hex(get_shape(campaign, evaluator).fingerprint)},
                   {"samples", campaign.plan.samples},
                   {"seed", campaign.plan.seed},
                   {"levels", campaign.plan.levels},
                   {"correlated", !campaign.correlations.empty()},
                   {"sampling", hil::kSamplingNames[static_cast<std::size_t>(campaign.plan.sampling)]},
                   {"campaign_file", campaign.file},
                   {"campaign_text", campaign.text},
                   {"scenario", scenario.name},
                   {"scenario_title", scenario.title},
                   {"scenario_file", campaign.scenario},
                   {"scenario_text", scenario.text},
                   {"overrides", scenario.overrides},
                   {"set", set},
                   {"remarks", campaign.remarks},
                   {"inputs", Json::array()},
                   {"parameters", Json::array()},
                   {"columns", Json::array()},
                   {"requirements", Json::array()}};
  if (campaign.step_search) manifest["step"] = write_step(*campaign.step_search);
  if (campaign.failure) manifest["subset"] = write_failure(*campaign.failure);
  for (const hil::InputColumn& input : list_inputs(campaign))
    manifest["inputs"].push_back({{"name", input.name},
                                  {"unit", input.unit},
                                  {"shown", write_shown(input.shown)},
                                  {"category", input.is_category}});
  for (const hil::CampaignParameter& parameter : campaign.parameters)
    manifest["parameters"].push_back({{"name", parameter.name},
                                      {"paths", parameter.paths},
                                      {"numbers", parameter.distribution.is_cone() ? 3 : 1},
                                      {"axes", parameter.distribution.get_dimensions()}});
  for (const hil::ResultColumn& column : evaluator.columns())
    manifest["columns"].push_back({{"name", column.name}, {"unit", column.unit}, {"kind", get_kind_name(column.kind)}});
  if (!evaluator.chosen().curves.empty()) manifest["curves"] = write_curves(evaluator);
  for (const hil::Requirement& requirement : scenario.requirements)
    manifest["requirements"].push_back({{"id", requirement.id},
                                        {"text", requirement.text},
                                        {"unit", requirement.unit},
                                        {"shown", write_shown(find_shown_unit(campaign, requirement.id))},
                                        {"at_least", to_limit(requirement.least)},
                                        {"at_most", to_limit(requirement.most)}});
  return manifest;
}

Json read_manifest(const std::string& folder) {
  const std::string path = get_manifest_path(folder);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw hil::ResultError(path + ": it cannot be opened; a campaign's folder has it");
  try {
    Json manifest = Json::parse(stream);
    if (manifest.at("format") != 1 || !manifest.contains("set"))
      throw hil::ResultError(path + ": a format of another version");
    return manifest;
  } catch (const Json::exception& error) {
    throw hil::ResultError(path + ": not a campaign's manifest: " + error.what());
  }
}

CampaignData read_campaign(const std::string& folder) {
  Json manifest = read_manifest(folder);
  hil::ResultFile file = hil::ResultFile::open(get_results_path(folder), false);
  if (to_hex(file.shape().fingerprint) != manifest.at("fingerprint").get<std::string>() ||
      file.shape().inputs != manifest.at("inputs").size() || file.shape().values != manifest.at("columns").size())
    throw hil::ResultError(folder + ": results and manifest are not of one campaign");
  auto table = std::make_shared<const hil::ResultTable>(std::move(file));
  const std::size_t rows = table->size();
  return {std::move(manifest), std::move(table), rows};
}

void merge_campaigns(const std::vector<std::string>& folders, const std::string& to) {
  const Json manifest = read_manifest(folders.at(0));
  std::vector<hil::ResultFile> files;
  for (const std::string& folder : folders) {
    if (read_manifest(folder).at("fingerprint") != manifest.at("fingerprint"))
      throw hil::ResultError(folder + ": results of another campaign, scenario or version than " + folders[0]);
    files.push_back(hil::ResultFile::open(get_results_path(folder), false));
  }
  fs::create_directories(to);
  write_text(manifest.dump(1), get_manifest_path(to));
  hil::ResultFile merged = hil::ResultFile::create(get_results_path(to), files[0].shape());
  std::vector<std::int64_t> taken;
  for (const hil::ResultFile& file : files) {
    if (!(file.shape() == merged.shape())) throw hil::ResultError("results of different shapes");
    const std::vector<std::int64_t> before = taken;  // sorted
    for (std::size_t i = 0; i < file.samples().size(); ++i) {
      if (std::binary_search(before.begin(), before.end(), file.samples()[i])) continue;
      merged.append(file.read(i));
      taken.push_back(file.samples()[i]);
    }
    std::sort(taken.begin(), taken.end());
  }
}

std::optional<hil::RareFailure> CampaignData::get_failure() const {
  if (!manifest.contains("subset")) return std::nullopt;
  const Json& json = manifest.at("subset");
  hil::RareFailure failure;
  failure.column = json.at("column");
  failure.unit = json.at("unit");
  failure.column_index = json.at("column_index");
  failure.limit = json.at("limit");
  failure.above = json.at("above");
  failure.samples = json.at("samples");
  failure.chains = json.at("chains");
  failure.levels = json.at("levels");
  failure.at_most = json.at("at_most");
  const auto whole = [](std::int64_t a, std::int64_t b) { return b > 0 && a % b == 0; };
  if (failure.column_index >= manifest.at("columns").size() || failure.levels < 1 || failure.samples > 1'000'000'000 ||
      !whole(failure.samples, failure.chains) || failure.samples < 2 * failure.chains)
    throw hil::ResultError("the manifest's key `subset` is not of a campaign");
  return failure;
}

std::vector<double> CampaignData::read_failure_margins(const hil::RareFailure& failure) const {
  std::vector<double> margins = read_column(failure.column_index);
  for (std::size_t row = 0; row < rows; ++row)
    margins[row] = calc_failure_margin(failure, get_status(row), margins[row]);
  return margins;
}

CampaignData CampaignData::get_drawn() const {
  CampaignData drawn = *this;
  if (const auto failure = get_failure()) drawn.rows = std::min(rows, table->find(failure->samples));
  return drawn;
}

hil::Sampling CampaignData::get_sampling() const {
  const auto name = std::ranges::find(hil::kSamplingNames, manifest.at("sampling").get<std::string>());
  if (name == hil::kSamplingNames.end()) throw hil::ResultError("the manifest's key `sampling` is not of a campaign");
  return static_cast<hil::Sampling>(name - hil::kSamplingNames.begin());
}

std::optional<CampaignData> CampaignData::get_population() const {
  const hil::SampleBasis basis = hil::get_basis(get_sampling());
  if (basis == hil::SampleBasis::kChosen) return std::nullopt;
  CampaignData drawn = get_drawn();
  if (basis != hil::SampleBasis::kBaseRows) return drawn;
  std::int64_t block = hil::kBaseRowsEach;
  for (const Json& parameter : manifest.at("parameters")) block += parameter.at("axes").get<std::int64_t>();
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < drawn.rows; ++row)
    if (drawn.get_sample(row) % block < hil::kBaseRowsEach) kept.push_back(row);
  drawn.rows = kept.size();
  drawn.places = std::make_shared<const std::vector<std::size_t>>(std::move(kept));
  return drawn;
}

namespace {

std::vector<double> pick_rows(const CampaignData& data, std::size_t number) {
  if (!data.places) return data.table->read_column(number, data.rows);
  const std::vector<double> all = data.table->read_column(number, data.table->size());
  std::vector<double> kept;
  kept.reserve(data.rows);
  for (const std::size_t place : *data.places) kept.push_back(all[place]);
  return kept;
}

}  // namespace

std::vector<double> CampaignData::read_input(std::size_t input) const { return pick_rows(*this, input); }

std::vector<double> CampaignData::read_column(std::size_t column) const {
  return pick_rows(*this, table->shape().inputs + column);
}

std::vector<double> CampaignData::read_results(std::size_t column) const {
  std::vector<double> values = read_column(column);
  for (std::size_t row = 0; row < rows; ++row)
    if (get_status(row) != hil::SampleStatus::kDone) values[row] = std::nan("");
  return values;
}

std::size_t CampaignData::find_column(const std::string& name) const {
  const Json& columns = manifest.at("columns");
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].at("name") == name) return i;
  throw std::out_of_range("no column " + name);
}

std::size_t CampaignData::count_plain_columns() const {
  if (manifest.contains("curves")) return manifest.at("curves").at(0).at("first_column").get<std::size_t>();
  return manifest.at("columns").size();
}

void write_csv(const CampaignData& data, const std::string& path) {
  File file(path);
  std::string line = "sample,status,ticks,hash,model_hash";
  for (const char* part : {"inputs", "columns"})
    for (const Json& column : data.manifest.at(part)) {
      const std::string unit = column.at("unit");
      line += "," + quote_cell(column.at("name").get<std::string>() + (unit.empty() ? "" : " [" + unit + "]"));
    }
  file.write(line + ",message\r\n");
  for (std::size_t row = 0; row < data.rows; ++row) {
    const hil::SampleRecord record = data.table->read(row);
    const hil::SampleResult& result = record.result;
    line = std::to_string(record.sample) + "," + hil::kSampleStatusNames[static_cast<std::size_t>(result.status)] +
           "," + std::to_string(result.ticks) + "," + to_hex(result.hash) + "," + to_hex(result.model_hash);
    for (const auto* values : {&record.inputs, &result.values})
      for (const double value : *values) line += "," + to_cell(value);
    file.write(line + "," + quote_cell(result.message) + "\r\n");
  }
  file.finish();
}

bool write_parquet(const CampaignData& data, const std::string& path) try {
  UnfinishedFile place(path);  // SIGTERM may end this process while Node.js writes
  NodeWriter node("parquet", place.path());
  Json columns = {{{"name", "sample"}, {"unit", "1"}, {"type", "integer"}},
                  {{"name", "status"}, {"unit", "1"}, {"type", "text"}},
                  {{"name", "ticks"}, {"unit", "1"}, {"type", "integer"}},
                  {{"name", "hash"}, {"unit", "1"}, {"type", "text"}},
                  {{"name", "model_hash"}, {"unit", "1"}, {"type", "text"}}};
  for (const char* part : {"inputs", "columns"})
    for (const Json& column : data.manifest.at(part))
      columns.push_back({{"name", column.at("name")}, {"unit", column.at("unit")}, {"type", "optional"}});
  columns.push_back({{"name", "message"}, {"unit", "1"}, {"type", "text"}});
  const auto put = [&](const Json& line) {
    const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    std::fwrite(text.data(), 1, text.size(), node.get_stream());
  };
  put({{"scenario", data.manifest.at("scenario")}, {"columns", columns}});
  for (std::size_t row = 0; row < data.rows; ++row) {
    const hil::SampleRecord record = data.table->read(row);
    Json line = {record.sample, hil::kSampleStatusNames[static_cast<std::size_t>(record.result.status)],
                 record.result.ticks, to_hex(record.result.hash), to_hex(record.result.model_hash)};
    for (const auto* values : {&record.inputs, &record.result.values})
      for (const double value : *values) line.push_back(std::isnan(value) ? Json(nullptr) : Json(value));
    line.push_back(record.result.message);
    put(line);
  }
  if (!node.finish() || !place.finish()) throw OutputError(path + ": it cannot be written");
  return true;
} catch (const NodeMissing& missing) {
  std::fprintf(stderr, "note: no %s: %s\n", path.c_str(), missing.what());
  return false;
}

}  // namespace unlatch::tools
