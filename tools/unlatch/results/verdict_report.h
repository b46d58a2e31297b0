// The verdict of a run on its requirements, and its separations: as tables, as JSON, as JUnit XML.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "tools/unlatch/results/report.h"

namespace unlatch::tools {

// A limit of a session with flight software, `flight_software.require`, and what the run had.
struct SessionVerdict {
  std::string id, text;        // "flight_software.lost"; what is counted
  double value = 0, most = 0;  // infinite: no limit
  [[nodiscard]] bool is_met() const { return value <= most; }
};
// Those of the run; none if no flight software took part.
std::vector<SessionVerdict> judge_session(const RunReport& report);

// All requirements and the limits of the session are met: what the exit code says beside the run's status.
bool is_met(const RunReport& report);

void print_requirements(std::FILE* to, const RunReport& report);
void print_session_verdicts(std::FILE* to, const RunReport& report);
nlohmann::ordered_json build_session_verdicts_json(const RunReport& report);
void print_separations(std::FILE* to, const RunReport& report);
nlohmann::ordered_json build_requirements_json(const RunReport& report);
nlohmann::ordered_json build_separations_json(const RunReport& report);

// One test suite: a case for the run itself, which is an error unless its status is "ok", and one for each requirement
// and each limit of the session. The format is that of Ant's JUnit task, as test servers read it. Empty target: nothing
// is written. `seconds`: wall time of the run, which the case of the run and the suite have; requirements are parts of
// it.
void write_junit(const RunReport& report, const std::string& target, double seconds);

// Wall time since it was made, s.
class WallTime {
 public:
  [[nodiscard]] double get() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace unlatch::tools
