#include "hil/run/recording/log_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "hil/session/messages/bytes.h"

namespace unlatch::hil {
namespace {

constexpr std::uint32_t kSync = 0xEDA1DA01;  // sync word of LCM's event logs
constexpr std::size_t kHeadBytes = 4 + 8 + 8 + 4 + 4;
constexpr std::size_t kCrcBytes = 8;
constexpr std::size_t kWriteBytes = 64 << 10;  // size of one write
constexpr std::uint32_t kMaxChannel = 63;      // LCM's own limit
constexpr std::uint32_t kMaxData = 16 << 20;   // far beyond any record of ours; bounds the memory for a damaged length

constexpr std::array<std::uint64_t, 256> build_table() {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t i = 0; i < 256; ++i) {
    std::uint64_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xC96C5795D7870F42u : 0u);
    table[i] = value;
  }
  return table;
}
constexpr std::array<std::uint64_t, 256> kCrcTable = build_table();

bool is_sealed(std::string_view channel) { return channel.starts_with(kSealPrefix); }

std::string explain(const std::string& path, const char* what) {
  return path + ": " + what + ": " + std::strerror(errno);
}

}  // namespace

std::uint64_t calc_crc64(std::span<const std::uint8_t> bytes, std::uint64_t crc) noexcept {
  crc = ~crc;
  for (const std::uint8_t byte : bytes) crc = kCrcTable[(crc ^ byte) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

// --- Writing --------------------------------------------------------------------------------------------------------

LogFileWriter::LogFileWriter(const std::string& path, const std::string& name)
    : name_(!name.empty()  ? name
            : path.empty() ? "temporary log"
                           : path) {
  file_.reset(path.empty() ? std::tmpfile() : std::fopen(path.c_str(), "wb"));
  if (!file_) throw LogWriteError(explain(name_, "cannot be created"));
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // pending_ is the buffer
}

bool LogFileWriter::fail() {
  if (error_.empty()) error_ = explain(name_, "cannot be written");
  return false;
}

bool LogFileWriter::append(std::int64_t timestamp_us, std::string_view channel, std::span<const std::uint8_t> data) {
  if (!error_.empty()) return false;
  const bool sealed = is_sealed(channel);
  const std::size_t begin = pending_.size();
  ByteWriter out(pending_);
  out.put_u32(kSync);
  out.put_i64(number_++);
  out.put_i64(timestamp_us);
  out.put_u32(static_cast<std::uint32_t>(channel.size()));
  out.put_u32(static_cast<std::uint32_t>(data.size() + (sealed ? kCrcBytes : 0)));
  out.put_bytes({reinterpret_cast<const std::uint8_t*>(channel.data()), channel.size()});
  if (number_ == 1) first_data_ = pending_.size();
  out.put_bytes(data);
  crc_ = calc_crc64(std::span(pending_).subspan(begin), crc_);
  if (sealed) {
    out.put_i64(static_cast<std::int64_t>(crc_));
    crc_ = 0;
  }
  return pending_.size() < kWriteBytes || flush();
}

bool LogFileWriter::flush() {
  if (!error_.empty()) return false;
  const bool written = std::fwrite(pending_.data(), 1, pending_.size(), file_.get()) == pending_.size();
  pending_.clear();
  return written || fail();
}

bool LogFileWriter::amend_first(std::span<const std::uint8_t> data) {
  if (!flush()) return false;
  const auto place = static_cast<off_t>(first_data_);
  return pwrite(fileno(file_.get()), data.data(), data.size(), place) == static_cast<ssize_t>(data.size()) || fail();
}

bool LogFileWriter::sync() { return flush() && (fsync(fileno(file_.get())) == 0 || fail()); }

std::FILE* LogFileWriter::rewind() {
  std::rewind(file_.get());
  return file_.get();
}

// --- Reading --------------------------------------------------------------------------------------------------------

LogFileReader::LogFileReader(const std::string& path) : name_(path) {
  owned_.reset(std::fopen(path.c_str(), "rb"));
  if (!owned_) throw LogError(explain(path, "cannot be opened"));
  struct stat status {};
  if (fstat(fileno(owned_.get()), &status) == 0 && S_ISDIR(status.st_mode)) {
    throw LogError(path + ": is a folder, not a log");
  }
  file_ = owned_.get();
}

LogFileReader::LogFileReader(std::FILE* stream, std::string name) : file_(stream), name_(std::move(name)) {}

LogFileReader::Result LogFileReader::next(LogEvent& event) {
  std::array<std::uint8_t, kHeadBytes> head;
  const std::size_t got = std::fread(head.data(), 1, head.size(), file_);
  if (got == 0) return Result::kEnd;
  ByteReader in({head.data(), got});
  if (got >= 4 && in.get_u32() != kSync) return Result::kDamaged;
  if (got < kHeadBytes) return Result::kTruncated;
  in.get_i64();  // the event's number
  event.timestamp_us = in.get_i64();
  const std::uint32_t channel_length = in.get_u32(), data_length = in.get_u32();
  if (channel_length == 0 || channel_length > kMaxChannel || data_length > kMaxData) return Result::kDamaged;

  event.channel.resize(channel_length);
  if (std::fread(event.channel.data(), 1, channel_length, file_) != channel_length) return Result::kTruncated;
  event.data.resize(data_length);
  if (std::fread(event.data.data(), 1, data_length, file_) != data_length) return Result::kTruncated;

  crc_ = calc_crc64(head, crc_);
  crc_ = calc_crc64({reinterpret_cast<const std::uint8_t*>(event.channel.data()), channel_length}, crc_);
  event.sealed = is_sealed(event.channel);
  if (event.sealed) {
    if (data_length < kCrcBytes) return Result::kDamaged;
    const std::span<const std::uint8_t> data = event.data;
    ByteReader seal(data.last(kCrcBytes));
    if (calc_crc64(data.first(data_length - kCrcBytes), crc_) != static_cast<std::uint64_t>(seal.get_i64())) {
      return Result::kDamaged;
    }
    event.data.resize(data_length - kCrcBytes);
    crc_ = 0;
  } else {
    crc_ = calc_crc64(event.data, crc_);
  }
  offset_ += static_cast<std::int64_t>(kHeadBytes + channel_length + data_length);
  return Result::kEvent;
}

}  // namespace unlatch::hil
