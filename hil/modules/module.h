// Modules: shared libraries with parts that few runs need and that are slow to load (collision geometry, middleware,
// readers of others' files). Each is loaded when it is first used, from the folder UNLATCH_MODULES relative to the
// program's own, and stays. Where this code is in a shared library, from the folder `unlatch` beside that.
#pragma once

#include <stdexcept>

namespace unlatch::hil {

// A module is not where it should be, or does not fit; what() is a sentence with its path.
class ModuleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The address of an extern "C" function of a module ("unlatch-fcl"). Throws ModuleError. Thread-safe; takes
// milliseconds the first time.
void* find_in_module(const char* module, const char* function);

// Function: the type of that function.
template <typename Function>
Function* find_function(const char* module, const char* function) {
  return reinterpret_cast<Function*>(find_in_module(module, function));
}

}  // namespace unlatch::hil
