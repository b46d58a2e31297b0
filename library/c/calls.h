// Code that the functions of unlatch.h share: refusal of null arguments; opening, use and closing of handles.
#pragma once

#include <memory>
#include <string>

#include "library/c/errors.h"
#include "library/c/options.h"

namespace unlatch::library {

// Refuses a null argument. `what`: its name.
inline unlatch_status refuse_null(const char* what) noexcept {
  return guard([&] { return fail(UNLATCH_ERROR_ARGUMENT, std::string("null: ") + what); });
}

// Opens a handle on the object that `make(options)` returns as a unique_ptr. `make` may return null after it has set
// this thread's error; the result is then UNLATCH_ERROR_ARGUMENT. Its exceptions become errors with their place in
// `source`.
template <class Handle, class Make>
unlatch_status make_handle(HandleKind kind, const ErrorSource& source, const unlatch_options* options, Handle** handle,
                           const Make& make) noexcept {
  const auto open_made = [&]() -> unlatch_status {
    LoadOptions read;
    if (!read_options(options, read)) return UNLATCH_ERROR_ARGUMENT;
    auto made = make(read);
    if (made == nullptr) return UNLATCH_ERROR_ARGUMENT;
    void* const opened = open_handle(kind, made.get());
    if (opened == nullptr) return fail(UNLATCH_ERROR_MEMORY, "16,384 handles are open; close some");
    (void)made.release();
    *handle = static_cast<Handle*>(opened);
    return UNLATCH_OK;
  };
  return guard(open_made, source);
}

// Calls a function that returns a status with the object of a handle.
template <class Object, class Function>
unlatch_status with(HandleKind kind, const void* handle, const Function& function) noexcept {
  const Access access(kind, handle);
  if (!access) return fail(access);
  return guard([&] { return function(access.get<Object>()); });
}

// Closes a handle and deletes its object.
template <class Object>
unlatch_status close_handle(HandleKind kind, const void* handle) noexcept {
  Access access(kind, handle);
  if (!access) return fail(access);
  delete &access.get<Object>();
  access.close();
  return UNLATCH_OK;
}

}  // namespace unlatch::library
