// One instance of the FMU, whatever the version of FMI: the simulation, its variables, and the state machine of
// co-simulation. Everything gives false, and the reason to the importer's log, where the standard demands an error.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "library/fmi/variables.h"

namespace unlatch::fmi {

class Instance {
 public:
  enum class Phase { kInstantiated, kInitialization, kStep, kEvent, kTerminated };
  using Log = std::function<void(const char* message)>;

  // `resources`: folder with scenario.yaml and overrides.txt; `token`: that of the description. Null after an error.
  static std::unique_ptr<Instance> create(const std::string& resources, const char* token, Log log);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  [[nodiscard]] bool move(Phase from, Phase to, const char* call);
  [[nodiscard]] bool terminate();
  [[nodiscard]] bool reset();
  [[nodiscard]] Phase get_phase() const { return phase_; }

  [[nodiscard]] bool get(const std::uint32_t* references, std::size_t count, double* values, std::size_t value_count);
  [[nodiscard]] bool set(const std::uint32_t* references, std::size_t count, const double* values,
                         std::size_t value_count);

  // From `time` on by `size` s, a whole number of ticks; to the tick in which an event acted if `stops`.
  [[nodiscard]] bool step(double time, double size, bool stops, bool& stopped);
  [[nodiscard]] double get_time() const;

  [[nodiscard]] bool save(std::vector<std::byte>& state);
  [[nodiscard]] bool restore(const std::byte* state, std::size_t size);

  bool refuse(const std::string& why) const;  // false

  bool event_mode = false, early_return = false;  // as the importer wants it; FMI 3

 private:
  explicit Instance(Log log) : log_(std::move(log)) {}
  bool refuse_of_library(const char* call) const;

  Log log_;
  unlatch_simulation* simulation_ = nullptr;
  std::vector<Variable> variables_;
  double dt_ = 0;  // s
  Phase phase_ = Phase::kInstantiated;
};

// The instance of a pointer that an importer gave; null if it is none that lives.
Instance* find_instance(void* pointer);
void* keep_instance(std::unique_ptr<Instance> instance);
void free_instance(void* pointer);
// The description's token: a scenario's text and overrides, hashed.
std::string calc_token(const std::string& text, const std::vector<std::string>& overrides);
// "file:///a%20b/resources" or a path.
std::string read_uri(const char* uri);

}  // namespace unlatch::fmi
