// The functions of FMI 2.0 for co-simulation, by the standard's text.
#include <cstddef>
#include <exception>
#include <string>

#include "library/fmi/calls.h"

using unlatch::fmi::access_none;
using unlatch::fmi::get_category;
using unlatch::fmi::Instance;
using unlatch::fmi::move;
using unlatch::fmi::refuse;
using unlatch::fmi::Status;
using unlatch::fmi::with;
using Phase = Instance::Phase;

namespace {

constexpr int kCoSimulation = 1;
using References = const unsigned int*;

struct Callbacks {
  void (*logger)(void* environment, const char* instance, Status status, const char* category, const char* format, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, Status);
  void* environment;
};

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform(void) { return "default"; }
const char* fmi2GetVersion(void) { return "2.0"; }
Status fmi2SetDebugLogging(void* pointer, int, std::size_t, const char* const*) {
  return with(pointer, [](Instance&) { return true; });
}

void* fmi2Instantiate(const char* name, int type, const char* token, const char* resources, const Callbacks* callbacks,
                      int, int logging) {
  if (type != kCoSimulation || callbacks == nullptr) return nullptr;
  try {
    const Callbacks kept = *callbacks;
    const std::string own = name == nullptr ? "" : name;
    auto made = Instance::create(unlatch::fmi::read_uri(resources), token, [=](Status status, const char* message) {
      if (logging != 0 && kept.logger != nullptr)
        kept.logger(kept.environment, own.c_str(), status, get_category(status), "%s", message);
    });
    return unlatch::fmi::keep_instance(std::move(made));
  } catch (const std::exception&) {
    return nullptr;
  }
}
void fmi2FreeInstance(void* pointer) { unlatch::fmi::free_instance(pointer); }

Status fmi2SetupExperiment(void* pointer, int, double, double start, int stops, double stop) {
  return with(pointer, [&](Instance& instance) {
    if (instance.get_phase() != Phase::kInstantiated) return instance.refuse("setting up is not allowed now");
    if (start != 0) return instance.refuse("the start time of this FMU is 0");
    if (stops != 0) instance.set_stop_time(stop);
    return true;
  });
}
Status fmi2EnterInitializationMode(void* pointer) {
  return move(pointer, Phase::kInstantiated, Phase::kInitialization, "entering initialization mode");
}
Status fmi2ExitInitializationMode(void* pointer) {
  return with(pointer, [](Instance& instance) { return instance.end_initialization(Phase::kStep); });
}
Status fmi2Terminate(void* pointer) { return unlatch::fmi::terminate(pointer); }
Status fmi2Reset(void* pointer) { return unlatch::fmi::reset(pointer); }

Status fmi2GetReal(void* pointer, References references, std::size_t count, double* values) {
  return with(pointer, [&](Instance& instance) { return instance.get(references, count, values, count); });
}
Status fmi2SetReal(void* pointer, References references, std::size_t count, const double* values) {
  return with(pointer, [&](Instance& instance) { return instance.set(references, count, values, count); });
}
Status fmi2GetInteger(void* pointer, References, std::size_t count, int*) { return access_none(pointer, count); }
Status fmi2SetInteger(void* pointer, References, std::size_t count, const int*) { return access_none(pointer, count); }
Status fmi2GetBoolean(void* pointer, References, std::size_t count, int*) { return access_none(pointer, count); }
Status fmi2SetBoolean(void* pointer, References, std::size_t count, const int*) { return access_none(pointer, count); }
Status fmi2GetString(void* pointer, References, std::size_t count, const char**) { return access_none(pointer, count); }
Status fmi2SetString(void* pointer, References, std::size_t count, const char* const*) {
  return access_none(pointer, count);
}

Status fmi2DoStep(void* pointer, double time, double size, int) {
  return with(pointer, [&](Instance& instance) {
    bool stopped = false;
    return instance.step(time, size, false, stopped);
  });
}

Status fmi2GetFMUstate(void* pointer, void** state) { return unlatch::fmi::get_state(pointer, state); }
Status fmi2SetFMUstate(void* pointer, void* state) { return unlatch::fmi::set_state(pointer, state); }
Status fmi2FreeFMUstate(void* pointer, void** state) { return unlatch::fmi::free_state(pointer, state); }
Status fmi2SerializedFMUstateSize(void* pointer, void* state, std::size_t* size) {
  return unlatch::fmi::get_state_size(pointer, state, size);
}
Status fmi2SerializeFMUstate(void* pointer, void* state, char* bytes, std::size_t size) {
  return unlatch::fmi::serialize_state(pointer, state, bytes, size);
}
Status fmi2DeSerializeFMUstate(void* pointer, const char* bytes, std::size_t size, void** state) {
  return unlatch::fmi::deserialize_state(pointer, bytes, size, state);
}

#define UNLATCH_FMI2_REFUSED(Name, ...) \
  Status fmi2##Name(void* pointer __VA_OPT__(, ) __VA_ARGS__) { return refuse(pointer, "fmi2" #Name); }
UNLATCH_FMI2_REFUSED(GetDirectionalDerivative, References, std::size_t, References, std::size_t, const double*, double*)
UNLATCH_FMI2_REFUSED(SetRealInputDerivatives, References, std::size_t, const int*, const double*)
UNLATCH_FMI2_REFUSED(GetRealOutputDerivatives, References, std::size_t, const int*, double*)
UNLATCH_FMI2_REFUSED(CancelStep)
UNLATCH_FMI2_REFUSED(GetStatus, int, Status*)
UNLATCH_FMI2_REFUSED(GetRealStatus, int, double*)
UNLATCH_FMI2_REFUSED(GetIntegerStatus, int, int*)
UNLATCH_FMI2_REFUSED(GetBooleanStatus, int, int*)
UNLATCH_FMI2_REFUSED(GetStringStatus, int, const char**)

}  // extern "C"
