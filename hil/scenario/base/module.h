// Modules: shared libraries with parts that few runs need and that are slow to load (collision geometry, middleware,
// readers of other programs' files). Each is loaded at its first use, from the folder UNLATCH_MODULES relative to the
// program's folder, and stays loaded. If this code is in a shared library, the folder is `unlatch` beside it.
#pragma once

#include <stdexcept>

namespace unlatch::hil {

// Error of a module that is missing or does not fit; what() is a sentence with its path.
class ModuleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Address of an extern "C" function of a module ("unlatch-import"). Throws ModuleError. Thread-safe; takes milliseconds
// the first time.
void* find_in_module(const char* module, const char* function);

// `Function`: the type of that function.
template <typename Function>
Function* find_function(const char* module, const char* function) {
  return reinterpret_cast<Function*>(find_in_module(module, function));
}

}  // namespace unlatch::hil
