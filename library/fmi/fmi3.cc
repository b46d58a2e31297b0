// Functions of FMI 3.0 for co-simulation, by the standard's text. Unsupported functions return fmi3Error; reading or
// writing no variables of another type returns fmi3OK.
#include <cstddef>
#include <cstdint>
#include <exception>

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

using Log = void (*)(void* environment, Status status, const char* category, const char* message);
using References = const std::uint32_t*;

}  // namespace

extern "C" {

const char* fmi3GetVersion(void) { return "3.0"; }

void* fmi3InstantiateCoSimulation(const char*, const char* token, const char* resources, bool, bool logging,
                                  bool event_mode, bool early_return, References, std::size_t, void* environment,
                                  Log log, void*) {
  try {
    auto made = Instance::create(unlatch::fmi::read_uri(resources), token, [=](Status status, const char* message) {
      if (logging && log != nullptr) log(environment, status, get_category(status), message);
    });
    if (!made) return nullptr;
    made->event_mode = event_mode;
    made->early_return = early_return;
    return unlatch::fmi::keep_instance(std::move(made));
  } catch (const std::exception&) {
    return nullptr;
  }
}
void* fmi3InstantiateModelExchange(const char*, const char*, const char*, bool, bool, void*, Log) { return nullptr; }
void* fmi3InstantiateScheduledExecution(const char*, const char*, const char*, bool, bool, void*, Log, void*, void*,
                                        void*) {
  return nullptr;
}
void fmi3FreeInstance(void* instance) { unlatch::fmi::free_instance(instance); }
Status fmi3SetDebugLogging(void* instance, bool, std::size_t, const char* const*) {
  return with(instance, [](Instance&) { return true; });
}

Status fmi3EnterInitializationMode(void* pointer, bool, double, double start, bool stops, double stop) {
  return with(pointer, [&](Instance& instance) {
    if (start != 0) return instance.refuse("the start time of this FMU is 0");
    if (stops) instance.set_stop_time(stop);
    return instance.move(Phase::kInstantiated, Phase::kInitialization, "entering initialization mode");
  });
}
Status fmi3ExitInitializationMode(void* pointer) {
  return with(pointer, [](Instance& instance) {
    return instance.end_initialization(instance.event_mode ? Phase::kEvent : Phase::kStep);
  });
}
Status fmi3EnterEventMode(void* pointer) {
  return with(pointer, [](Instance& instance) {
    if (!instance.event_mode) return instance.refuse("it was instantiated without event mode");
    return instance.move(Phase::kStep, Phase::kEvent, "entering event mode");
  });
}
Status fmi3EnterStepMode(void* pointer) { return move(pointer, Phase::kEvent, Phase::kStep, "entering step mode"); }
Status fmi3UpdateDiscreteStates(void* pointer, bool* update, bool* terminate, bool* nominals, bool* values,
                                bool* next_defined, double* next) {
  return with(pointer, [&](Instance& instance) {
    if (instance.get_phase() != Phase::kEvent) return instance.refuse("updating discrete states needs event mode");
    for (bool* const flag : {update, terminate, nominals, values, next_defined})
      if (flag != nullptr) *flag = false;
    if (next != nullptr) *next = 0;
    return true;
  });
}
Status fmi3EvaluateDiscreteStates(void* pointer) {
  return with(pointer, [](Instance&) { return true; });
}
Status fmi3Terminate(void* pointer) { return unlatch::fmi::terminate(pointer); }
Status fmi3Reset(void* pointer) { return unlatch::fmi::reset(pointer); }

Status fmi3DoStep(void* pointer, double time, double size, bool, bool* event_needed, bool* terminate, bool* early,
                  double* last) {
  return with(pointer, [&](Instance& instance) {
    if (event_needed == nullptr || terminate == nullptr || early == nullptr || last == nullptr)
      return instance.refuse("fmi3DoStep: null");
    bool stopped = false;
    const bool good = instance.step(time, size, instance.early_return, stopped);
    constexpr double kSameTime = 1e-9;  // s
    *terminate = false;
    *last = instance.get_time();
    *early = good && stopped && *last < time + size - kSameTime;
    *event_needed = good && stopped && instance.event_mode;
    return good;
  });
}

Status fmi3GetFloat64(void* pointer, References references, std::size_t count, double* values,
                      std::size_t value_count) {
  return with(pointer, [&](Instance& instance) { return instance.get(references, count, values, value_count); });
}
Status fmi3SetFloat64(void* pointer, References references, std::size_t count, const double* values,
                      std::size_t value_count) {
  return with(pointer, [&](Instance& instance) { return instance.set(references, count, values, value_count); });
}

#define UNLATCH_FMI3_NO_VARIABLES(Type, Value)                                                    \
  Status fmi3Get##Type(void* pointer, References, std::size_t count, Value*, std::size_t) {       \
    return access_none(pointer, count);                                                           \
  }                                                                                               \
  Status fmi3Set##Type(void* pointer, References, std::size_t count, Value const*, std::size_t) { \
    return access_none(pointer, count);                                                           \
  }
UNLATCH_FMI3_NO_VARIABLES(Float32, float)
UNLATCH_FMI3_NO_VARIABLES(Int8, std::int8_t)
UNLATCH_FMI3_NO_VARIABLES(UInt8, std::uint8_t)
UNLATCH_FMI3_NO_VARIABLES(Int16, std::int16_t)
UNLATCH_FMI3_NO_VARIABLES(UInt16, std::uint16_t)
UNLATCH_FMI3_NO_VARIABLES(Int32, std::int32_t)
UNLATCH_FMI3_NO_VARIABLES(UInt32, std::uint32_t)
UNLATCH_FMI3_NO_VARIABLES(Int64, std::int64_t)
UNLATCH_FMI3_NO_VARIABLES(UInt64, std::uint64_t)
UNLATCH_FMI3_NO_VARIABLES(Boolean, bool)
using Text = const char*;
UNLATCH_FMI3_NO_VARIABLES(String, Text)
Status fmi3GetBinary(void* pointer, References, std::size_t count, std::size_t*, const std::uint8_t**, std::size_t) {
  return access_none(pointer, count);
}
Status fmi3SetBinary(void* pointer, References, std::size_t count, const std::size_t*, const std::uint8_t* const*,
                     std::size_t) {
  return access_none(pointer, count);
}
Status fmi3GetClock(void* pointer, References, std::size_t count, bool*) { return access_none(pointer, count); }
Status fmi3SetClock(void* pointer, References, std::size_t count, const bool*) { return access_none(pointer, count); }

// --- States

Status fmi3GetFMUState(void* pointer, void** state) { return unlatch::fmi::get_state(pointer, state); }
Status fmi3SetFMUState(void* pointer, void* state) { return unlatch::fmi::set_state(pointer, state); }
Status fmi3FreeFMUState(void* pointer, void** state) { return unlatch::fmi::free_state(pointer, state); }
Status fmi3SerializedFMUStateSize(void* pointer, void* state, std::size_t* size) {
  return unlatch::fmi::get_state_size(pointer, state, size);
}
Status fmi3SerializeFMUState(void* pointer, void* state, std::uint8_t* bytes, std::size_t size) {
  return unlatch::fmi::serialize_state(pointer, state, bytes, size);
}
Status fmi3DeserializeFMUState(void* pointer, const std::uint8_t* bytes, std::size_t size, void** state) {
  return unlatch::fmi::deserialize_state(pointer, bytes, size, state);
}

// --- What is not offered

#define UNLATCH_FMI3_REFUSED(Name, ...) \
  Status fmi3##Name(void* pointer __VA_OPT__(, ) __VA_ARGS__) { return refuse(pointer, "fmi3" #Name); }
UNLATCH_FMI3_REFUSED(GetNumberOfVariableDependencies, std::uint32_t, std::size_t*)
UNLATCH_FMI3_REFUSED(GetVariableDependencies, std::uint32_t, std::size_t*, std::uint32_t*, std::size_t*, int*,
                     std::size_t)
UNLATCH_FMI3_REFUSED(GetDirectionalDerivative, References, std::size_t, References, std::size_t, const double*,
                     std::size_t, double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetAdjointDerivative, References, std::size_t, References, std::size_t, const double*, std::size_t,
                     double*, std::size_t)
UNLATCH_FMI3_REFUSED(EnterConfigurationMode)
UNLATCH_FMI3_REFUSED(ExitConfigurationMode)
UNLATCH_FMI3_REFUSED(GetIntervalDecimal, References, std::size_t, double*, int*)
UNLATCH_FMI3_REFUSED(GetIntervalFraction, References, std::size_t, std::uint64_t*, std::uint64_t*, int*)
UNLATCH_FMI3_REFUSED(GetShiftDecimal, References, std::size_t, double*)
UNLATCH_FMI3_REFUSED(GetShiftFraction, References, std::size_t, std::uint64_t*, std::uint64_t*)
UNLATCH_FMI3_REFUSED(SetIntervalDecimal, References, std::size_t, const double*)
UNLATCH_FMI3_REFUSED(SetIntervalFraction, References, std::size_t, const std::uint64_t*, const std::uint64_t*)
UNLATCH_FMI3_REFUSED(SetShiftDecimal, References, std::size_t, const double*)
UNLATCH_FMI3_REFUSED(SetShiftFraction, References, std::size_t, const std::uint64_t*, const std::uint64_t*)
UNLATCH_FMI3_REFUSED(EnterContinuousTimeMode)
UNLATCH_FMI3_REFUSED(CompletedIntegratorStep, bool, bool*, bool*)
UNLATCH_FMI3_REFUSED(SetTime, double)
UNLATCH_FMI3_REFUSED(SetContinuousStates, const double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetContinuousStateDerivatives, double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetEventIndicators, double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetContinuousStates, double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetNominalsOfContinuousStates, double*, std::size_t)
UNLATCH_FMI3_REFUSED(GetNumberOfEventIndicators, std::size_t*)
UNLATCH_FMI3_REFUSED(GetNumberOfContinuousStates, std::size_t*)
UNLATCH_FMI3_REFUSED(GetOutputDerivatives, References, std::size_t, const std::int32_t*, double*, std::size_t)
UNLATCH_FMI3_REFUSED(ActivateModelPartition, std::uint32_t, double)

}  // extern "C"
