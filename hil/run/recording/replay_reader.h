// Reader of a recording, tick by tick, in bounded memory; refuses other files.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/run/recording/log_format.h"

namespace unlatch::hil {

// Header of a recording, or of a checkpoint: the first event of the file, on `channel`. Throws LogError: not a log,
// neither of the two, the other of the two, another version or schema.
LogHeader read_header(LogFileReader& file, std::string_view channel);

class RecordingReader {
 public:
  // Reads the header. Throws LogError, see read_header.
  explicit RecordingReader(LogFileReader file);

  // Reads the next tick's record; false if there is none. Then `end` is the end of the run, or `shortfall` is a
  // sentence with the reason why the recording does not reach its end.
  [[nodiscard]] bool next(LogTick& tick);

  [[nodiscard]] const std::string& get_name() const { return file_.get_name(); }

  LogHeader header;
  std::optional<LogEnd> end;
  std::string shortfall;
  bool damaged = false;               // the shortfall is damage, not a writer that was killed
  std::vector<EventMessage> notices;  // notices of participants, policies and faults so far
  std::vector<EventMessage> events;   // all events of the session so far, but for those taken; at most kMostEvents
  std::int64_t events_left_out = 0;   // those that found no place
  std::vector<EventMessage> take_events() { return std::exchange(events, {}); }
  static constexpr std::size_t kMostEvents = 100'000;
  std::vector<LogReceived> received;  // at the tick that next() gave, or, at the end, at the end
  bool keeps_states = false;          // true: next() fills `states`
  std::vector<StateMessage>
      states;  // the State messages recorded for the tick that next() gave, or, at the end, for the end

 private:
  bool stop(std::string why, bool is_damage);
  void keep_message();

  LogFileReader file_;
  LogEvent event_;
  std::int64_t next_tick_;
};

}  // namespace unlatch::hil
