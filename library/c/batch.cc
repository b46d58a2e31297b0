#include "library/c/batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "hil/run/run.h"

namespace unlatch::library {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kBodyNumbers = sizeof(BodyState) / sizeof(double);

}  // namespace

Batch::Batch(const std::string& path, const LoadOptions& options)
    : scenario_(hil::load_scenario(path, options.overrides)),
      catalogue_(scenario_),
      judges_((options.flags & UNLATCH_JUDGE) != 0),
      bodies_(scenario_.model.bodies.size()),
      events_(scenario_.model.events.size()),
      requirements_(scenario_.requirements.size()) {
  (void)hil::build_simulation(scenario_);  // its mistakes are those of every sample
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
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < size() && !interrupted.load(std::memory_order_relaxed); i = next++) {
      std::int64_t& status = integers_[UNLATCH_SAMPLE_STATUS][i];
      if (status == UNLATCH_INTERRUPTED) (void)run_sample(i, until, interrupted);
    }
  };
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < std::min(threads, size()); ++i) helpers.emplace_back(work);
    work();
  }
  if (!interrupted.exchange(false)) return UNLATCH_OK;
  return std::ranges::count(integers_[UNLATCH_SAMPLE_STATUS], UNLATCH_INTERRUPTED) > 0 ? UNLATCH_INTERRUPTED
                                                                                       : UNLATCH_OK;
}

bool Batch::run_sample(std::size_t sample, double until, const std::atomic<bool>& stop) {
  std::int64_t& status = integers_[UNLATCH_SAMPLE_STATUS][sample];
  try {
    std::vector<std::string> overrides = scenario_.overrides;
    overrides.insert(overrides.end(), overrides_[sample].begin(), overrides_[sample].end());
    return step_sample(sample, until, hil::load_scenario_text(scenario_.text, scenario_.file, overrides), stop);
  } catch (const hil::ScenarioError& error) {
    status = UNLATCH_ERROR_SCENARIO;
    texts_[sample] = error.what();
  } catch (const std::exception& error) {
    status = UNLATCH_ERROR_INTERNAL;
    texts_[sample] = error.what();
  }
  return true;
}

bool Batch::step_sample(std::size_t sample, double until, const hil::Scenario& scenario,
                        const std::atomic<bool>& stop) {
  if (scenario.model.events.size() != events_ || scenario.model.bodies.size() != bodies_) {
    integers_[UNLATCH_SAMPLE_STATUS][sample] = UNLATCH_ERROR_SCENARIO;
    texts_[sample] = scenario.file + ": with the overrides of this sample it has another number of bodies or events";
    return true;
  }
  const auto simulation = hil::build_simulation(scenario);
  std::unique_ptr<hil::RunAnalysis> analysis;
  if (judges_) {
    analysis = std::make_unique<hil::RunAnalysis>(scenario, *simulation, std::vector<std::int64_t>{});
    analysis->update(StepReport{});
  }
  const std::int64_t last = std::llround((until > 0 ? until : scenario.until) / scenario.dt);
  hil::LogEnd end;
  while (simulation->get_tick() < last && end.step_status == 0) {
    if (stop.load(std::memory_order_relaxed)) return false;
    const StepReport report = simulation->step();
    end.step_status = static_cast<std::int32_t>(report.status);
    end.joint = report.joint;
    if (report.status != StepStatus::kOk) break;
    if (analysis) analysis->update(report);
    for (const FiredEvent& fired : report.events) {
      double& first = first_events_[sample * events_ + static_cast<std::size_t>(fired.event)];
      if (std::isnan(first)) first = fired.time;
    }
  }
  end.tick = simulation->get_tick();
  const std::span<const BodyState> bodies = simulation->state().bodies;
  std::memcpy(&last_bodies_[sample * bodies_ * kBodyNumbers], bodies.data(), bodies.size_bytes());
  if (analysis) keep_verdicts(sample, scenario, analysis->judge());
  integers_[UNLATCH_SAMPLE_TICKS][sample] = end.tick;
  integers_[UNLATCH_SAMPLE_HASHES][sample] = simulation->calc_hash();
  integers_[UNLATCH_SAMPLE_STATUS][sample] = end.step_status == 0 ? UNLATCH_OK : UNLATCH_ERROR_FAULT;
  if (end.step_status != 0) texts_[sample] = hil::describe_fault(end, scenario.model, scenario.dt);
  return true;
}

// Requirements are known by their names: a sample's overrides may leave some out.
void Batch::keep_verdicts(std::size_t sample, const hil::Scenario& scenario,
                          const std::vector<hil::Verdict>& verdicts) {
  for (const hil::Verdict& verdict : verdicts) {
    const int at = catalogue_.find(UNLATCH_REQUIREMENT, scenario.requirements[verdict.requirement].id);
    if (at < 0 || !verdict.evaluated) continue;
    values_[sample * requirements_ + static_cast<std::size_t>(at)] = verdict.value;
    margins_[sample * requirements_ + static_cast<std::size_t>(at)] = verdict.margin;
  }
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

namespace {

constexpr auto kBatch = HandleKind::kBatch;

template <class Function>
unlatch_status with_batch(const void* handle, const Function& function) {
  return unlatch::library::with<Batch>(kBatch, handle, function);
}

}  // namespace

unlatch_status unlatch_open_batch(const char* path, const unlatch_options* options, unlatch_batch** batch) {
  if (batch == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the place for the batch");
  *batch = nullptr;
  if (path == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the path of the scenario");
  return guard([&] {
    const unlatch::library::ErrorSource source{path, ""};
    return guard(
        [&]() -> unlatch_status {
          unlatch::library::LoadOptions read;
          if (!read_options(options, read)) return UNLATCH_ERROR_ARGUMENT;
          auto made = std::make_unique<Batch>(path, read);
          void* const handle = unlatch::library::open_handle(kBatch, made.get());
          if (handle == nullptr) return fail(UNLATCH_ERROR_MEMORY, "16,384 handles are open; close some");
          (void)made.release();
          *batch = static_cast<unlatch_batch*>(handle);
          return UNLATCH_OK;
        },
        source);
  });
}

unlatch_status unlatch_add_sample(unlatch_batch* batch, const char* const* overrides, size_t count) {
  if (overrides == nullptr && count > 0) return fail(UNLATCH_ERROR_ARGUMENT, "null: the overrides");
  return with_batch(batch, [&](Batch& found) -> unlatch_status {
    std::vector<std::string> read;
    for (size_t i = 0; i < count; ++i) {
      if (overrides[i] == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: one of the overrides");
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
  if (array == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the place for the array");
  if (array->size < sizeof(unlatch_array))
    return fail(UNLATCH_ERROR_ARGUMENT, "unlatch_array::size is not set; set it to sizeof(unlatch_array)");
  return with_batch(batch, [&](Batch& found) { return found.get_array(which, *array); });
}

unlatch_status unlatch_get_sample_text(unlatch_batch* batch, size_t sample, const char** text) {
  if (text == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the place for the text");
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
  Access access(kBatch, batch);
  if (!access) return fail(access);
  delete &access.get<Batch>();
  access.close();
  return UNLATCH_OK;
}
