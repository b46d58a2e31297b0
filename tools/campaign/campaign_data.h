// A campaign's folder: `manifest.json` (all that decides the samples, and what the columns are), `results.bin` (a
// record for each sample), and what is made of them at the end: `samples.csv`, `samples.parquet`, `summary.json`.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/study/campaign/samples/rare_failure.h"
#include "hil/study/campaign/samples/result_table.h"
#include "hil/study/sampling/sampling.h"

namespace unlatch::tools {

using Json = nlohmann::ordered_json;

// Manifest of the campaign for its folder: texts, versions, columns, requirements. `set`: overrides of the command
// line, which a sample that runs again needs too.
Json build_manifest(const hil::Campaign& campaign, const hil::SampleEvaluator& evaluator,
                    const std::vector<std::string>& set);

std::string get_manifest_path(const std::string& folder);
std::string get_results_path(const std::string& folder);

// A folder read back, or the first rows of it. Rows are in the order of the samples, each once; their numbers stay in
// the folder, see hil/study/campaign/samples/result_table.h.
struct CampaignData {
  Json manifest;
  std::shared_ptr<const hil::ResultTable> table;
  std::size_t rows = 0;  // of the table
  // The places of the rows in the table; nothing: the first ones.
  std::shared_ptr<const std::vector<std::size_t>> places{};

  [[nodiscard]] std::size_t get_place(std::size_t row) const { return places ? (*places)[row] : row; }
  [[nodiscard]] std::int64_t get_sample(std::size_t row) const { return table->get_sample(get_place(row)); }
  [[nodiscard]] hil::SampleStatus get_status(std::size_t row) const { return table->get_status(get_place(row)); }

  // The failure that subset sampling looks for, and the margin of each row. Nothing: other sampling.
  [[nodiscard]] std::optional<hil::RareFailure> get_failure() const;
  [[nodiscard]] std::vector<double> read_failure_margins(const hil::RareFailure& failure) const;
  // The rows whose inputs are distributed as the file says, for statistics: all, but of subset sampling those of the
  // first level.
  [[nodiscard]] CampaignData get_drawn() const;
  [[nodiscard]] hil::Sampling get_sampling() const;
  // The rows that are draws from the distributions, for probabilities, quantiles and tolerance limits: of saltelli the
  // first two of each block. Nothing: the samples are chosen points (hil/study/sampling/sampling.h).
  [[nodiscard]] std::optional<CampaignData> get_population() const;

  [[nodiscard]] std::vector<double> read_input(std::size_t input) const;
  [[nodiscard]] std::vector<double> read_column(std::size_t column) const;
  // The same without the values of samples that faulted or are unresolved, which are no results: NaN.
  [[nodiscard]] std::vector<double> read_results(std::size_t column) const;
  [[nodiscard]] std::size_t find_column(const std::string& name) const;  // throws std::out_of_range
  // Columns before the points of curves, which are the last ones.
  [[nodiscard]] std::size_t count_plain_columns() const;
};

// Throws hil::ResultError: no such folder, or not a campaign's.
Json read_manifest(const std::string& folder);
CampaignData read_campaign(const std::string& folder);
// The manifest and all records of several folders of one campaign into a new folder. Throws hil::ResultError.
void merge_campaigns(const std::vector<std::string>& folders, const std::string& to);

// Throws OutputError.
void write_csv(const CampaignData& data, const std::string& path);
// False, and a note on standard error, if Node.js is missing.
bool write_parquet(const CampaignData& data, const std::string& path);

}  // namespace unlatch::tools
