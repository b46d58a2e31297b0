// Calls that both versions of FMI share: statuses, types that no variable has, states.
#pragma once

#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "library/fmi/instance.h"

namespace unlatch::fmi {

// Category of a message in the importer's log, by the names that the standards recommend.
constexpr const char* get_category(Status status) { return status == kWarning ? "logStatusWarning" : "logStatusError"; }

// Calls a function of a valid instance that returns true or false.
template <class Function>
Status with(void* pointer, const Function& function) noexcept {
  Instance* const instance = find_instance(pointer);
  if (instance == nullptr) return kError;
  try {
    return function(*instance) ? instance->take_status() : kError;
  } catch (const std::exception& error) {
    instance->refuse(error.what());
    return kError;
  }
}

// Refuses a function that is not supported.
Status refuse(void* pointer, const char* function) noexcept;
// Accesses `count` variables of another type than Float64 (Real).
Status access_none(void* pointer, std::size_t count) noexcept;
// Moves from one phase to another; terminates; resets.
Status move(void* pointer, Instance::Phase from, Instance::Phase to, const char* call) noexcept;
Status terminate(void* pointer) noexcept;
Status reset(void* pointer) noexcept;

// Functions on states, by the standards' rules: an existing state is reused.
Status get_state(void* pointer, void** state) noexcept;
Status set_state(void* pointer, const void* state) noexcept;
Status free_state(void* pointer, void** state) noexcept;
Status get_state_size(void* pointer, const void* state, std::size_t* size) noexcept;
Status serialize_state(void* pointer, const void* state, void* bytes, std::size_t size) noexcept;
Status deserialize_state(void* pointer, const void* bytes, std::size_t size, void** state) noexcept;

}  // namespace unlatch::fmi
