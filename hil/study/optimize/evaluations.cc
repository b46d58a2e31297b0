#include "hil/study/optimize/evaluations.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <mutex>
#include <span>
#include <sstream>

#include "hil/scenario/yaml/setting.h"
#include "hil/study/evaluation/side_by_side.h"

namespace unlatch::hil {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::string quote_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// Heading of the journal's columns.
std::string write_heading(const OptimizeProblem& problem) {
  std::string text = has_probabilities(problem) ? "run,status,hash,samples" : "run,status,hash";
  for (const OptimizeConstraint& constraint : problem.constraints)
    if (constraint.probability > 0) text += "," + quote_cell(constraint.name + ".part");
  const auto add = [&](const std::string& name, const std::string& unit) {
    text += "," + quote_cell(name + (unit.empty() ? "" : " [" + unit + "]"));
  };
  for (const OptimizeVariable& variable : problem.variables)
    add(variable.name, variable.is_catalogue() ? "entry" : variable.unit);
  for (const Objective& objective : problem.objectives) add(objective.text, objective.unit);
  for (const OptimizeConstraint& constraint : problem.constraints) add(constraint.name, constraint.unit);
  for (const OptimizeConstraint& constraint : problem.constraints) add(constraint.name + ".margin", constraint.unit);
  return text + "\n";
}

// Sets the margins of the constraints with a probability, after all runs.
void set_margins(const OptimizeProblem& problem, const DispersedPoint& design, OptimizeSample& sample) {
  for (std::size_t k = 0; k < problem.constraints.size(); ++k) {
    const OptimizeConstraint& constraint = problem.constraints[k];
    if (!(constraint.probability > 0)) continue;
    const double margin = calc_margin(design.sort_margins(k), sample.demand.parts[k]);
    sample.margins[k] = margin;
    sample.values[k] = design.get_limit(k) + (constraint.at_least ? margin : -margin);
  }
}

double read_cell(const std::string& text) {
  double value = kNothing;
  const std::from_chars_result end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() ? value : kNothing;
}

}  // namespace

// A batch during its computation. Finished samples join the list and the journal in their order, each once all before
// it are finished. Samples left out by `stop` or the deadline are the end of the batch.
class OptimizeEvaluations::Batch {
 public:
  Batch(OptimizeEvaluations& owner, const std::vector<OptimizePoint>& points)
      : samples(points.size()), owner_(owner), first_(owner.samples_.size()), done_(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) samples[i].point = points[i];
    for (OptimizeSample& sample : samples) sample.demand = owner.demand_;
  }

  // Marks sample i as complete. Threads may finish different ones at a time. Throws JournalError.
  void finish(std::size_t i) {
    const std::scoped_lock lock(mutex_);
    done_[i] = true;
    std::vector<OptimizeSample>& list = owner_.samples_;
    const std::size_t before = list.size();
    for (std::size_t k = before - first_; k < done_.size() && done_[k]; ++k) list.push_back(std::move(samples[k]));
    if (list.size() == before) return;
    owner_.append(before);
    if (owner_.shown_) owner_.progress_();
  }

  std::vector<OptimizeSample> samples;

 private:
  OptimizeEvaluations& owner_;
  const std::size_t first_;
  std::mutex mutex_;
  std::vector<bool> done_;
};

OptimizeEvaluations::OptimizeEvaluations(const OptimizeProblem& problem, const Options& options,
                                         const std::atomic<bool>& stop, std::function<void()> progress)
    : problem_(problem),
      options_(options),
      stop_(stop),
      progress_(std::move(progress)),
      demand_(get_first_demand(problem)),
      limit_(problem.budget.runs) {
  if (options_.journal.empty()) return;
  const std::string heading = write_heading(problem_);
  if (options_.resume) read_journal(heading);
  file_ = open(options_.journal.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (known_.empty() ? O_TRUNC : 0), 0666);
  if (file_ < 0) throw JournalError(options_.journal + ": " + std::strerror(errno));
  written_ = static_cast<std::int64_t>(heading.size());
  if (!known_.empty()) return;
  try {
    write_all(heading);
  } catch (...) {
    close(file_);
    throw;
  }
}

OptimizeEvaluations::~OptimizeEvaluations() {
  if (file_ >= 0) close(file_);
}

void OptimizeEvaluations::set_deadline(double seconds) {
  using Duration = std::chrono::steady_clock::duration;
  deadline_ = seconds > 0 ? std::chrono::steady_clock::now() +
                                std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds))
                          : std::chrono::steady_clock::time_point::max();
}

// Reads complete lines; the last one may have been cut off.
void OptimizeEvaluations::read_journal(const std::string& heading) {
  std::ifstream file(options_.journal, std::ios::binary);
  if (!file) return;
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  if (heading.starts_with(text)) return;
  if (!text.starts_with(heading))
    throw JournalError(options_.journal + ": of another problem; give another folder, or leave --resume out");
  const std::size_t n = problem_.variables.size(), m = problem_.objectives.size(), k = problem_.constraints.size();
  for (std::size_t at = heading.size(), end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    std::istringstream line(text.substr(at, end - at));
    std::vector<std::string> cells;
    for (std::string cell; std::getline(line, cell, ',');) cells.push_back(cell);
    std::vector<std::size_t> parts;  // constraints with a probability
    for (std::size_t i = 0; i < k; ++i)
      if (problem_.constraints[i].probability > 0) parts.push_back(i);
    const std::size_t ahead = parts.empty() ? 3 : 4 + parts.size();
    cells.resize(ahead + n + m + 2 * k);  // the last may be empty
    OptimizeSample sample;
    const auto status = std::find(kSampleStatusNames.begin(), kSampleStatusNames.end(), cells[1]);
    if (status == kSampleStatusNames.end()) return;
    sample.status = static_cast<SampleStatus>(status - kSampleStatusNames.begin());
    sample.hash = static_cast<std::int64_t>(std::strtoull(cells[2].c_str(), nullptr, 16));
    if (!parts.empty()) sample.demand = {static_cast<std::int64_t>(read_cell(cells[3])), std::vector<double>(k, 0.0)};
    for (std::size_t i = 0; i < parts.size(); ++i) sample.demand.parts[parts[i]] = read_cell(cells[4 + i]);
    std::size_t cell = ahead;
    for (std::size_t i = 0; i < n; ++i) sample.point.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < m; ++i) sample.objectives.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < k; ++i) sample.values.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < k; ++i) sample.margins.push_back(read_cell(cells[cell++]));
    known_.push_back({std::move(sample), static_cast<std::int64_t>(end + 1)});
  }
}

std::string OptimizeEvaluations::write_row(const OptimizeSample& sample, std::size_t number) const {
  char hash[24];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(sample.hash));
  std::string row =
      std::to_string(number) + "," + kSampleStatusNames[static_cast<std::size_t>(sample.status)] + "," + hash;
  if (has_probabilities(problem_)) row += "," + std::to_string(sample.demand.flights);
  for (const double part : sample.demand.parts)
    if (part > 0) row += "," + to_text(part);
  for (const std::vector<double>* const list : {&sample.point, &sample.objectives, &sample.values, &sample.margins})
    for (const double value : *list) row += "," + (std::isnan(value) ? std::string() : to_text(value));
  return row + "\n";
}

// Removes rows of an earlier search that this one does not need.
void OptimizeEvaluations::drop_tail() {
  if (!has_tail_) return;
  has_tail_ = false;
  if (ftruncate(file_, written_) != 0 || lseek(file_, written_, SEEK_SET) != written_)
    throw JournalError(options_.journal + ": " + std::strerror(errno));
}

void OptimizeEvaluations::finish_journal() {
  if (file_ >= 0) drop_tail();
}

void OptimizeEvaluations::write_all(const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = write(file_, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0)
      throw JournalError(options_.journal + ": " + std::strerror(errno) +
                         "; what it has is kept, --resume goes on with it");
    done += static_cast<std::size_t>(written);
  }
}

void OptimizeEvaluations::append(std::size_t first) {
  if (file_ < 0) return;
  drop_tail();
  std::string rows;
  for (std::size_t i = first; i < samples_.size(); ++i) rows += write_row(samples_[i], i + 1);
  write_all(rows);
  written_ += static_cast<std::int64_t>(rows.size());
}

void OptimizeEvaluations::run(std::span<OptimizeSample> samples) const {
  std::vector<SampleTask> tasks;
  for (const OptimizeSample& sample : samples) tasks.push_back({make_settings(problem_, sample.point)});
  const std::vector<SampleResult> results = problem_.evaluator->evaluate(tasks, stop_);
  for (std::size_t i = 0; i < samples.size(); ++i) keep(results[i], samples[i]);
}

void OptimizeEvaluations::keep(const SampleResult& result, OptimizeSample& sample) const {
  sample.status = result.status;
  sample.hash = result.hash;
  if (result.status == SampleStatus::kInterrupted) return;
  const bool done = result.status == SampleStatus::kDone;  // otherwise the results are those of a part of the run
  for (const Objective& objective : problem_.objectives) {
    double value = kNothing;
    try {
      if (done)
        value = objective.is_column ? result.values[objective.column]
                                    : calc_expression(problem_, objective, sample.point).value;
    } catch (const ExpressionError&) {  // the expression has no finite value at this point
    }
    sample.objectives.push_back(value);
  }
  for (const OptimizeConstraint& constraint : problem_.constraints) {
    const bool nominal = done && !(constraint.probability > 0);  // the other margins come from the dispersed samples
    sample.values.push_back(nominal ? result.values[constraint.value] : kNothing);
    sample.margins.push_back(nominal ? result.values[constraint.margin] : kNothing);
  }
}

void OptimizeEvaluations::compute(const std::vector<OptimizePoint>& points) {
  Batch batch(*this, points);
  if (has_probabilities(problem_)) return compute_dispersed(batch);
  run_shares(batch.samples, [&](std::size_t i) { batch.finish(i); });
}

// Calls done(i) after sample i, on the thread that has run it; interrupted samples are abandoned.
void OptimizeEvaluations::run_shares(std::span<OptimizeSample> samples, const std::function<void(std::size_t)>& done) {
  run_shares_side_by_side(samples.size(), SampleEvaluator::kSideBySide, options_.jobs, stop_,
                          [&](std::size_t first, std::size_t number) {
                            if (is_late()) return;
                            run(samples.subspan(first, number));
                            for (std::size_t i = first; i < first + number; ++i)
                              if (samples[i].status != SampleStatus::kInterrupted) done(i);
                          });
}

// Runs all samples of all designs side by side. The thread that runs the last sample of a design finishes the design.
void OptimizeEvaluations::compute_dispersed(Batch& batch) {
  const std::size_t count = batch.samples.size();
  std::vector<std::unique_ptr<DispersedPoint>> designs(count);
  run_shares(batch.samples, [&](std::size_t i) {
    OptimizeSample& sample = batch.samples[i];
    try {
      if (sample.status != SampleStatus::kInvalid)
        designs[i] = std::make_unique<DispersedPoint>(problem_, sample.point, OptimizeFlights{demand_.flights});
    } catch (const ScenarioError&) {
      sample.status = SampleStatus::kInvalid;  // its constraints have no value
    }
    if (!designs[i]) batch.finish(i);
  });
  const auto flights = static_cast<std::size_t>(demand_.flights);
  std::vector<std::atomic<std::size_t>> left(count);
  for (std::atomic<std::size_t>& one : left) one = flights;
  const auto fly = [&](std::size_t design, std::size_t first, std::size_t number) {
    if (!designs[design] || is_late() || !designs[design]->fly(static_cast<std::int64_t>(first), number, stop_)) return;
    if (left[design].fetch_sub(number) != number) return;
    set_margins(problem_, *designs[design], batch.samples[design]);
    batch.finish(design);
  };
  run_shares_side_by_side(count * flights, SampleEvaluator::kSideBySide, options_.jobs, stop_,
                          [&](std::size_t first, std::size_t number) {
                            for (std::size_t k = first, end = first + number; k < end;) {
                              const std::size_t own = std::min(end - k, flights - k % flights);  // of one design
                              fly(k / flights, k % flights, own);
                              k += own;
                            }
                          });
}

// All samples of one design; nothing: it has a mistake, or `stop` was set.
std::unique_ptr<DispersedPoint> OptimizeEvaluations::fly(const OptimizePoint& point,
                                                         const OptimizeFlights& flights) const {
  try {
    auto design = std::make_unique<DispersedPoint>(problem_, point, flights);
    run_shares_side_by_side(
        static_cast<std::size_t>(flights.samples), SampleEvaluator::kSideBySide, options_.jobs, stop_,
        [&](std::size_t first, std::size_t number) { design->fly(static_cast<std::int64_t>(first), number, stop_); });
    return stop_.load() ? nullptr : std::move(design);
  } catch (const ScenarioError&) {
    return nullptr;
  }
}

std::optional<DispersedCheck> OptimizeEvaluations::check_dispersed(const OptimizePoint& point, std::uint64_t round,
                                                                   const std::vector<double>& rooms) const {
  return problem_.campaign ? check(point, round, kMoreChecks * problem_.campaign->checks, rooms) : std::nullopt;
}

std::optional<DispersedCheck> OptimizeEvaluations::check_once(const OptimizePoint& point, std::uint64_t round) const {
  return problem_.campaign ? check(point, round, problem_.campaign->checks, {}) : std::nullopt;
}

// `most`: samples beyond which nothing that is open is pursued.
std::optional<DispersedCheck> OptimizeEvaluations::check(const OptimizePoint& point, std::uint64_t round,
                                                         std::int64_t most, const std::vector<double>& rooms) const {
  constexpr std::uint64_t kStreamsEach = 3;  // 1, 4 and 16 times as many
  constexpr std::int64_t kMore = 4, kMostChecks = 1'000'000;
  if (!has_probabilities(problem_) || problem_.campaign->checks == 0) return std::nullopt;
  DispersedCheck check;
  check.samples = problem_.campaign->checks;
  for (std::uint64_t stream = 1 + kStreamsEach * round;; ++stream, check.samples *= kMore) {
    const std::unique_ptr<const DispersedPoint> design = fly(point, {check.samples, stream});
    if (!design) return std::nullopt;
    check.unresolved = design->count_unresolved();
    check.constraints.assign(problem_.constraints.size(), {});
    bool is_open = false;
    for (std::size_t k = 0; k < problem_.constraints.size(); ++k) {
      const double probability = problem_.constraints[k].probability, allowed = 1 - probability;
      if (!(probability > 0)) continue;
      DispersedCheck::Constraint& one = check.constraints[k];
      one.failed = design->count_failures(k);
      one.bounds = {calc_clopper_pearson(one.failed, check.samples).low,
                    calc_clopper_pearson(one.failed + check.unresolved, check.samples).high};
      one.verdict = one.bounds.high <= allowed ? DispersedCheck::Verdict::kConfirmed
                    : one.bounds.low > allowed ? DispersedCheck::Verdict::kRefuted
                                               : DispersedCheck::Verdict::kOpen;
      one.margins = design->sort_margins(k);
      one.margin = describe_margin(one.margins, probability);
      const auto& interval = one.margin.interval;
      is_open = is_open || one.verdict == DispersedCheck::Verdict::kOpen ||
                (k < rooms.size() && std::isfinite(rooms[k]) && one.verdict == DispersedCheck::Verdict::kConfirmed &&
                 (!interval || (interval->low <= rooms[k] && interval->high > rooms[k])));
    }
    const bool is_most = check.samples >= most || check.samples > kMostChecks / kMore;
    if (!is_open || is_most) return check;
  }
}

std::optional<std::vector<std::vector<double>>> OptimizeEvaluations::fly_margins(const OptimizePoint& point,
                                                                                 std::int64_t flights) const {
  const std::unique_ptr<const DispersedPoint> design = fly(point, {flights, 0});
  if (!design) return std::nullopt;
  std::vector<std::vector<double>> margins(problem_.constraints.size());
  for (std::size_t k = 0; k < margins.size(); ++k)
    if (problem_.constraints[k].probability > 0) margins[k] = design->sort_margins(k);
  return margins;
}

// Takes results from the journal, which has the same points in the same order, as far as it reaches. Keeps in `points`
// the others.
void OptimizeEvaluations::take_known(std::vector<OptimizePoint>& points) {
  std::size_t taken = 0;
  for (; taken < points.size() && samples_.size() < known_.size(); ++taken) {
    const Known& known = known_[samples_.size()];
    if (known.sample.point != points[taken] || known.sample.demand != demand_) break;
    written_ = known.end;
    samples_.push_back(known.sample);
  }
  taken_ += static_cast<std::int64_t>(taken);
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(taken));
  if (taken > 0 && shown_) progress_();
}

bool OptimizeEvaluations::evaluate(const std::vector<OptimizePoint>& points, std::vector<std::int64_t>& indices) {
  indices.assign(points.size(), -1);
  std::vector<OptimizePoint> batch;
  bool complete = true;
  for (const OptimizePoint& point : points) {
    if (index_.count({demand_, point}) != 0) continue;
    if (get_runs() + static_cast<std::int64_t>(batch.size()) >= limit_ || is_late()) {
      complete = false;
      break;
    }
    index_[{demand_, point}] = get_runs() + static_cast<std::int64_t>(batch.size());
    batch.push_back(point);
  }
  take_known(batch);
  const std::size_t first = samples_.size();
  if (!batch.empty()) compute(batch);
  for (std::size_t left = samples_.size() - first; left < batch.size(); ++left) {
    index_.erase({demand_, batch[left]});
    complete = false;
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const auto found = index_.find({demand_, points[i]}); found != index_.end()) indices[i] = found->second;
  return complete;
}

}  // namespace unlatch::hil
