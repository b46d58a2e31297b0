// Corrected checksums of recordings and checkpoints, which no fuzzer guesses: a target reads the original bytes, and
// once more with valid checksums, so that the data behind them are read as well.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/run/recording/log_file.h"
#include "hil/session/messages/bytes.h"

namespace unlatch::fuzz {

// Bytes of a log with valid checksums, as far as they are events.
inline std::vector<std::uint8_t> reseal(std::span<const std::uint8_t> log) {
  constexpr std::size_t kHead = 28, kLengths = 20, kSeal = 8;
  std::vector<std::uint8_t> bytes(log.begin(), log.end());
  std::uint64_t crc = 0;
  for (std::size_t at = 0; bytes.size() - at >= kHead;) {
    hil::ByteReader lengths(std::span<const std::uint8_t>(bytes).subspan(at + kLengths, 8));
    const std::size_t channel = lengths.get_u32(), data = lengths.get_u32(), left = bytes.size() - at - kHead;
    if (channel > left || data > left - channel) break;
    const std::string name(bytes.begin() + static_cast<std::ptrdiff_t>(at + kHead),
                           bytes.begin() + static_cast<std::ptrdiff_t>(at + kHead + channel));
    const std::size_t end = at + kHead + channel + data;
    if (!name.starts_with(hil::kSealPrefix)) {
      crc = hil::calc_crc64(std::span(bytes).subspan(at, end - at), crc);
    } else if (data >= kSeal) {
      crc = hil::calc_crc64(std::span(bytes).subspan(at, end - kSeal - at), crc);
      for (std::size_t i = 0; i < kSeal; ++i) bytes[end - kSeal + i] = static_cast<std::uint8_t>(crc >> (8 * (7 - i)));
      crc = 0;
    }
    at = end;
  }
  return bytes;
}

// Bytes as a file; fmemopen() refuses an empty buffer.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::uint8_t> bytes)
      : bytes_(bytes.begin(), bytes.end()), file_(fmemopen(bytes_.data(), bytes_.size(), "rb")) {
    if (!file_) throw hil::LogError("fmemopen");
  }
  [[nodiscard]] hil::LogFileReader open() { return {file_.get(), "memory"}; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::vector<std::uint8_t> bytes_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace unlatch::fuzz
