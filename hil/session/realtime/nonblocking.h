// Mark of functions that the cyclic thread runs between two deadlines: no allocation, lock, or system call that may
// wait. Built with clang's RealtimeSanitizer (preset `rtsan`) a call beneath such a function that breaks the promise
// ends the program with a stack trace; other compilers ignore the mark. It stands after `noexcept`.
#pragma once

#if defined(__clang__) && __clang_major__ >= 20
#define UNLATCH_NONBLOCKING [[clang::nonblocking]]
#else
#define UNLATCH_NONBLOCKING
#endif

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>

#include <optional>
#define UNLATCH_HAS_RTSAN 1
#endif
#endif

namespace unlatch::hil {

// Permission for this thread to wait beneath a marked function, as long as the object lives: at paces other than real
// time, for space in the recorder's ring, or for the middleware.
class MayWait {
 public:
  explicit MayWait([[maybe_unused]] bool may = true) noexcept {
#if defined(UNLATCH_HAS_RTSAN)
    if (may) scope_.emplace();
#endif
  }

 private:
#if defined(UNLATCH_HAS_RTSAN)
  std::optional<__rtsan::ScopedDisabler> scope_;
#endif
};

}  // namespace unlatch::hil
