#include "hil/study/campaign/samples/result_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>

#include "hil/scenario/text/count.h"

namespace unlatch::hil {
namespace {

// Little-endian numbers, as on all supported machines.
constexpr char kMagic[8] = {'U', 'N', 'L', 'C', 'A', 'M', 'P', '1'};

struct Header {
  char magic[8];
  std::uint64_t fingerprint;
  std::uint32_t inputs, values;
  std::uint64_t checksum;
};

[[noreturn]] void fail(const std::string& path, const std::string& what) { throw ResultError(path + ": " + what); }

bool read_whole(int file, char* to, std::size_t count, std::uint64_t at) {
  while (count > 0) {
    const ssize_t got = pread(file, to, count, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    at += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

bool write_whole(int file, const char* from, std::size_t count, std::uint64_t at) {
  while (count > 0) {
    const ssize_t put = pwrite(file, from, count, static_cast<off_t>(at));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    from += put;
    at += static_cast<std::uint64_t>(put);
    count -= static_cast<std::size_t>(put);
  }
  return true;
}

}  // namespace

ResultFile::~ResultFile() {
  if (file_ >= 0) close(file_);
}

ResultFile::ResultFile(ResultFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      path_(std::move(other.path_)),
      shape_(other.shape_),
      samples_(std::move(other.samples_)),
      places_(std::move(other.places_)),
      end_(other.end_) {}

ResultFile ResultFile::create(const std::string& path, const ResultShape& shape) {
  ResultFile file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666), path);
  if (file.file_ < 0) fail(path, std::string("it cannot be written: ") + std::strerror(errno));
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.fingerprint = shape.fingerprint;
  header.inputs = shape.inputs;
  header.values = shape.values;
  header.checksum = calc_checksum({reinterpret_cast<const char*>(&header), offsetof(Header, checksum)});
  if (!write_whole(file.file_, reinterpret_cast<const char*>(&header), sizeof header, 0))
    fail(path, std::string("it cannot be written: ") + std::strerror(errno));
  file.shape_ = shape;
  file.end_ = sizeof header;
  return file;
}

ResultFile ResultFile::open(const std::string& path, bool writable) {
  ResultFile file(::open(path.c_str(), (writable ? O_RDWR : O_RDONLY) | O_CLOEXEC), path);
  if (file.file_ < 0) fail(path, std::string("it cannot be opened: ") + std::strerror(errno));
  Header header{};
  const auto* const bytes = reinterpret_cast<const char*>(&header);
  if (!read_whole(file.file_, reinterpret_cast<char*>(&header), sizeof header, 0) ||
      std::memcmp(header.magic, kMagic, sizeof kMagic) != 0 ||
      header.checksum != calc_checksum({bytes, offsetof(Header, checksum)}))
    fail(path, "this is no file of a campaign's results");
  file.shape_ = {header.fingerprint, header.inputs, header.values};
  file.scan(writable);
  return file;
}

void ResultFile::scan(bool writable) {
  struct stat status {};
  if (fstat(file_, &status) != 0) fail(path_, std::strerror(errno));
  const std::size_t bytes = get_record_bytes(shape_);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  end_ = sizeof(Header);
  std::vector<char> record(end_ + bytes <= size ? bytes : 0);  // a forged header may demand more memory than there is
  samples_.reserve(size / bytes);
  places_.reserve(size / bytes);
  for (std::uint64_t at = end_; at + bytes <= size; at += bytes) {
    if (!read_whole(file_, record.data(), bytes, at)) fail(path_, std::strerror(errno));
    const std::optional<SampleRecord> whole = decode_record(shape_, record);
    if (!whole) continue;
    samples_.push_back(whole->sample);
    places_.push_back(at);
    end_ = at + bytes;
  }
  if (writable && ftruncate(file_, static_cast<off_t>(end_)) != 0)
    fail(path_, std::string("it cannot be written: ") + std::strerror(errno));
}

SampleRecord ResultFile::read(std::size_t index) const {
  std::vector<char> buffer(get_record_bytes(shape_));
  if (!read_whole(file_, buffer.data(), buffer.size(), places_.at(index))) fail(path_, "it cannot be read");
  std::optional<SampleRecord> record = decode_record(shape_, buffer);
  if (!record) fail(path_, "it changed while it was read");
  return *std::move(record);
}

void ResultFile::read_numbers(std::size_t record, std::size_t first, std::span<double> to) const {
  const std::uint64_t begin = places_.at(record) + get_number_place(first);
  if (!read_whole(file_, reinterpret_cast<char*>(to.data()), to.size_bytes(), begin)) fail(path_, "it cannot be read");
}

void ResultFile::append(const SampleRecord& record) {
  std::vector<char> buffer(get_record_bytes(shape_));
  encode_record(shape_, record, buffer);
  if (!write_whole(file_, buffer.data(), buffer.size(), end_)) {
    const std::string why = std::strerror(errno);
    if (ftruncate(file_, static_cast<off_t>(end_)) != 0) fail(path_, "it cannot be written: " + why);
    fail(path_, "it cannot be written: " + why + "; " + "it has " + count(samples_.size(), "sample"));
  }
  samples_.push_back(record.sample);
  places_.push_back(end_);
  end_ += buffer.size();
}

}  // namespace unlatch::hil
