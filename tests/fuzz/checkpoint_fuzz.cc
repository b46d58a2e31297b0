// The reader of checkpoints: a run continues from one, or a message gives the reason why not.
#include <sys/mman.h>
#include <unistd.h>

#include "hil/run/checkpoint.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/reseal.h"

using namespace unlatch;

namespace {

// One file in memory, with a name, for all executions.
class NamedMemory {
 public:
  NamedMemory() : handle_(memfd_create("checkpoint", MFD_CLOEXEC)) { fuzz::require(handle_ >= 0, "no memory file"); }
  void write(std::span<const std::uint8_t> bytes) const {
    fuzz::require(ftruncate(handle_, 0) == 0, "ftruncate");
    fuzz::require(pwrite(handle_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()), "pwrite");
  }
  [[nodiscard]] std::string get_path() const { return "/proc/self/fd/" + std::to_string(handle_); }

 private:
  const int handle_;
};

void resume(const hil::Scenario& scenario, const std::string& path) {
  static const auto fresh = hil::build_simulation(scenario);
  static const auto beginning = fresh->save();
  const bool restored = fresh->restore(beginning);
  fuzz::require(restored, "a simulation that does not go back to its beginning");
  try {
    hil::read_checkpoint(path, scenario, *fresh);
    fuzz::step_a_little(*fresh);
  } catch (const hil::LogError&) {
    fuzz::require(fresh->save() == beginning, "a refused checkpoint that has changed the run");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const hil::Scenario scenario = hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml");
  static const NamedMemory file;
  const std::span bytes(data, size);
  file.write(bytes);
  resume(scenario, file.get_path());
  file.write(fuzz::reseal(bytes));
  resume(scenario, file.get_path());
  return 0;
}
