// Errors of the C library: the errors of a thread's latest failed call, and the boundary that no exception crosses.
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include "hil/scenario/yaml/scenario_error.h"
#include "library/c/classic_locale.h"
#include "library/c/handles.h"
#include "library/include/unlatch.h"

namespace unlatch::library {

// Text of a scenario's file, for naming the key at a place in it.
struct ErrorSource {
  std::string file, text;  // of the main file, as messages name it; text: empty if `file` must be read
};

// All of these functions replace this thread's errors and return the status.
unlatch_status fail(unlatch_status status, std::string_view text, std::string_view file = "",
                    std::string_view key = "") noexcept;
unlatch_status fail(const hil::ScenarioError& error, const ErrorSource& source) noexcept;
// Reports a refused handle.
unlatch_status fail(const Access& access) noexcept;
// Reports the exception being handled.
unlatch_status fail_of_exception(const ErrorSource& source) noexcept;

// Path of the key at a line and column of a YAML text: "bodies.core.mass"; "" if there is none.
std::string find_key(const std::string& text, int line, int column);

// Calls a function that returns a status, in the locale "C"; exceptions become errors.
template <class Function>
unlatch_status guard(const Function& function, const ErrorSource& source = {}) noexcept {
  const ClassicLocale locale;
  try {
    return function();
  } catch (...) {
    return fail_of_exception(source);
  }
}

}  // namespace unlatch::library
