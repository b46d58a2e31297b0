// The host's locale kept out: it decides the decimal point of printf and strtod, which messages and readers below use.
#pragma once

#include <clocale>

namespace unlatch::library {

// While it lives, this thread's C functions use the locale "C", whatever setlocale() the host has called. Other threads
// are not affected.
class ClassicLocale {
 public:
  ClassicLocale() noexcept : before_(get_classic() != locale_t{} ? uselocale(get_classic()) : locale_t{}) {}
  ClassicLocale(const ClassicLocale&) = delete;
  ClassicLocale& operator=(const ClassicLocale&) = delete;
  ~ClassicLocale() {
    if (before_ != locale_t{}) uselocale(before_);
  }

 private:
  static locale_t get_classic() noexcept {
    static const locale_t classic = newlocale(LC_ALL_MASK, "C", locale_t{});  // never freed
    return classic;
  }
  const locale_t before_;
};

}  // namespace unlatch::library
