// Functions of the C library on simulations: arguments are checked here; the engine does the work.
#include <cmath>

#include "hil/run/replay.h"
#include "library/c/calls.h"
#include "library/c/engine.h"

using unlatch::library::Access;
using unlatch::library::Engine;
using unlatch::library::ErrorSource;
using unlatch::library::fail;
using unlatch::library::guard;
using unlatch::library::HandleKind;
using unlatch::library::LoadOptions;
using unlatch::library::make_handle;
using unlatch::library::refuse_null;

namespace {

constexpr auto kSimulation = HandleKind::kSimulation;

template <class Function>
unlatch_status with_engine(const void* handle, const Function& function) {
  return unlatch::library::with<Engine>(kSimulation, handle, function);
}

}  // namespace

unlatch_status unlatch_load(const char* path, const unlatch_options* options, unlatch_simulation** simulation) {
  if (simulation == nullptr) return refuse_null("the place for the simulation");
  *simulation = nullptr;
  if (path == nullptr) return refuse_null("the path of the scenario");
  return guard([&] {
    return make_handle(kSimulation, {path, ""}, options, simulation, [&](const LoadOptions& read) {
      return std::make_unique<Engine>(unlatch::hil::load_scenario(path, read.overrides), read);
    });
  });
}

unlatch_status unlatch_load_text(const char* text, size_t length, const char* name, const unlatch_options* options,
                                 unlatch_simulation** simulation) {
  if (simulation == nullptr) return refuse_null("the place for the simulation");
  *simulation = nullptr;
  if (text == nullptr) return refuse_null("the text of the scenario");
  if (name == nullptr) name = "<text>";
  return guard([&] {
    const ErrorSource source{name, std::string(text, length)};
    return make_handle(kSimulation, source, options, simulation, [&](const LoadOptions& read) {
      return std::make_unique<Engine>(unlatch::hil::load_scenario_text(source.text, name, read.overrides), read);
    });
  });
}

unlatch_status unlatch_open_recording(const char* path, const unlatch_options* options,
                                      unlatch_simulation** simulation) {
  if (simulation == nullptr) return refuse_null("the place for the simulation");
  *simulation = nullptr;
  if (path == nullptr) return refuse_null("the path of the recording");
  return guard([&] {
    return make_handle(kSimulation, {path, ""}, options, simulation,
                       [&](const LoadOptions& read) -> std::unique_ptr<Engine> {
                         if (!read.overrides.empty()) {
                           (void)fail(UNLATCH_ERROR_ARGUMENT, "a recording has its own overrides; it takes no others");
                           return nullptr;
                         }
                         unlatch::hil::RecordingReader recording{unlatch::hil::LogFileReader(path)};
                         unlatch::hil::Scenario scenario = unlatch::hil::load_recorded_scenario(recording.header);
                         return std::make_unique<Engine>(std::move(recording), std::move(scenario), read);
                       });
  });
}

unlatch_status unlatch_close(unlatch_simulation* simulation) {
  return unlatch::library::close_handle<Engine>(kSimulation, simulation);
}

// --- Contents -------------------------------------------------------------------------------------------------------

unlatch_status unlatch_count(unlatch_simulation* simulation, int32_t kind, size_t* count) {
  return with_engine(simulation, [&](Engine& engine) { return engine.catalogue().count(kind, count); });
}

unlatch_status unlatch_describe(unlatch_simulation* simulation, int32_t kind, size_t index, unlatch_item* item) {
  return with_engine(simulation, [&](Engine& engine) { return engine.catalogue().describe(kind, index, item); });
}

unlatch_status unlatch_find(unlatch_simulation* simulation, int32_t kind, const char* name, size_t* index) {
  if (name == nullptr || index == nullptr) return refuse_null("the name, or the place for its number");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    if (!unlatch::library::Catalogue::is_kind(kind))
      return fail(UNLATCH_ERROR_ARGUMENT, "a kind of items that is unknown: " + std::to_string(kind));
    const int found = engine.catalogue().find(kind, name);
    if (found == -2)
      return fail(UNLATCH_ERROR_RANGE, std::string("several are called '") + name + "'; name one as name:subject");
    if (found < 0) return fail(UNLATCH_ERROR_RANGE, std::string("nothing is called '") + name + "'");
    *index = static_cast<size_t>(found);
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_get_mode_name(unlatch_simulation* simulation, size_t joint, size_t mode, const char** name) {
  if (name == nullptr) return refuse_null("the place for the name");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    if (joint >= engine.scenario().model.joints.size() || mode >= engine.catalogue().get_modes(joint).size())
      return fail(UNLATCH_ERROR_RANGE, "no joint, or no mode, of this number");
    *name = engine.catalogue().get_modes(joint)[mode].c_str();
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_get_scenario(unlatch_simulation* simulation, const char** name, double* dt, double* until) {
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    if (name != nullptr) *name = engine.scenario().name.c_str();
    if (dt != nullptr) *dt = engine.scenario().dt;
    if (until != nullptr) *until = engine.scenario().until;
    return UNLATCH_OK;
  });
}

// --- Commands and steps ---------------------------------------------------------------------------------------------

unlatch_status unlatch_set_channel(unlatch_simulation* simulation, size_t channel, double value) {
  return unlatch_set_channels(simulation, channel, 1, &value);
}

unlatch_status unlatch_set_channels(unlatch_simulation* simulation, size_t first, size_t count, const double* values) {
  if (values == nullptr && count > 0) return refuse_null("the values");
  const Access access(kSimulation, simulation);
  if (!access) return fail(access);
  return access.get<Engine>().set_channels(first, count, values);
}

unlatch_status unlatch_step(unlatch_simulation* simulation) {
  const Access access(kSimulation, simulation);
  if (!access) return fail(access);
  return access.get<Engine>().step();
}

unlatch_status unlatch_advance(unlatch_simulation* simulation, uint64_t ticks, uint32_t flags, uint64_t* done) {
  uint64_t made = 0;
  if (done == nullptr) done = &made;
  *done = 0;
  if ((flags & ~static_cast<uint32_t>(UNLATCH_STOP_AT_EVENTS)) != 0)
    return fail(UNLATCH_ERROR_ARGUMENT, "an unknown flag; UNLATCH_STOP_AT_EVENTS is known");
  const Access access(kSimulation, simulation);
  if (!access) return fail(access);
  return access.get<Engine>().advance(ticks, flags, *done, access.interrupted());
}

unlatch_status unlatch_interrupt(void* handle) {
  return unlatch::library::interrupt_handle(handle) ? UNLATCH_OK : UNLATCH_ERROR_HANDLE;
}

unlatch_status unlatch_get_tick(unlatch_simulation* simulation, int64_t* tick) {
  if (tick == nullptr) return refuse_null("the place for the tick");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    *tick = engine.simulation().get_tick();
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_get_time(unlatch_simulation* simulation, double* time) {
  if (time == nullptr) return refuse_null("the place for the time");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    *time = engine.simulation().get_time();
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_get_hash(unlatch_simulation* simulation, uint64_t* hash) {
  if (hash == nullptr) return refuse_null("the place for the hash");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    *hash = static_cast<uint64_t>(engine.simulation().calc_hash());
    return UNLATCH_OK;
  });
}

// --- Results --------------------------------------------------------------------------------------------------------

unlatch_status unlatch_get_array(unlatch_simulation* simulation, int32_t which, size_t index, unlatch_array* array) {
  if (array == nullptr) return refuse_null("the place for the array");
  if (array->size < sizeof(unlatch_array))
    return fail(UNLATCH_ERROR_ARGUMENT, "unlatch_array::size is not set; set it to sizeof(unlatch_array)");
  return with_engine(simulation, [&](Engine& engine) { return engine.get_array(which, index, *array); });
}

unlatch_status unlatch_get_events(unlatch_simulation* simulation, const unlatch_event** events, size_t* count,
                                  uint64_t* lost) {
  if (events == nullptr || count == nullptr) return refuse_null("the place for the events, or for their number");
  return with_engine(simulation, [&](Engine& engine) -> unlatch_status {
    engine.get_events(events, count, lost);
    return UNLATCH_OK;
  });
}

unlatch_status unlatch_judge(unlatch_simulation* simulation, const unlatch_verdict** verdicts, size_t* count) {
  if (verdicts == nullptr || count == nullptr) return refuse_null("the place for the verdicts, or for their number");
  return with_engine(simulation, [&](Engine& engine) { return engine.judge(verdicts, count); });
}

unlatch_status unlatch_get_certainties(unlatch_simulation* simulation, const unlatch_certainty** certainties,
                                       size_t* count) {
  if (certainties == nullptr || count == nullptr)
    return refuse_null("the place for the certainties, or for their number");
  return with_engine(simulation, [&](Engine& engine) { return engine.get_certainties(certainties, count); });
}

unlatch_status unlatch_get_findings(unlatch_simulation* simulation, const unlatch_finding** findings, size_t* count) {
  if (findings == nullptr || count == nullptr) return refuse_null("the place for the findings, or for their number");
  return with_engine(simulation, [&](Engine& engine) { return engine.get_findings(findings, count); });
}

unlatch_status unlatch_linearize(unlatch_simulation* simulation, const unlatch_linear_model** model) {
  if (model == nullptr) return refuse_null("the place for the linear model");
  return with_engine(simulation, [&](Engine& engine) { return engine.linearize(model); });
}

unlatch_status unlatch_get_linear_response(unlatch_simulation* simulation, const unlatch_linear_response** response) {
  if (response == nullptr) return refuse_null("the place for poles and gains");
  return with_engine(simulation, [&](Engine& engine) { return engine.get_linear_response(response); });
}

unlatch_status unlatch_calc_margins(unlatch_simulation* simulation, const char* loop, double period, double delay,
                                    unlatch_loop_margins* margins) {
  if (loop == nullptr || margins == nullptr) return refuse_null("the loop, or the place for its margins");
  return with_engine(simulation, [&](Engine& engine) { return engine.calc_margins(loop, period, delay, margins); });
}

// --- States and recordings ------------------------------------------------------------------------------------------

unlatch_status unlatch_save(unlatch_simulation* simulation, void* buffer, size_t capacity, size_t* needed) {
  if (needed == nullptr) return refuse_null("the place for the number of bytes");
  if (buffer == nullptr && capacity > 0) return refuse_null("the buffer");
  return with_engine(simulation, [&](Engine& engine) { return engine.save(buffer, capacity, needed); });
}

unlatch_status unlatch_restore(unlatch_simulation* simulation, const void* buffer, size_t length) {
  if (buffer == nullptr) return refuse_null("the saved state");
  return with_engine(simulation, [&](Engine& engine) { return engine.restore(buffer, length); });
}

unlatch_status unlatch_reset(unlatch_simulation* simulation) {
  return with_engine(simulation, [&](Engine& engine) { return engine.reset(); });
}

unlatch_status unlatch_start_recording(unlatch_simulation* simulation, const char* path) {
  if (path == nullptr) return refuse_null("the path of the recording");
  return with_engine(simulation, [&](Engine& engine) { return engine.start_recording(path); });
}

unlatch_status unlatch_stop_recording(unlatch_simulation* simulation) {
  return with_engine(simulation, [&](Engine& engine) { return engine.stop_recording(); });
}
