// FMI 3.0 for co-simulation: the functions by the standard's text.
#include <cstddef>
#include <cstdint>

#include "tools/fmu/binary.h"
#include "tools/fmu/co_simulation.h"
#include "tools/fmu/zip_file.h"

namespace unlatch::fmu {
namespace {

using Pointer = void*;
using References = const std::uint32_t*;
using Log = void (*)(void* environment, int status, const char* category, const char* message);

void log(void* environment, int, const char*, const char* message) {
  if (environment != nullptr && message != nullptr) static_cast<Binary*>(environment)->keep_message(message);
}

class Fmi3 final : public CoSimulation {
 public:
  Fmi3(const Description& description, const std::string& library, const std::string& resources)
      : binary_(library, "fmi3") {
    binary_.find(get_version_, "GetVersion");
    binary_.find(instantiate_, "InstantiateCoSimulation");
    binary_.find(free_, "FreeInstance");
    binary_.find(enter_, "EnterInitializationMode");
    binary_.find(exit_, "ExitInitializationMode");
    binary_.find(terminate_, "Terminate");
    binary_.find(get_float64_, "GetFloat64");
    binary_.find(set_float64_, "SetFloat64");
    binary_.find(get_boolean_, "GetBoolean");
    binary_.find(set_boolean_, "SetBoolean");
    binary_.find(step_, "DoStep");
    binary_.require_all();
    binary_.check_version(get_version_(), "3.");
    instance_ = instantiate_("unlatch", description.token.c_str(), (resources + "/").c_str(), false, true, false, false,
                             nullptr, 0, &binary_, &log, nullptr);
    if (instance_ == nullptr)
      throw FmuError("fmi3InstantiateCoSimulation refused the instantiationToken '" + description.token +
                     "' of its description" + binary_.quote_message());
  }
  ~Fmi3() override {
    if (started_ && binary_.may_terminate()) terminate_(instance_);
    if (instance_ != nullptr && binary_.may_free()) free_(instance_);
  }

  void enter_initialization(double start) override {
    binary_.check(enter_(instance_, false, 0, start, false, 0), "EnterInitializationMode");
  }
  void exit_initialization() override {
    binary_.check(exit_(instance_), "ExitInitializationMode");
    started_ = true;
  }
  void set(const Variable& variable, double value) override {
    if (variable.kind == Variable::Kind::kBoolean) {
      const bool flag = value != 0;
      binary_.check(set_boolean_(instance_, &variable.reference, 1, &flag, 1), "SetBoolean of " + variable.name);
    } else {
      binary_.check(set_float64_(instance_, &variable.reference, 1, &value, 1), "SetFloat64 of " + variable.name);
    }
  }
  double get(const Variable& variable) override {
    if (variable.kind == Variable::Kind::kBoolean) {
      bool flag = false;
      binary_.check(get_boolean_(instance_, &variable.reference, 1, &flag, 1), "GetBoolean of " + variable.name);
      return flag ? 1 : 0;
    }
    double value = 0;
    binary_.check(get_float64_(instance_, &variable.reference, 1, &value, 1), "GetFloat64 of " + variable.name);
    return value;
  }
  void step(double time, double size) override {
    bool event = false, terminate = false, early = false;
    double last = 0;
    binary_.check(step_(instance_, time, size, true, &event, &terminate, &early, &last), "DoStep");
    if (terminate) throw FmuError("fmi3DoStep asks to end the simulation" + binary_.quote_message());
    if (early) throw FmuError("fmi3DoStep returned early, which it was not allowed");
  }
  [[nodiscard]] std::string take_warning() override { return binary_.take_warning(); }

 private:
  Binary binary_;
  Pointer instance_ = nullptr;
  bool started_ = false;

  const char* (*get_version_)() = nullptr;
  Pointer (*instantiate_)(const char*, const char*, const char*, bool, bool, bool, bool, References, std::size_t, void*,
                          Log, void*) = nullptr;
  void (*free_)(Pointer) = nullptr;
  int (*enter_)(Pointer, bool, double, double, bool, double) = nullptr;
  int (*exit_)(Pointer) = nullptr;
  int (*terminate_)(Pointer) = nullptr;
  int (*get_float64_)(Pointer, References, std::size_t, double*, std::size_t) = nullptr;
  int (*set_float64_)(Pointer, References, std::size_t, const double*, std::size_t) = nullptr;
  int (*get_boolean_)(Pointer, References, std::size_t, bool*, std::size_t) = nullptr;
  int (*set_boolean_)(Pointer, References, std::size_t, const bool*, std::size_t) = nullptr;
  int (*step_)(Pointer, double, double, bool, bool*, bool*, bool*, double*) = nullptr;
};

}  // namespace

std::unique_ptr<CoSimulation> load_fmi3(const Description& description, const std::string& library,
                                        const std::string& resources) {
  return std::make_unique<Fmi3>(description, library, resources);
}

}  // namespace unlatch::fmu
