#include "library/c/batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <utility>

#include "hil/run/run.h"
#include "library/c/calls.h"

namespace unlatch::library {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBodyNumbers = sizeof(BodyState) / sizeof(double);

}  // namespace

Batch::Batch(const std::string& path, const LoadOptions& options)
    : tree_(path, options.overrides),
      evaluator_(tree_),
      catalogue_(tree_.get_nominal()),
      judges_((options.flags & UNLATCH_JUDGE) != 0),
      bodies_(tree_.get_nominal().model.bodies.size()),
      events_(tree_.get_nominal().model.events.size()),
      requirements_(tree_.get_nominal().requirements.size()) {
  (void)hil::build_simulation(tree_.get_nominal());  // its mistakes are those of every sample
}

void Batch::add(std::vector<std::string> overrides) {
  overrides_.push_back(std::move(overrides));
  const std::size_t count = overrides_.size();
  texts_.resize(count);
  integers_[UNLATCH_SAMPLE_STATUS].resize(count, UNLATCH_INTERRUPTED);
  integers_[UNLATCH_SAMPLE_TICKS].resize(count, 0);
  integers_[UNLATCH_SAMPLE_HASHES].resize(count, 0);
  first_events_.resize(count * events_, kNever);
  values_.resize(count * requirements_, kNever);
  margins_.resize(count * requirements_, kNever);
  last_bodies_.resize(count * bodies_ * kBodyNumbers, kNever);
}

unlatch_status Batch::run(double until, std::size_t threads, std::atomic<bool>& interrupted) {
  if (!(until >= 0) || std::isinf(until))
    return fail(UNLATCH_ERROR_RANGE, "the end of the run is no time from 0 on, s");
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  // Each thread takes as many samples as it runs side by side, or its share if that is less.
  const std::size_t share = std::clamp<std::size_t>(size() / threads, 1, hil::SampleEvaluator::kSideBySide);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    const ClassicLocale locale;  // of each helper thread
    for (std::size_t i = next.fetch_add(share); i < size() && !interrupted.load(std::memory_order_relaxed);
         i = next.fetch_add(share)) {
      std::vector<std::size_t> samples;
      for (std::size_t k = i; k < std::min(i + share, size()); ++k)
        if (integers_[UNLATCH_SAMPLE_STATUS][k] == UNLATCH_INTERRUPTED) samples.push_back(k);
      run_samples(samples, until, interrupted);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < std::min(threads, size()); ++i) helpers.emplace_back(work);
    work();
  }
  if (!interrupted.exchange(false)) return UNLATCH_OK;
  return std::ranges::count(integers_[UNLATCH_SAMPLE_STATUS], UNLATCH_INTERRUPTED) > 0 ? UNLATCH_INTERRUPTED
                                                                                       : UNLATCH_OK;
}

// Stores a result. Columns are found by name: a sample's overrides may disable some requirements.
void Batch::keep(std::size_t sample, const hil::SampleResult& result) {
  using enum hil::SampleStatus;
  constexpr auto get_status = [](hil::SampleStatus status) {
    switch (status) {
      case kDone:
        return UNLATCH_OK;
      case kFaulted:
        return UNLATCH_ERROR_FAULT;
      case kInvalid:
        return UNLATCH_ERROR_SCENARIO;
      case kUnresolved:
        return UNLATCH_UNRESOLVED;
      default:
        return UNLATCH_INTERRUPTED;
    }
  };
  integers_[UNLATCH_SAMPLE_STATUS][sample] = get_status(result.status);
  if (result.status == kInterrupted) {
    std::fill_n(&last_bodies_[sample * bodies_ * kBodyNumbers], bodies_ * kBodyNumbers, kNever);
    return;
  }
  texts_[sample] = result.message;
  integers_[UNLATCH_SAMPLE_TICKS][sample] = result.ticks;
  integers_[UNLATCH_SAMPLE_HASHES][sample] = result.hash;
  if (result.values.empty()) return;
  for (std::size_t i = 0; i < requirements_; ++i) {
    const std::string id = catalogue_.get(UNLATCH_REQUIREMENT)[i].name;
    values_[sample * requirements_ + i] = result.values[*evaluator_.find(id)];
    margins_[sample * requirements_ + i] = result.values[*evaluator_.find(id + ".margin")];
  }
}

std::optional<hil::SampleTask> Batch::build_task(std::size_t sample, double until) {
  double* const first_events = &first_events_[sample * events_];
  std::fill_n(first_events, events_, kNever);  // values of an interrupted run
  hil::SampleTask task;
  task.run.until = until;
  task.run.judges = judges_;
  task.run.look = [this, first_events](const hil::Scenario& scenario, const hil::Simulation& simulation,
                                       const StepReport& report) {
    if (simulation.get_tick() == 0) check_lists(scenario);
    for (const FiredEvent& fired : report.events) {
      double& first = first_events[static_cast<std::size_t>(fired.event)];
      if (std::isnan(first)) first = fired.time;
    }
  };
  task.run.end = [this, sample](const hil::Simulation& simulation) {
    const std::span<const BodyState> bodies = simulation.state().bodies;
    std::memcpy(&last_bodies_[sample * bodies_ * kBodyNumbers], bodies.data(), bodies.size_bytes());
  };
  try {
    for (const std::string& text : overrides_[sample]) task.settings.push_back(hil::parse_setting(text));
  } catch (const hil::YamlError& error) {
    integers_[UNLATCH_SAMPLE_STATUS][sample] = UNLATCH_ERROR_SCENARIO;
    texts_[sample] = std::string("an override: ") + error.what() + "; " + error.mend;
    return std::nullopt;
  } catch (const std::exception& error) {
    integers_[UNLATCH_SAMPLE_STATUS][sample] = UNLATCH_ERROR_INTERNAL;
    texts_[sample] = error.what();
    return std::nullopt;
  }
  return task;
}

void Batch::run_samples(std::span<const std::size_t> samples, double until, const std::atomic<bool>& stop) {
  std::vector<std::size_t> numbers;
  std::vector<hil::SampleTask> tasks;
  for (const std::size_t sample : samples)
    if (std::optional<hil::SampleTask> task = build_task(sample, until)) {
      numbers.push_back(sample);
      tasks.push_back(*std::move(task));
    }
  try {
    const std::vector<hil::SampleResult> results = evaluator_.evaluate(tasks, stop);
    for (std::size_t i = 0; i < numbers.size(); ++i) keep(numbers[i], results[i]);
  } catch (const std::exception& error) {
    for (const std::size_t sample : numbers) {
      integers_[UNLATCH_SAMPLE_STATUS][sample] = UNLATCH_ERROR_INTERNAL;
      texts_[sample] = error.what();
    }
  }
}

// Checks that every sample has the bodies and events of the scenario: results are tables.
void Batch::check_lists(const hil::Scenario& scenario) const {
  if (scenario.model.events.size() == events_ && scenario.model.bodies.size() == bodies_) return;
  throw hil::ScenarioError({{scenario.file,
                             {},
                             "",
                             "with the overrides of this sample it has another number of bodies or events",
                             "a batch has one list of them; add what is missing, or run it in a batch of its own"}});
}

unlatch_status Batch::get_array(std::int32_t which, unlatch_array& array) const {
  const auto show = [&](const void* data, std::size_t columns, std::int32_t type) {
    const auto row = static_cast<std::ptrdiff_t>(columns * sizeof(double));
    array = {array.size, data, type, 0, size(), columns, row, sizeof(double)};
    return UNLATCH_OK;
  };
  if (!judges_ && (which == UNLATCH_SAMPLE_VALUES || which == UNLATCH_SAMPLE_MARGINS))
    return fail(UNLATCH_ERROR_ORDER, "verdicts need UNLATCH_JUDGE in the options' flags");
  switch (which) {
    case UNLATCH_SAMPLE_STATUS:
    case UNLATCH_SAMPLE_TICKS:
    case UNLATCH_SAMPLE_HASHES:
      return show(integers_[static_cast<std::size_t>(which)].data(), 1, UNLATCH_INT64);
    case UNLATCH_SAMPLE_EVENTS:
      return show(first_events_.data(), events_, UNLATCH_DOUBLE);
    case UNLATCH_SAMPLE_VALUES:
      return show(values_.data(), requirements_, UNLATCH_DOUBLE);
    case UNLATCH_SAMPLE_MARGINS:
      return show(margins_.data(), requirements_, UNLATCH_DOUBLE);
    case UNLATCH_SAMPLE_BODIES:
      return show(last_bodies_.data(), bodies_ * kBodyNumbers, UNLATCH_DOUBLE);
    default:
      return fail(UNLATCH_ERROR_ARGUMENT, "an array that is unknown: " + std::to_string(which));
  }
}

}  // namespace unlatch::library

// --- The C library's functions on batches ---------------------------------------------------------------------------

using unlatch::library::Access;
using unlatch::library::Batch;
using unlatch::library::fail;
using unlatch::library::guard;
using unlatch::library::HandleKind;
using unlatch::library::LoadOptions;
using unlatch::library::make_handle;
using unlatch::library::refuse_null;

namespace {

constexpr auto kBatch = HandleKind::kBatch;

template <class Function>
unlatch_status with_batch(const void* handle, const Function& function) {
  return unlatch::library::with<Batch>(kBatch, handle, function);
}

}  // namespace

unlatch_status unlatch_open_batch(const char* path, const unlatch_options* options, unlatch_batch** batch) {
  if (batch == nullptr) return refuse_null("the place for the batch");
  *batch = nullptr;
  if (path == nullptr) return refuse_null("the path of the scenario");
  return guard([&] {
    return make_handle(kBatch, {path, ""}, options, batch,
                       [&](const LoadOptions& read) { return std::make_unique<Batch>(path, read); });
  });
}

unlatch_status unlatch_add_sample(unlatch_batch* batch, const char* const* overrides, size_t count) {
  if (overrides == nullptr && count > 0) return refuse_null("the overrides");
  return with_batch(batch, [&](Batch& found) -> unlatch_status {
    std::vector<std::string> read;
    for (size_t i = 0; i < count; ++i) {
      if (overrides[i] == nullptr) return refuse_null("one of the overrides");
      read.emplace_back(overrides[i]);
    }
    found.add(std::move(read));
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_run_batch(unlatch_batch* batch, double until, size_t threads) {
  const Access access(kBatch, batch);
  if (!access) return fail(access);
  return guard([&] { return access.get<Batch>().run(until, threads, access.interrupted()); });
}

unlatch_status unlatch_get_batch_array(unlatch_batch* batch, int32_t which, unlatch_array* array) {
  if (array == nullptr) return refuse_null("the place for the array");
  if (array->size < sizeof(unlatch_array))
    return fail(UNLATCH_ERROR_ARGUMENT, "unlatch_array::size is not set; set it to sizeof(unlatch_array)");
  return with_batch(batch, [&](Batch& found) { return found.get_array(which, *array); });
}

unlatch_status unlatch_get_sample_text(unlatch_batch* batch, size_t sample, const char** text) {
  if (text == nullptr) return refuse_null("the place for the text");
  return with_batch(batch, [&](Batch& found) -> unlatch_status {
    if (sample >= found.size())
      return fail(UNLATCH_ERROR_RANGE, "sample " + std::to_string(sample) + " of " + std::to_string(found.size()));
    *text = found.get_text(sample).c_str();
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_count_in_batch(unlatch_batch* batch, int32_t kind, size_t* count) {
  return with_batch(batch, [&](Batch& found) { return found.catalogue().count(kind, count); });
}

unlatch_status unlatch_describe_in_batch(unlatch_batch* batch, int32_t kind, size_t index, unlatch_item* item) {
  return with_batch(batch, [&](Batch& found) { return found.catalogue().describe(kind, index, item); });
}

unlatch_status unlatch_close_batch(unlatch_batch* batch) {
  return unlatch::library::close_handle<Batch>(kBatch, batch);
}
