// FMI 2.0 for co-simulation: the functions by the standard's text.
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "tools/fmu/binary.h"
#include "tools/fmu/co_simulation.h"
#include "tools/fmu/zip_file.h"

namespace unlatch::fmu {
namespace {

using Pointer = void*;
using References = const unsigned int*;

struct Callbacks {
  void (*logger)(void* environment, const char* instance, int status, const char* category, const char* format, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, int);
  void* environment;
};

void log(void* environment, const char*, int, const char*, const char* format, ...) {
  char text[1000] = "";
  std::va_list arguments;
  va_start(arguments, format);
  if (format != nullptr) (void)std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (environment != nullptr) static_cast<Binary*>(environment)->keep_message(text);
}

class Fmi2 final : public CoSimulation {
 public:
  Fmi2(const Description& description, const std::string& library, const std::string& resources)
      : binary_(library, "fmi2"), callbacks_{&log, &std::calloc, &std::free, nullptr, &binary_} {
    binary_.find(get_version_, "GetVersion");
    binary_.find(instantiate_, "Instantiate");
    binary_.find(free_, "FreeInstance");
    binary_.find(set_up_, "SetupExperiment");
    binary_.find(enter_, "EnterInitializationMode");
    binary_.find(exit_, "ExitInitializationMode");
    binary_.find(terminate_, "Terminate");
    binary_.find(get_real_, "GetReal");
    binary_.find(set_real_, "SetReal");
    binary_.find(get_boolean_, "GetBoolean");
    binary_.find(set_boolean_, "SetBoolean");
    binary_.find(step_, "DoStep");
    binary_.require_all();
    binary_.check_version(get_version_(), "2.");
    constexpr int kCoSimulation = 1;
    instance_ = instantiate_("unlatch", kCoSimulation, description.token.c_str(), ("file://" + resources).c_str(),
                             &callbacks_, 0, 1);
    if (instance_ == nullptr)
      throw FmuError("fmi2Instantiate refused the guid '" + description.token + "' of its description" +
                     binary_.quote_message());
  }
  ~Fmi2() override {
    if (started_ && binary_.may_terminate()) terminate_(instance_);
    if (instance_ != nullptr && binary_.may_free()) free_(instance_);
  }

  void enter_initialization(double start) override {
    binary_.check(set_up_(instance_, 0, 0, start, 0, 0), "SetupExperiment");
    binary_.check(enter_(instance_), "EnterInitializationMode");
  }
  void exit_initialization() override {
    binary_.check(exit_(instance_), "ExitInitializationMode");
    started_ = true;
  }
  void set(const Variable& variable, double value) override {
    if (variable.kind == Variable::Kind::kBoolean) {
      const int flag = value != 0 ? 1 : 0;
      binary_.check(set_boolean_(instance_, &variable.reference, 1, &flag), "SetBoolean of " + variable.name);
    } else {
      binary_.check(set_real_(instance_, &variable.reference, 1, &value), "SetReal of " + variable.name);
    }
  }
  double get(const Variable& variable) override {
    if (variable.kind == Variable::Kind::kBoolean) {
      int flag = 0;
      binary_.check(get_boolean_(instance_, &variable.reference, 1, &flag), "GetBoolean of " + variable.name);
      return flag != 0 ? 1 : 0;
    }
    double value = 0;
    binary_.check(get_real_(instance_, &variable.reference, 1, &value), "GetReal of " + variable.name);
    return value;
  }
  void step(double time, double size) override { binary_.check(step_(instance_, time, size, 1), "DoStep"); }
  [[nodiscard]] std::string take_warning() override { return binary_.take_warning(); }

 private:
  Binary binary_;
  const Callbacks callbacks_;
  Pointer instance_ = nullptr;
  bool started_ = false;

  const char* (*get_version_)() = nullptr;
  Pointer (*instantiate_)(const char*, int, const char*, const char*, const Callbacks*, int, int) = nullptr;
  void (*free_)(Pointer) = nullptr;
  int (*set_up_)(Pointer, int, double, double, int, double) = nullptr;
  int (*enter_)(Pointer) = nullptr;
  int (*exit_)(Pointer) = nullptr;
  int (*terminate_)(Pointer) = nullptr;
  int (*get_real_)(Pointer, References, std::size_t, double*) = nullptr;
  int (*set_real_)(Pointer, References, std::size_t, const double*) = nullptr;
  int (*get_boolean_)(Pointer, References, std::size_t, int*) = nullptr;
  int (*set_boolean_)(Pointer, References, std::size_t, const int*) = nullptr;
  int (*step_)(Pointer, double, double, int) = nullptr;
};

}  // namespace

std::unique_ptr<CoSimulation> load_fmi2(const Description& description, const std::string& library,
                                        const std::string& resources) {
  return std::make_unique<Fmi2>(description, library, resources);
}

}  // namespace unlatch::fmu
