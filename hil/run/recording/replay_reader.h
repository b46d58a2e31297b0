// Reader of a recording, tick by tick, in bounded memory; refuses other files.
#pragma once

#include <optional>
#include <string>
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
