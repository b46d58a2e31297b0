#include "tools/fmu/zip_file.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

namespace unlatch::fmu {
namespace {

constexpr std::size_t kEndLength = 22, kLongestComment = 65535, kMemberLength = 46, kLocalLength = 30;
constexpr std::uint64_t kEnd = 0x06054b50, kMember = 0x02014b50, kLocal = 0x04034b50;
constexpr std::uint64_t kEncrypted = 1, kStored = 0, kDeflated = 8;

// A relative path that stays inside: no "..", no drive.
bool is_inside(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find_first_of(std::string(":\0", 2)) != std::string::npos)
    return false;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    if (name.compare(begin, end - begin, "..") == 0) return false;
    begin = end + 1;
  }
  return true;
}

std::string inflate_raw(const char* packed, std::size_t packed_length, std::size_t length, const std::string& name) {
  std::string made(length, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw FmuError(name + ": no memory to unpack it");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed));
  stream.avail_in = static_cast<uInt>(packed_length);
  stream.next_out = reinterpret_cast<Bytef*>(made.data());
  stream.avail_out = static_cast<uInt>(length);
  const int result = inflate(&stream, Z_FINISH);
  const bool whole = result == Z_STREAM_END && stream.total_out == length;
  inflateEnd(&stream);
  if (!whole) throw FmuError(name + ": its compressed data are damaged");
  return made;
}

}  // namespace

ZipFile::ZipFile(std::string bytes) : bytes_(std::move(bytes)) {
  const char* const none = "it is no zip file, or not whole";
  if (bytes_.size() < kEndLength) throw FmuError(none);
  std::size_t end = bytes_.size() - kEndLength;
  const std::size_t last = end > kLongestComment ? end - kLongestComment : 0;
  while (end > last && get(end, 4) != kEnd) --end;
  if (get(end, 4) != kEnd) throw FmuError(none);
  const std::uint64_t count = get(end + 10, 2);
  std::size_t at = get(end + 16, 4);
  std::size_t length = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    add_member(at, length);
    at += kMemberLength + get(at + 28, 2) + get(at + 30, 2) + get(at + 32, 2);
  }
}

void ZipFile::add_member(std::size_t at, std::size_t& length) {
  if (get(at, 4) != kMember) throw FmuError("its directory is damaged");
  const std::size_t name_length = get(at + 28, 2);
  if (bytes_.size() - at < kMemberLength + name_length) throw FmuError("its directory is damaged");
  std::string name = bytes_.substr(at + kMemberLength, name_length);
  std::replace(name.begin(), name.end(), '\\', '/');  // some programs on Windows write them, against the standard
  if (!is_inside(name)) throw FmuError("a member is called '" + name + "', which leads out of the FMU's folder");
  if (name.back() == '/') return;
  const std::uint64_t method = get(at + 10, 2);
  if ((get(at + 8, 2) & kEncrypted) != 0) throw FmuError(name + ": it is encrypted");
  if (method != kStored && method != kDeflated)
    throw FmuError(name + ": compressed by method " + std::to_string(method) + "; 0 and 8 (deflate) can be read");
  const Member member{get(at + 42, 4), get(at + 20, 4), get(at + 24, 4), static_cast<std::uint32_t>(get(at + 16, 4)),
                      method == kDeflated};
  length += member.length;
  if (length > kMostBytes) throw FmuError("unpacked it would be larger than 1 GiB");
  if (!members_.emplace(name, member).second) throw FmuError(name + ": it is there twice");
}

std::string ZipFile::read(const std::string& name) const {
  const auto found = members_.find(name);
  if (found == members_.end()) throw FmuError(name + ": it is not in the zip file");
  const Member& member = found->second;
  if (get(member.offset, 4) != kLocal) throw FmuError(name + ": its place in the zip file is wrong");
  const std::size_t begin = member.offset + kLocalLength + get(member.offset + 26, 2) + get(member.offset + 28, 2);
  if (begin > bytes_.size() || bytes_.size() - begin < member.packed ||
      (!member.deflated && member.packed != member.length))
    throw FmuError(name + ": it is not whole");
  std::string made = member.deflated ? inflate_raw(bytes_.data() + begin, member.packed, member.length, name)
                                     : bytes_.substr(begin, member.length);
  if (crc32_z(0, reinterpret_cast<const Bytef*>(made.data()), made.size()) != member.crc)
    throw FmuError(name + ": its checksum is wrong");
  return made;
}

std::uint64_t ZipFile::get(std::size_t at, int bytes) const {
  if (at > bytes_.size() || bytes_.size() - at < static_cast<std::size_t>(bytes))
    throw FmuError("its directory is damaged");
  std::uint64_t number = 0;
  for (int i = bytes - 1; i >= 0; --i)
    number = number << 8 | static_cast<unsigned char>(bytes_[at + static_cast<std::size_t>(i)]);
  return number;
}

}  // namespace unlatch::fmu
