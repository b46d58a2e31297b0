// One instance of the FMU, for both versions of FMI: the simulation, its variables, and the state machine of
// co-simulation. Functions return false, with the reason in the importer's log, where the standard requires an error.
// What `unlatch check` would report is logged at the end of the initialization, what a step does not resolve at that
// step, each once. From the first step on that leaves results unresolved every step has the status "warning", until an
// earlier state is set.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "library/fmi/variables.h"

namespace unlatch::fmi {

using Status = int;  // of both standards
inline constexpr Status kOk = 0, kWarning = 1, kError = 3;

class Instance {
 public:
  enum class Phase { kInstantiated, kInitialization, kStep, kEvent, kTerminated };
  using Log = std::function<void(Status status, const char* message)>;

  // Creates an instance. `resources`: folder with scenario.yaml and overrides.txt; `token`: that of the description.
  // Null after an error.
  static std::unique_ptr<Instance> create(const std::string& resources, const char* token, Log log);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  [[nodiscard]] bool move(Phase from, Phase to, const char* call);
  // Ends the initialization: the parameters have their final values.
  [[nodiscard]] bool end_initialization(Phase to);
  [[nodiscard]] bool terminate();
  [[nodiscard]] bool reset();
  [[nodiscard]] Phase get_phase() const { return phase_; }

  [[nodiscard]] bool get(const std::uint32_t* references, std::size_t count, double* values, std::size_t value_count);
  [[nodiscard]] bool set(const std::uint32_t* references, std::size_t count, const double* values,
                         std::size_t value_count);

  // Time beyond which no step may lead, s.
  void set_stop_time(double time) { stop_time_ = time; }
  // Steps from `time` by `size` s, a whole number of ticks; to the tick in which an event acted if `stops`.
  [[nodiscard]] bool step(double time, double size, bool stops, bool& stopped);
  [[nodiscard]] double get_time() const;

  [[nodiscard]] bool save(std::vector<std::byte>& state);
  [[nodiscard]] bool restore(const std::byte* state, std::size_t size);

  bool refuse(const std::string& why) const;  // returns false
  // Status of the present call, which has done what it was to do: kWarning if it was a step, or the end of the
  // initialization, and results are unresolved, else kOk.
  [[nodiscard]] Status take_status() { return std::exchange(warned_, false) ? kWarning : kOk; }

  bool event_mode = false, early_return = false;  // options of the importer; FMI 3

 private:
  explicit Instance(Log log) : log_(std::move(log)) {}
  // Loads the scenario with these values of its parameters, at its start; inputs that were set are set again. After an
  // error the simulation is unchanged.
  bool load(const std::vector<double>& parameters);
  [[nodiscard]] bool may_set(std::uint32_t reference) const;
  bool refuse_of_library(const char* call) const;
  // Logs the findings that have not been logged.
  void log_findings();

  Log log_;
  unlatch_simulation* simulation_ = nullptr;
  std::string text_;                            // text of the scenario
  std::vector<std::string> overrides_;          // PATH=VALUE
  std::vector<Variable> variables_;             // parameters last
  std::size_t first_parameter_ = 0;             // value reference
  std::vector<double> starts_, parameters_;     // values of the parameters: as exported, and present
  std::map<std::uint32_t, double> inputs_set_;  // by value reference
  double dt_ = 0;                               // s
  Phase phase_ = Phase::kInstantiated;
  std::set<std::string> logged_;  // findings
  bool warned_ = false;           // the present call
  double stop_time_ = std::numeric_limits<double>::infinity();
};

// Instance of a pointer from an importer; null if it is no valid instance.
Instance* find_instance(void* pointer);
void* keep_instance(std::unique_ptr<Instance> instance);
void free_instance(void* pointer);
// Token of the description: a hash of a scenario's text and overrides.
std::string calc_token(const std::string& text, const std::vector<std::string>& overrides);
// Reads "file:///a%20b/resources" or a path.
std::string read_uri(const char* uri);

}  // namespace unlatch::fmi
