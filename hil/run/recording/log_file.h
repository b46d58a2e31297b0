// LCM event log as a file, readable by LCM's own tools. LCM's library is not used, for two reasons: every byte is
// covered by a checksum, and a reader of damaged files must bound their lengths.
//
//   event   = sync word, number, timestamp in microseconds, lengths, channel, data; big-endian
//   sealed  = an event on a channel that begins with kSealPrefix; its data ends in a CRC-64 of every byte of the file
//             since the previous seal, that event's header included
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

inline constexpr std::string_view kSealPrefix = "UNLATCH_LOG_";

// Error: a log cannot be opened or written, or is none; what() has the file, the place and the remedy.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Error of the environment, not of the log: it cannot be created or written.
class LogWriteError : public LogError {
 public:
  using LogError::LogError;
};

// CRC-64/XZ, to be continued from a previous result.
[[nodiscard]] std::uint64_t calc_crc64(std::span<const std::uint8_t> bytes, std::uint64_t crc = 0) noexcept;

class LogFileWriter {
 public:
  // Creates or replaces the file; an empty path means one without a name that vanishes with the writer. `name`: its
  // name in messages, if not the path. Throws LogWriteError.
  explicit LogFileWriter(const std::string& path, const std::string& name = "");
  ~LogFileWriter() { flush(); }
  LogFileWriter(const LogFileWriter&) = delete;
  LogFileWriter& operator=(const LogFileWriter&) = delete;

  // Appends an event; sealed if its channel begins with kSealPrefix. It goes to the file with others, whole events at a
  // time. False after a failed write (disk full): nothing more is written, so that the log has an early end and no gap,
  // and get_error() has the reason.
  bool append(std::int64_t timestamp_us, std::string_view channel, std::span<const std::uint8_t> data);
  // Writes the first event's data anew, once it has been flushed: as many bytes, and it is not sealed.
  bool amend_first(std::span<const std::uint8_t> data);
  // Hands the appended events to the operating system: from then on they survive the process.
  bool flush();
  // Hands them to the disk: from then on they survive the machine.
  bool sync();
  [[nodiscard]] const std::string& get_error() const { return error_; }

  // Stream of a nameless file, rewound, to read it back. Nothing may be appended afterwards.
  [[nodiscard]] std::FILE* rewind();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  bool fail();

  std::string name_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<std::uint8_t> pending_;  // appended, not yet written
  std::uint64_t crc_ = 0;
  std::int64_t number_ = 0;
  std::size_t first_data_ = 0;  // place of the first event's data in the file
  std::string error_;
};

struct LogEvent {
  std::int64_t timestamp_us = 0;
  std::string channel;
  std::vector<std::uint8_t> data;  // without the checksum, if sealed
  bool sealed = false;
};

class LogFileReader {
 public:
  explicit LogFileReader(const std::string& path);  // throws LogError
  // Reads from a stream that stays the caller's; `name` is for messages.
  LogFileReader(std::FILE* stream, std::string name);

  enum class Result {
    kEvent,
    kEnd,        // the file ends between two events
    kTruncated,  // the file ends inside an event: its writer was killed, or a length is damaged
    kDamaged,    // invalid event or checksum mismatch
  };
  // Reads into the memory of `event`. After any result but kEvent, get_offset() is the place of the failure or the end.
  [[nodiscard]] Result next(LogEvent& event);
  [[nodiscard]] std::int64_t get_offset() const { return offset_; }
  [[nodiscard]] const std::string& get_name() const { return name_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> owned_;
  std::FILE* file_;
  std::string name_;
  std::uint64_t crc_ = 0;
  std::int64_t offset_ = 0;  // place of the next event
};

}  // namespace unlatch::hil
