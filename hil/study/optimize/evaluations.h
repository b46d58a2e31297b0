// Samples of an optimisation problem, in batches, with a journal. Several threads compute a batch side by side; its
// results have one order, so that they do not depend on the number of threads. Each sample is appended to the journal,
// a CSV file, as soon as all before it are: after the end of the process at any moment, a search that begins anew with
// the same journal takes the stored results from it, in the same order, and continues.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hil/study/optimize/demand.h"
#include "hil/study/optimize/dispersion.h"

namespace unlatch::hil {

struct OptimizeSample {
  OptimizePoint point;
  SampleStatus status = SampleStatus::kDone;
  std::int64_t hash = 0;
  std::vector<double> objectives;  // SI, as defined in the file: not negated
  std::vector<double> values;      // values of the constraints, in their units; with a probability: the quantile
  std::vector<double> margins;     // below 0: not met; NaN: the run has none
  OptimizeDemand demand;           // of its search
};

// A design flown with samples that no search has seen, and the verdict on each constraint with a probability: by the
// bounds of its probability of failure (Clopper-Pearson, 95 %), which hold whatever the unresolved samples are. The
// margin is the one that the wanted part of these samples reaches, whatever part the search has asked for.
struct DispersedCheck {
  enum class Verdict { kConfirmed, kOpen, kRefuted };
  struct Constraint {
    std::int64_t failed = 0;
    Interval bounds;
    Verdict verdict = Verdict::kConfirmed;
    std::vector<double> margins{};  // of these samples, from the least up
    DispersedMargin margin{};
  };
  std::int64_t samples = 0, unresolved = 0;
  std::vector<Constraint> constraints;  // of every constraint; those without a probability are confirmed

  [[nodiscard]] bool has(Verdict verdict) const {
    return std::ranges::any_of(constraints, [verdict](const Constraint& one) { return one.verdict == verdict; });
  }
};

// Error of a journal that cannot be written, or belongs to another problem.
class JournalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class OptimizeEvaluations {
 public:
  struct Options {
    std::string journal;  // file; "": none
    bool resume = false;  // use the results in the journal; otherwise it begins anew
    int jobs = 1;
  };

  // Keeps references to all arguments. Another thread may set `stop`. `progress` is called when there are more samples,
  // by one thread at a time.
  OptimizeEvaluations(
      const OptimizeProblem& problem, const Options& options, const std::atomic<bool>& stop,
      std::function<void()> progress = [] {});
  ~OptimizeEvaluations();
  OptimizeEvaluations(const OptimizeEvaluations&) = delete;
  OptimizeEvaluations& operator=(const OptimizeEvaluations&) = delete;

  // Evaluates points; returns indices into get_samples(), one for each; a repeated point costs nothing. False: the
  // budget is used up, or `stop` was set, and some are missing (-1); earlier results are kept. Throws JournalError.
  bool evaluate(const std::vector<OptimizePoint>& points, std::vector<std::int64_t>& indices);

  // Flies a design with fresh samples, others for each `round`. While some verdict is open, or it is open whether a
  // margin is above that of `rooms`, up to kMoreChecks times more of them, each time four times as many new ones.
  // `rooms`: by constraint; infinite ones are never open. Nothing: no constraint has a probability, the design has a
  // mistake, or `stop` was set.
  [[nodiscard]] std::optional<DispersedCheck> check_dispersed(const OptimizePoint& point, std::uint64_t round,
                                                              const std::vector<double>& rooms) const;
  // Likewise with the campaign's `checks` fresh samples, whatever the verdict: for the points of a front, each with a
  // round of its own.
  [[nodiscard]] std::optional<DispersedCheck> check_once(const OptimizePoint& point, std::uint64_t round) const;
  static constexpr std::int64_t kMoreChecks = 16;
  // Margins of each constraint with a probability, from the least up, by the first samples of the search, so many.
  // Nothing: the design has a mistake, or `stop` was set.
  [[nodiscard]] std::optional<std::vector<std::vector<double>>> fly_margins(const OptimizePoint& point,
                                                                            std::int64_t flights) const;

  // Sets what is asked of the designs to come; those with another demand are other samples.
  void set_demand(OptimizeDemand demand) { demand_ = std::move(demand); }
  [[nodiscard]] const OptimizeDemand& get_demand() const { return demand_; }

  // Removes from the journal rows that this search did not use. Call it only if the search was not stopped.
  void finish_journal();

  // Ends the calls of `progress`: the search has ended, the runs around its result follow.
  void end_progress() { shown_ = false; }

  // Sets the number of runs that the next batches may still make in all.
  void set_limit(std::int64_t runs) { limit_ = runs; }
  void set_deadline(double seconds);  // s of wall time from now; 0: none

  [[nodiscard]] const std::vector<OptimizeSample>& get_samples() const { return samples_; }
  [[nodiscard]] std::int64_t get_runs() const { return static_cast<std::int64_t>(samples_.size()); }
  [[nodiscard]] std::int64_t get_taken() const { return taken_; }  // samples taken from the journal
  [[nodiscard]] bool is_late() const { return std::chrono::steady_clock::now() > deadline_; }
  [[nodiscard]] bool was_stopped() const { return stop_; }

 private:
  struct Known {  // A row of the journal.
    OptimizeSample sample;
    std::int64_t end = 0;  // end of its row in the file
  };
  class Batch;

  [[nodiscard]] std::optional<DispersedCheck> check(const OptimizePoint& point, std::uint64_t round, std::int64_t most,
                                                    const std::vector<double>& rooms) const;
  [[nodiscard]] std::unique_ptr<DispersedPoint> fly(const OptimizePoint& point, const OptimizeFlights& flights) const;
  void run(std::span<OptimizeSample> samples) const;
  void keep(const SampleResult& result, OptimizeSample& sample) const;
  void run_shares(std::span<OptimizeSample> samples, const std::function<void(std::size_t)>& done);
  void read_journal(const std::string& heading);
  void drop_tail();
  void write_all(const std::string& text);
  void append(std::size_t first);
  [[nodiscard]] std::string write_row(const OptimizeSample& sample, std::size_t number) const;
  void take_known(std::vector<OptimizePoint>& points);
  void compute(const std::vector<OptimizePoint>& points);
  void compute_dispersed(Batch& batch);

  const OptimizeProblem& problem_;
  const Options options_;
  const std::atomic<bool>& stop_;
  const std::function<void()> progress_;
  std::vector<OptimizeSample> samples_;
  std::vector<Known> known_;
  std::map<std::pair<OptimizeDemand, OptimizePoint>, std::int64_t> index_;
  OptimizeDemand demand_;
  std::int64_t limit_ = 0, taken_ = 0;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  bool shown_ = true;
  int file_ = -1;
  std::int64_t written_ = 0;  // end of the last row of samples_ in the file; rows of an earlier search may follow
  bool has_tail_ = true;
};

}  // namespace unlatch::hil
