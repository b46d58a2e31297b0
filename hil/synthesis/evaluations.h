// Samples of a problem of synthesis, in batches, with a journal. A batch is computed side by side by several threads;
// its results have one order, so that nothing depends on their number. Each sample is appended to the journal, a CSV
// file, as soon as all before it are: after the end of the process at any moment, a search that begins anew with the
// same journal takes from it what it has, in the same order, and goes on.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/synthesis/dispersion.h"

namespace unlatch::hil {

struct DesignSample {
  DesignPoint point;
  SampleStatus status = SampleStatus::kDone;
  std::int64_t hash = 0;
  std::vector<double> objectives;  // SI, as the file has them: not negated
  std::vector<double> values;      // of the constraints, in their units; with a probability: the quantile
  std::vector<double> margins;     // below 0: not met; NaN: the run gives none
};

// The journal cannot be written, or is another problem's.
class JournalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class DesignEvaluations {
 public:
  struct Options {
    std::string journal;  // file; "": none
    bool resume = false;  // take what the journal has; else it begins anew
    int jobs = 1;
  };

  // All are referred to. Another thread may set `stop`. `progress` is called when there are more samples, by one thread
  // at a time.
  DesignEvaluations(
      const DesignProblem& problem, const Options& options, const std::atomic<bool>& stop,
      std::function<void()> progress = [] {});
  ~DesignEvaluations();
  DesignEvaluations(const DesignEvaluations&) = delete;
  DesignEvaluations& operator=(const DesignEvaluations&) = delete;

  // Indices into get_samples(), one for each point; a point that was there before costs nothing. False: the budget is
  // spent, or `stop` was set, and some are missing (-1); what was done before is kept. Throws JournalError.
  bool evaluate(const std::vector<DesignPoint>& points, std::vector<std::int64_t>& indices);

  // The samples that verify a result, under the campaign's dispersions: failures of each constraint with a
  // probability, 0 of the others. Nothing: there are none, the design has a mistake, or `stop` was set.
  [[nodiscard]] std::optional<std::vector<std::int64_t>> check_dispersed(const DesignPoint& point) const;

  // Of the journal only what this search has asked for stays. To be called when it was not stopped.
  void finish_journal();

  // From now on `progress` is not called: the search has ended, the runs around its result follow.
  void end_progress() { shown_ = false; }

  // Runs that the next batches may still make in all.
  void set_limit(std::int64_t runs) { limit_ = runs; }
  void set_deadline(double seconds);  // of wall time from now; 0: none

  [[nodiscard]] const std::vector<DesignSample>& get_samples() const { return samples_; }
  [[nodiscard]] std::int64_t get_runs() const { return static_cast<std::int64_t>(samples_.size()); }
  [[nodiscard]] std::int64_t get_taken() const { return taken_; }  // from the journal
  [[nodiscard]] bool is_late() const { return std::chrono::steady_clock::now() > deadline_; }
  [[nodiscard]] bool was_stopped() const { return stop_; }

 private:
  struct Known {  // of the journal
    DesignSample sample;
    std::int64_t end = 0;  // of its row in the file
  };
  class Batch;

  void run(std::span<DesignSample> samples) const;
  void keep(const SampleResult& result, DesignSample& sample) const;
  void run_shares(std::span<DesignSample> samples, const std::function<void(std::size_t)>& done);
  void read_journal(const std::string& heading);
  void drop_tail();
  void write_all(const std::string& text);
  void append(std::size_t first);
  [[nodiscard]] std::string write_row(const DesignSample& sample, std::size_t number) const;
  void take_known(std::vector<DesignPoint>& points);
  void compute(const std::vector<DesignPoint>& points);
  void compute_dispersed(Batch& batch);

  const DesignProblem& problem_;
  const Options options_;
  const std::atomic<bool>& stop_;
  const std::function<void()> progress_;
  std::vector<DesignSample> samples_;
  std::vector<Known> known_;
  std::map<DesignPoint, std::int64_t> index_;
  std::int64_t limit_ = 0, taken_ = 0;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  bool shown_ = true;
  int file_ = -1;
  std::int64_t written_ = 0;  // end of the last row of samples_ in the file; an earlier search's may follow
  bool has_tail_ = true;
};

}  // namespace unlatch::hil
