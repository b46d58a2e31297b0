// Conversion of big-endian numbers and texts to and from bytes. The reader checks every length: past the end it returns
// zeros and is_complete() is false.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& to) : to_(to) {}

  void put_u32(std::uint32_t value) { put(value, 4); }
  void put_i32(std::int32_t value) { put(static_cast<std::uint32_t>(value), 4); }
  void put_i64(std::int64_t value) { put(static_cast<std::uint64_t>(value), 8); }
  void put_f64(double value) { put(std::bit_cast<std::uint64_t>(value), 8); }
  void put_bytes(std::span<const std::uint8_t> bytes) { to_.insert(to_.end(), bytes.begin(), bytes.end()); }
  void put_text(std::string_view text) {
    put_u32(static_cast<std::uint32_t>(text.size()));
    to_.insert(to_.end(), text.begin(), text.end());
  }

 private:
  void put(std::uint64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) to_.push_back(static_cast<std::uint8_t>(value >> shift));
  }
  std::vector<std::uint8_t>& to_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> from) : from_(from) {}

  std::uint32_t get_u32() { return static_cast<std::uint32_t>(get(4)); }
  std::int32_t get_i32() { return static_cast<std::int32_t>(get_u32()); }
  std::int64_t get_i64() { return static_cast<std::int64_t>(get(8)); }
  double get_f64() { return std::bit_cast<double>(get(8)); }
  std::string get_text() {
    const std::uint32_t length = get_u32();
    if (!take(length)) return {};
    return {reinterpret_cast<const char*>(from_.data()) + at_ - length, length};
  }

  [[nodiscard]] std::size_t get_remaining() const { return from_.size() - at_; }
  // True if every number so far was present, and no bytes are left.
  [[nodiscard]] bool is_complete() const { return good_ && at_ == from_.size(); }

 private:
  bool take(std::size_t bytes) {
    if (bytes > get_remaining()) {
      good_ = false;
      at_ = from_.size();
      return false;
    }
    at_ += bytes;
    return true;
  }
  std::uint64_t get(std::size_t bytes) {
    if (!take(bytes)) return 0;
    std::uint64_t value = 0;
    for (std::size_t i = at_ - bytes; i < at_; ++i) value = value << 8 | from_[i];
    return value;
  }
  std::span<const std::uint8_t> from_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace unlatch::hil
