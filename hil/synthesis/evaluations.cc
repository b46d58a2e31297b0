#include "hil/synthesis/evaluations.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include "hil/language/setting.h"

namespace unlatch::hil {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::string quote_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// The columns.
std::string write_heading(const DesignProblem& problem) {
  std::string text = "run,status,hash";
  const auto add = [&](const std::string& name, const std::string& unit) {
    text += "," + quote_cell(name + (unit.empty() ? "" : " [" + unit + "]"));
  };
  for (const DesignVariable& variable : problem.variables)
    add(variable.name, variable.is_catalogue() ? "entry" : variable.unit);
  for (const Objective& objective : problem.objectives) add(objective.text, objective.unit);
  for (const DesignConstraint& constraint : problem.constraints) add(constraint.name, constraint.unit);
  for (const DesignConstraint& constraint : problem.constraints) add(constraint.name + ".margin", constraint.unit);
  return text + "\n";
}

double read_cell(const std::string& text) {
  double value = kNothing;
  const std::from_chars_result end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() ? value : kNothing;
}

}  // namespace

DesignEvaluations::DesignEvaluations(const DesignProblem& problem, const Options& options,
                                     const std::atomic<bool>& stop, std::function<void()> progress)
    : problem_(problem), options_(options), stop_(stop), progress_(std::move(progress)), limit_(problem.budget.runs) {
  if (options_.journal.empty()) return;
  if (options_.resume) read_journal();
  const int mode = options_.resume ? 0 : O_TRUNC;
  file_ = open(options_.journal.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | mode, 0666);
  if (file_ < 0) throw JournalError(options_.journal + ": " + std::strerror(errno));
  // From the journal only what this search asks for stays: a row is written again when it is asked for.
  const std::string heading = write_heading(problem_);
  if (ftruncate(file_, 0) != 0 || write(file_, heading.data(), heading.size()) != static_cast<ssize_t>(heading.size()))
    throw JournalError(options_.journal + ": " + std::strerror(errno));
}

DesignEvaluations::~DesignEvaluations() {
  if (file_ >= 0) close(file_);
}

void DesignEvaluations::set_deadline(double seconds) {
  using Duration = std::chrono::steady_clock::duration;
  deadline_ = seconds > 0 ? std::chrono::steady_clock::now() +
                                std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds))
                          : std::chrono::steady_clock::time_point::max();
}

// Whole lines; the last one may have been cut off.
void DesignEvaluations::read_journal() {
  std::ifstream file(options_.journal, std::ios::binary);
  if (!file) return;
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::string heading = write_heading(problem_);
  if (text.empty()) return;
  if (text.compare(0, heading.size(), heading) != 0)
    throw JournalError(options_.journal + ": of another problem; give another folder, or leave --resume out");
  const std::size_t n = problem_.variables.size(), m = problem_.objectives.size(), k = problem_.constraints.size();
  for (std::size_t at = heading.size(), end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    std::istringstream line(text.substr(at, end - at));
    std::vector<std::string> cells;
    for (std::string cell; std::getline(line, cell, ',');) cells.push_back(cell);
    cells.resize(3 + n + m + 2 * k);  // the last may be empty
    DesignSample sample;
    const auto status = std::find(kSampleStatusNames.begin(), kSampleStatusNames.end(), cells[1]);
    if (status == kSampleStatusNames.end()) return;
    sample.status = static_cast<SampleStatus>(status - kSampleStatusNames.begin());
    sample.hash = static_cast<std::int64_t>(std::strtoull(cells[2].c_str(), nullptr, 16));
    std::size_t cell = 3;
    for (std::size_t i = 0; i < n; ++i) sample.point.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < m; ++i) sample.objectives.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < k; ++i) sample.values.push_back(read_cell(cells[cell++]));
    for (std::size_t i = 0; i < k; ++i) sample.margins.push_back(read_cell(cells[cell++]));
    known_.push_back(std::move(sample));
  }
}

std::string DesignEvaluations::write_row(const DesignSample& sample, std::size_t number) const {
  char hash[24];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(sample.hash));
  std::string row =
      std::to_string(number) + "," + kSampleStatusNames[static_cast<std::size_t>(sample.status)] + "," + hash;
  for (const std::vector<double>* const list : {&sample.point, &sample.objectives, &sample.values, &sample.margins})
    for (const double value : *list) row += "," + (std::isnan(value) ? std::string() : to_text(value));
  return row + "\n";
}

void DesignEvaluations::append(std::size_t first) {
  if (file_ < 0) return;
  std::string rows;
  for (std::size_t i = first; i < samples_.size(); ++i) rows += write_row(samples_[i], i + 1);
  for (std::size_t done = 0; done < rows.size();) {
    const ssize_t written = write(file_, rows.data() + done, rows.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw JournalError(options_.journal + ": " + std::strerror(errno));
    done += static_cast<std::size_t>(written);
  }
}

DesignSample DesignEvaluations::run(const DesignPoint& point) const {
  DesignSample sample;
  sample.point = point;
  const SampleResult result = problem_.evaluator->evaluate(make_settings(problem_, point), stop_);
  sample.status = result.status;
  sample.hash = result.hash;
  if (result.status == SampleStatus::kInterrupted) return sample;
  const bool done = result.status == SampleStatus::kDone;  // else the results are those of a part of the flight
  for (const Objective& objective : problem_.objectives) {
    double value = kNothing;
    try {
      if (done)
        value =
            objective.is_column ? result.values[objective.column] : calc_expression(problem_, objective, point).value;
    } catch (const ExpressionError&) {  // at this point it has no finite value
    }
    sample.objectives.push_back(value);
  }
  for (const DesignConstraint& constraint : problem_.constraints) {
    const bool nominal = done && !(constraint.probability > 0);  // the others come from the dispersed samples
    sample.values.push_back(nominal ? result.values[constraint.value] : kNothing);
    sample.margins.push_back(nominal ? result.values[constraint.margin] : kNothing);
  }
  return sample;
}

// Threads take the next one that nobody has; each writes its own. `stop` leaves the rest.
void DesignEvaluations::for_each(std::size_t count, const std::function<void(std::size_t)>& work) const {
  std::atomic<std::size_t> next{0};
  const auto take = [&] {
    for (std::size_t i = 0; (i = next.fetch_add(1)) < count && !stop_.load();) work(i);
  };
  std::vector<std::jthread> threads;
  const std::size_t jobs = std::min(count, static_cast<std::size_t>(std::max(1, options_.jobs)));
  for (std::size_t i = 1; i < jobs; ++i) threads.emplace_back(take);
  take();
}

// False: `stop` was set.
bool DesignEvaluations::compute(std::vector<DesignSample>& batch) {
  const bool dispersed = has_probabilities(problem_);
  std::vector<std::unique_ptr<DispersedDesign>> designs(batch.size());
  for_each(batch.size(), [&](std::size_t i) {
    batch[i] = run(batch[i].point);
    if (!dispersed || batch[i].status == SampleStatus::kInvalid) return;
    try {
      designs[i] = std::make_unique<DispersedDesign>(problem_, batch[i].point, false);
    } catch (const ScenarioError&) {
      batch[i].status = SampleStatus::kInvalid;  // its constraints have no value
    }
  });
  if (!dispersed || stop_.load()) return !stop_.load();
  const auto samples = static_cast<std::size_t>(problem_.campaign->samples);
  for_each(batch.size() * samples, [&](std::size_t i) {
    if (designs[i / samples]) designs[i / samples]->fly(static_cast<std::int64_t>(i % samples), stop_);
  });
  if (stop_.load()) return false;
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (std::size_t k = 0; k < problem_.constraints.size(); ++k) {
      const DesignConstraint& constraint = problem_.constraints[k];
      if (!(constraint.probability > 0) || !designs[i]) continue;
      const double margin = designs[i]->calc_margin(k);
      batch[i].margins[k] = margin;
      batch[i].values[k] = constraint.at_least ? constraint.limit + margin : constraint.limit - margin;
    }
  return true;
}

std::optional<std::vector<std::int64_t>> DesignEvaluations::check_dispersed(const DesignPoint& point) const {
  if (!has_probabilities(problem_) || problem_.campaign->checks == 0) return std::nullopt;
  try {
    DispersedDesign design(problem_, point, true);
    for_each(static_cast<std::size_t>(design.count_samples()),
             [&](std::size_t i) { design.fly(static_cast<std::int64_t>(i), stop_); });
    if (stop_.load()) return std::nullopt;
    std::vector<std::int64_t> failures;
    for (std::size_t k = 0; k < problem_.constraints.size(); ++k) failures.push_back(design.count_failures(k));
    return failures;
  } catch (const ScenarioError&) {
    return std::nullopt;
  }
}

bool DesignEvaluations::evaluate(const std::vector<DesignPoint>& points, std::vector<std::int64_t>& indices) {
  indices.assign(points.size(), -1);
  std::vector<DesignSample> batch;
  bool complete = true;
  for (const DesignPoint& point : points) {
    if (index_.count(point) != 0) continue;
    if (get_runs() + static_cast<std::int64_t>(batch.size()) >= limit_ || is_late()) {
      complete = false;
      break;
    }
    index_[point] = get_runs() + static_cast<std::int64_t>(batch.size());
    batch.emplace_back().point = point;
  }
  // The journal has the same batches in the same order, as far as it goes.
  const std::size_t first = samples_.size();
  std::size_t taken = 0;
  while (taken < batch.size() && first + taken < known_.size() && known_[first + taken].point == batch[taken].point) {
    batch[taken] = known_[first + taken];
    ++taken;
  }
  taken_ += static_cast<std::int64_t>(taken);
  std::vector<DesignSample> rest(batch.begin() + static_cast<std::ptrdiff_t>(taken), batch.end());
  if (!rest.empty() && !compute(rest)) {
    for (const DesignSample& sample : batch) index_.erase(sample.point);
    complete = false;
    batch.clear();
  } else {
    std::move(rest.begin(), rest.end(), batch.begin() + static_cast<std::ptrdiff_t>(taken));
  }
  for (DesignSample& sample : batch) samples_.push_back(std::move(sample));
  append(first);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const auto found = index_.find(points[i]); found != index_.end()) indices[i] = found->second;
  if (!batch.empty() && shown_) progress_();
  return complete;
}

}  // namespace unlatch::hil
