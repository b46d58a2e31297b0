// Reads a recording tick by tick, in bounded memory, and refuses what is none.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/log_format.h"

namespace unlatch::hil {

class RecordingReader {
 public:
  // Reads up to the header. Throws LogError: not a log, no recording, another version.
  explicit RecordingReader(LogFileReader file);

  // The next tick's record; false when there is none. Then `end` holds how the run ended, or `shortfall` says in a
  // sentence why the recording does not reach its end.
  [[nodiscard]] bool next(LogTick& tick);

  LogHeader header;
  std::optional<LogEnd> end;
  std::string shortfall;
  bool damaged = false;        // the shortfall is damage, not a writer that was killed
  std::vector<Event> notices;  // what the executive said of participants and policies, up to here

 private:
  bool stop(std::string why, bool is_damage);
  void keep_notice();

  LogFileReader file_;
  LogEvent event_;
  std::int64_t next_tick_ = 0;
};

}  // namespace unlatch::hil
