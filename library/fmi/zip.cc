#include "library/fmi/zip.h"

#include <array>

namespace unlatch::fmi {
namespace {

std::uint32_t calc_crc32(const std::string& bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      made[i] = i;
      for (int k = 0; k < 8; ++k) made[i] = (made[i] & 1u) != 0 ? 0xEDB88320u ^ (made[i] >> 1) : made[i] >> 1;
    }
    return made;
  }();
  std::uint32_t crc = ~0u;
  for (const char c : bytes) crc = table[(crc ^ static_cast<unsigned char>(c)) & 0xFFu] ^ (crc >> 8);
  return ~crc;
}

}  // namespace

void Zip::add(const std::string& name, const std::string& bytes) {
  std::string header;
  put(header, {20, 0, 0, 0, 0x21}, 2);  // version, flags, stored, time, 1 January 1980
  put(header, {calc_crc32(bytes), bytes.size(), bytes.size()}, 4);
  put(header, {name.size(), 0}, 2);
  put(directory_, {0x02014b50}, 4);
  put(directory_, {(3u << 8) | 20}, 2);  // made on Unix
  directory_ += header;
  put(directory_, {0, 0, 0}, 2);
  put(directory_, {0100644ull << 16, file_.size()}, 4);
  directory_ += name;
  put(file_, {0x04034b50}, 4);
  file_ += header + name + bytes;
  ++count_;
}

std::string Zip::finish() {
  std::string end;
  put(end, {0x06054b50}, 4);
  put(end, {0, 0, count_, count_}, 2);
  put(end, {directory_.size(), file_.size()}, 4);
  put(end, {0}, 2);
  return file_ + directory_ + end;
}

void Zip::put(std::string& to, std::initializer_list<std::uint64_t> numbers, int bytes) {
  for (const std::uint64_t number : numbers)
    for (int i = 0; i < bytes; ++i) to += static_cast<char>(number >> (8 * i) & 0xFFu);
}

}  // namespace unlatch::fmi
