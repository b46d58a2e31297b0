// Many samples of one scenario, each with its overrides, run by threads with the evaluator of campaigns.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/study/evaluation/evaluation.h"
#include "library/c/catalogue.h"
#include "library/c/engine.h"
#include "library/include/unlatch.h"

namespace unlatch::library {

class Batch {
 public:
  // Loads the scenario. Throws ScenarioError.
  Batch(const std::string& path, const LoadOptions& options);

  void add(std::vector<std::string> overrides);
  // Runs every sample that has not been run yet. `threads` 0: one on each processor.
  unlatch_status run(double until, std::size_t threads, std::atomic<bool>& interrupted);

  unlatch_status get_array(std::int32_t which, unlatch_array& array) const;
  [[nodiscard]] std::size_t size() const { return overrides_.size(); }
  [[nodiscard]] const std::string& get_text(std::size_t sample) const { return texts_[sample]; }
  [[nodiscard]] const Catalogue& catalogue() const { return catalogue_; }

 private:
  std::optional<hil::SampleTask> build_task(std::size_t sample, double until);
  void run_samples(std::span<const std::size_t> samples, double until, const std::atomic<bool>& stop);
  void check_lists(const hil::Scenario& scenario) const;  // throws ScenarioError
  void keep(std::size_t sample, const hil::SampleResult& result);

  const hil::ScenarioTree tree_;  // without the samples' overrides
  const hil::SampleEvaluator evaluator_;
  const Catalogue catalogue_;
  const bool judges_;
  const std::size_t bodies_, events_, requirements_;
  std::vector<std::vector<std::string>> overrides_;    // overrides of each sample, besides those of all
  std::vector<std::string> texts_;                     // reasons of failures
  std::array<std::vector<std::int64_t>, 3> integers_;  // by UNLATCH_SAMPLE_STATUS, _TICKS, _HASHES
  std::vector<double> first_events_, values_, margins_, last_bodies_;
};

}  // namespace unlatch::library
