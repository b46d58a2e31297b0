// A line of text from texts and numbers, without a C library; printed when it ends.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernel/targets/port.h"

namespace unlatch::target {

class TextLine {
 public:
  TextLine& operator<<(const char* text) {
    while (*text != 0 && length_ + 1 < sizeof(text_)) text_[length_++] = *text++;
    return *this;
  }
  TextLine& operator<<(std::uint64_t number) {
    char digits[21]{};
    std::size_t begin = sizeof(digits) - 1;
    do {
      digits[--begin] = static_cast<char>('0' + number % 10);
      number /= 10;
    } while (number != 0);
    return *this << digits + begin;
  }
  TextLine& add_hash(std::uint64_t hash) {
    char digits[17]{};
    for (int i = 0; i < 16; ++i) digits[i] = "0123456789abcdef"[(hash >> (60 - 4 * i)) & 15];
    return *this << digits;
  }
  ~TextLine() {
    text_[length_] = 0;
    write(text_);
  }

 private:
  char text_[256]{};
  std::size_t length_ = 0;
};

}  // namespace unlatch::target
