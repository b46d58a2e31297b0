#include "hil/replay_reader.h"

#include "hil/executive_notices.h"

namespace unlatch::hil {
namespace {

using Result = LogFileReader::Result;

std::string to_hex(std::int64_t value) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text(16, '0');
  auto bits = static_cast<std::uint64_t>(value);
  for (auto digit = text.rbegin(); digit != text.rend(); ++digit, bits >>= 4) *digit = kDigits[bits & 15];
  return text;
}

}  // namespace

RecordingReader::RecordingReader(LogFileReader file) : file_(std::move(file)) {
  const std::string& name = file_.get_name();
  const Result result = file_.next(event_);
  if (result == Result::kEnd) throw LogError(name + ": is empty, not a recording");
  if (result == Result::kTruncated)
    throw LogError(name + ": ends before its header is complete; nothing can be replayed");
  if (result == Result::kDamaged) {
    throw LogError(name +
                   ": is not a recording of unlatch, or its header is damaged (no intact LCM event at its start)");
  }
  if (event_.channel != kHeaderChannel) {
    throw LogError(name + ": is an LCM log, but not a recording: it begins with a message on " + event_.channel +
                   "; record with `unlatch hil --log` or `unlatch run --log`");
  }
  const bool readable = decode(event_.data, header);
  if (readable && header.version != kLogVersion) {
    throw LogError(name + ": has log version " + std::to_string(header.version) + "; this program reads version " +
                   std::to_string(kLogVersion) + "; replay it with the program that wrote it");
  }
  if (!readable) throw LogError(name + ": has a header that cannot be read");
  if (header.schema_hash != kSchemaHash) {
    throw LogError(name + ": was recorded by " + header.program + " with message schema " + to_hex(header.schema_hash) +
                   "; this program has " + to_hex(kSchemaHash) + "; replay it with the program that wrote it");
  }
}

bool RecordingReader::stop(std::string why, bool is_damage) {
  shortfall = std::move(why);
  damaged = is_damage;
  return false;
}

void RecordingReader::keep_notice() {
  Event event;
  if (decode(event_.data, event) && is_notice(event)) notices.push_back(event);
}

bool RecordingReader::next(LogTick& tick) {
  while (!end && shortfall.empty()) {
    const Result result = file_.next(event_);
    const std::string place = "byte " + std::to_string(file_.get_offset());
    if (result == Result::kEnd) return stop("it ends without its last record (the simulator was killed?)", false);
    if (result == Result::kTruncated) return stop("it ends inside the record at " + place, false);
    if (result == Result::kDamaged) return stop("it is damaged at or before the record at " + place, true);

    if (event_.channel == kTickChannel) {
      if (!decode(event_.data, tick)) return stop("its tick record at " + place + " cannot be read", true);
      if (tick.tick != next_tick_ && tick.unrecorded == 0) {
        return stop("tick " + std::to_string(tick.tick) + " follows tick " + std::to_string(next_tick_ - 1), true);
      }
      next_tick_ = tick.tick + 1;
      return true;
    }
    if (event_.channel == kEndChannel) {
      if (!decode(event_.data, end.emplace())) {
        end.reset();
        return stop("its last record at " + place + " cannot be read", true);
      }
    } else if (event_.channel == get_channel(MessageKind::kEvent)) {
      keep_notice();
    }
  }
  return false;
}

}  // namespace unlatch::hil
