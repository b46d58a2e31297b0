// A plan image from a file, at a place where it may lie, in memory that ends where it does, so that sanitizers see what
// is read behind it.
#pragma once

#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "unlatch/plan_image.h"

namespace unlatch::test {

class ImageMemory {
 public:
  explicit ImageMemory(std::span<const char> bytes) : size_(bytes.size()) {
    memory_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{kImageAlignment}));
    if (size_ > 0) std::memcpy(memory_, bytes.data(), size_);
  }
  ~ImageMemory() { ::operator delete (memory_, std::align_val_t{kImageAlignment}); }
  ImageMemory(const ImageMemory&) = delete;
  ImageMemory& operator=(const ImageMemory&) = delete;
  [[nodiscard]] std::span<std::byte> get() const { return {memory_, size_}; }

 private:
  std::byte* memory_;
  std::size_t size_;
};

inline std::vector<char> read_image(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (bytes.empty()) throw std::runtime_error(file + ": cannot be read");
  return bytes;
}

}  // namespace unlatch::test
