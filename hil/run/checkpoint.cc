#include "hil/run/checkpoint.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "hil/run/recording/replay_reader.h"
#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

// Refuses a target that is neither free nor a regular file: a rename would replace a device or a pipe.
void refuse_odd_target(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    throw LogWriteError(path + ": is there and is no file; a checkpoint needs a file's name");
  }
}

// Removes an unfinished file.
class Unfinished {
 public:
  explicit Unfinished(const std::string& path) : path_(path + "." + std::to_string(getpid()) + ".unfinished") {}
  ~Unfinished() { std::remove(path_.c_str()); }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  [[nodiscard]] const std::string& get_path() const { return path_; }

 private:
  const std::string path_;
};

// Writes the folder to the disk, so that the new name survives a power failure. Not every file system supports it; the
// file itself is safe by then.
void sync_folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const int handle = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  fsync(handle);
  close(handle);
}

// Reason why a run cannot continue from a checkpoint; empty if it can.
std::string explain_foreign(const LogHeader& checkpoint, const LogHeader& here) {
  if (checkpoint.program != here.program) {
    return "was written by " + checkpoint.program + "; this is " + here.program + "; go on with the one that wrote it";
  }
  if (checkpoint.scenario_name != here.scenario_name) {
    return "is of scenario '" + checkpoint.scenario_name + "', this run is of '" + here.scenario_name + "'";
  }
  if (checkpoint.dt != here.dt) {
    char text[128];
    std::snprintf(text, sizeof text, "was written at a step of %.9g s, this run has %.9g s", checkpoint.dt, here.dt);
    return text;
  }
  if (checkpoint.model_hash != here.model_hash) {
    return "is of scenario '" + here.scenario_name +
           "' with another text or other --set values: the model differs, and no bits would be the same";
  }
  return "";
}

}  // namespace

void write_checkpoint(const std::string& path, const Scenario& scenario, const Simulation& simulation,
                      std::int64_t last_tick, bool unresolved) {
  refuse_odd_target(path);
  LogHeader header = build_log_header(scenario, simulation, Pace::kFast, 0, last_tick);
  header.start = simulation.save();
  header.begins_unresolved = unresolved || simulation.begins_unresolved();
  std::vector<std::uint8_t> bytes;
  encode(header, bytes);

  const Unfinished unfinished(path);
  {
    LogFileWriter writer(unfinished.get_path(), path);
    writer.append(0, kCheckpointChannel, bytes);
    if (!writer.sync()) throw LogWriteError(writer.get_error());
  }
  if (std::rename(unfinished.get_path().c_str(), path.c_str()) != 0) {
    throw LogWriteError(path + ": cannot be created: " + std::strerror(errno));
  }
  sync_folder_of(path);
}

void read_checkpoint(const std::string& path, const Scenario& scenario, Simulation& simulation) {
  LogFileReader file(path);
  const LogHeader checkpoint = read_header(file, kCheckpointChannel);
  LogEvent more;
  if (file.next(more) != LogFileReader::Result::kEnd) throw LogError(path + ": is damaged: it goes on after its end");
  const LogHeader here = build_log_header(scenario, simulation, Pace::kFast, 0, 0);
  const std::string foreign = explain_foreign(checkpoint, here);
  if (!foreign.empty()) throw LogError(path + ": " + foreign);
  if (!simulation.restore(checkpoint.start, checkpoint.begins_unresolved)) {
    throw LogError(path +
                   ": holds a state that this program's model cannot have; go on with the program that wrote it");
  }
}

}  // namespace unlatch::hil
