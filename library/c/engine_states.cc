// States and recordings of an engine, and the arrays that present its data.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "hil/run/run.h"
#include "hil/scenario/text/count.h"
#include "library/c/engine.h"

namespace unlatch::library {
namespace {

// Format of a saved state: these words, the model's hash, the words of Simulation::save(), and a CRC-64 of all before
// it.
constexpr std::uint64_t kSavedMark = 0x32657461745355ull;  // "USTate2"
constexpr std::size_t kFrameWords = 4;                     // mark, model, whether it is unresolved; check

std::uint64_t calc_check(std::span<const std::uint64_t> words) {
  return hil::calc_crc64({reinterpret_cast<const std::uint8_t*>(words.data()), words.size_bytes()});
}

// Sets an array to numbers that lie `row_stride` and `column_stride` bytes apart.
void show(unlatch_array& array, const void* data, std::size_t rows, std::size_t columns, std::ptrdiff_t row_stride,
          std::ptrdiff_t column_stride = sizeof(double), std::int32_t type = UNLATCH_DOUBLE) {
  unlatch_array shown{};
  shown.size = array.size;
  shown.data = data;
  shown.type = type;
  shown.rows = rows;
  shown.columns = columns;
  shown.row_stride = row_stride;
  shown.column_stride = column_stride;
  array = shown;
}

void show_column(unlatch_array& array, std::span<const double> values) {
  show(array, values.data(), values.size(), 1, sizeof(double));
}

}  // namespace

unlatch_status Engine::get_array(std::int32_t which, std::size_t index, unlatch_array& array) const {
  const State& state = simulation_->state();
  const BodyState* bodies = state.bodies.data();
  const auto show_bodies = [&](const void* data, std::size_t columns) {
    show(array, data, state.bodies.size(), columns, sizeof(BodyState));
    return UNLATCH_OK;
  };
  const auto refuse_index = [&](std::size_t count) {
    return fail(UNLATCH_ERROR_RANGE, "number " + std::to_string(index) + " of " + std::to_string(count));
  };
  switch (which) {
    case UNLATCH_POSITIONS:
      return show_bodies(&bodies->p, 3);
    case UNLATCH_ATTITUDES:
      return show_bodies(&bodies->q, 4);
    case UNLATCH_VELOCITIES:
      return show_bodies(&bodies->v, 3);
    case UNLATCH_ANGULAR_VELOCITIES:
      return show_bodies(&bodies->w, 3);
    case UNLATCH_MODAL_COORDINATES: {
      if (index >= state.bodies.size()) return refuse_index(state.bodies.size());
      const auto modal = get_modal_coordinates(simulation_->plan(), state, static_cast<int>(index));
      show(array, modal.data(), 1, modal.size(), static_cast<std::ptrdiff_t>(modal.size_bytes()));
      return UNLATCH_OK;
    }
    case UNLATCH_JOINT_MODES:
      show(array, state.joints.empty() ? nullptr : &state.joints.data()->mode, state.joints.size(), 1,
           sizeof(JointState), sizeof(std::int64_t), UNLATCH_INT64);
      return UNLATCH_OK;
    case UNLATCH_REACTIONS: {
      if (index >= state.joints.size()) return refuse_index(state.joints.size());
      const MultiplierView& all = simulation_->workspace().multipliers;
      const std::ptrdiff_t stride = (&all.get(index, 1) - &all.get(index, 0)) * std::ptrdiff_t{sizeof(double)};
      show(array, &all.get(index, 0), 1, kRows, kRows * stride, stride);
      return UNLATCH_OK;
    }
    case UNLATCH_SENSORS:
      show_column(array, simulation_->get_sensors());
      return UNLATCH_OK;
    case UNLATCH_RECEIVED:
      show_column(array, received_);
      return UNLATCH_OK;
    case UNLATCH_SIGNALS:
      show_column(array, state.signals);
      return UNLATCH_OK;
    case UNLATCH_CHANNELS:
      show_column(array, std::as_const(*simulation_).channels());
      return UNLATCH_OK;
    case UNLATCH_CLEARANCES:
      if (!analysis_) return fail(UNLATCH_ERROR_ORDER, "clearances need UNLATCH_JUDGE in the options' flags");
      show_column(array, clearances_);
      return UNLATCH_OK;
    default:
      return fail(UNLATCH_ERROR_ARGUMENT, "an array that is unknown: " + std::to_string(which));
  }
}

// --- States ---------------------------------------------------------------------------------------------------------

unlatch_status Engine::refuse_while_busy(const char* what) const {
  if (replay_) return fail(UNLATCH_ERROR_ORDER, std::string(what) + " is not possible in a replay");
  if (recording_)
    return fail(UNLATCH_ERROR_ORDER, std::string(what) + " is not possible while recording; stop the recording first");
  return UNLATCH_OK;
}

unlatch_status Engine::save(void* buffer, std::size_t capacity, std::size_t* needed) const {
  *needed = (initial_.size() + kFrameWords) * sizeof(std::uint64_t);
  if (capacity < *needed) {
    if (buffer == nullptr && capacity == 0) return UNLATCH_OK;
    return fail(UNLATCH_ERROR_RANGE,
                "a state takes " + hil::count(*needed, "byte") + ", the buffer has " + std::to_string(capacity));
  }
  std::vector<std::uint64_t> words{kSavedMark, static_cast<std::uint64_t>(simulation_->get_model_hash()),
                                   is_unresolved() ? 1u : 0u};
  const std::vector<std::uint64_t> saved = simulation_->save();
  words.insert(words.end(), saved.begin(), saved.end());
  words.push_back(calc_check(words));
  std::memcpy(buffer, words.data(), *needed);
  return UNLATCH_OK;
}

unlatch_status Engine::restore(const void* buffer, std::size_t length) {
  if (const unlatch_status status = refuse_while_busy("restoring"); status != UNLATCH_OK) return status;
  const auto refuse = [](const char* text) { return fail(UNLATCH_ERROR_STATE, text); };
  if (length != (initial_.size() + kFrameWords) * sizeof(std::uint64_t))
    return refuse("these are not as many bytes as a state of this model has");
  std::vector<std::uint64_t> words(length / sizeof(std::uint64_t));
  std::memcpy(words.data(), buffer, length);
  const std::span<const std::uint64_t> all = words;
  if (words[0] != kSavedMark) return refuse("these bytes are no saved state");
  if (words[1] != static_cast<std::uint64_t>(simulation_->get_model_hash()))
    return refuse("this is a state of another scenario, or of one with other overrides");
  if (words.back() != calc_check(all.first(all.size() - 1))) return refuse("this saved state is damaged");
  return restore_words(all.subspan(3, initial_.size()), words[2] != 0);
}

bool Engine::is_unresolved() const {
  return simulation_->begins_unresolved() ||
         (get_notices() != nullptr && !get_notices()->describe_unresolved().empty());
}

unlatch_status Engine::restore_words(std::span<const std::uint64_t> words, bool unresolved) {
  if (!simulation_->restore(words, unresolved))
    return fail(UNLATCH_ERROR_STATE, "this is no state that the model can have");
  begin_anew();
  return UNLATCH_OK;
}

unlatch_status Engine::reset() {
  if (const unlatch_status status = refuse_while_busy("resetting"); status != UNLATCH_OK) return status;
  return restore_words(initial_, false);
}

// --- Recordings -----------------------------------------------------------------------------------------------------

unlatch_status Engine::start_recording(const char* path) {
  if (const unlatch_status status = refuse_while_busy("beginning to record"); status != UNLATCH_OK) return status;
  if (*path == 0) return fail(UNLATCH_ERROR_ARGUMENT, "an empty path; name the file to write");
  const std::int64_t end = hil::calc_nearest_tick(scenario_.until, scenario_.dt);
  hil::LogHeader header =
      hil::build_log_header(scenario_, *simulation_, hil::Pace::kFast, 0, std::max(end, simulation_->get_tick()));
  std::vector<std::uint64_t> now = simulation_->save();
  const bool begins = now == initial_;
  if (!begins) {
    header.start = std::move(now);
    header.begins_unresolved = is_unresolved();
  }
  recording_ = std::make_unique<Recording>(path, header, *simulation_);
  recording_->record.state(hil::RunStatus::kRunning);
  recording_ended_ = false;
  has_extras_ = true;
  return UNLATCH_OK;
}

void Engine::close_recording(hil::LogEnd end) {
  const std::unique_ptr<Recording> recording = std::move(recording_);
  has_extras_ = get_notices() != nullptr;
  end.tick = simulation_->get_tick();
  end.hash = simulation_->calc_hash();
  if (!recording->recorder.wants_state(end.tick)) recording->record.state(end.status);
  recording->recorder.close(end);
  recording_error_ = recording->recorder.get_error();
  recording_ended_ = true;
}

unlatch_status Engine::stop_recording() {
  if (recording_) close_recording({});
  if (!recording_ended_) return fail(UNLATCH_ERROR_ORDER, "no recording is being written");
  recording_ended_ = false;
  if (recording_error_.empty()) return UNLATCH_OK;
  return fail(UNLATCH_ERROR_FILE, recording_error_);
}

}  // namespace unlatch::library
