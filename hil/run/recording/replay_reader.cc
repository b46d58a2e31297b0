#include "hil/run/recording/replay_reader.h"

#include "hil/session/messages/event_names.h"

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

// The reason why the first event is on the channel `found`, not on `wanted`.
std::string explain_other_kind(const std::string& found, std::string_view wanted) {
  if (wanted == kHeaderChannel && found == kCheckpointChannel) {
    return "is a checkpoint, not a recording; go on from it with `unlatch run --resume`";
  }
  if (wanted == kCheckpointChannel && found == kHeaderChannel) {
    return "is a recording, not a checkpoint; write one with `unlatch run --checkpoint`";
  }
  return "is an LCM log, but not a recording: it begins with a message on " + found +
         "; record with `unlatch hil --log` or `unlatch run --log`";
}

// The reason why there is no first event.
const char* explain_no_header(Result result) {
  if (result == Result::kEnd) return "is empty, not a recording";
  if (result == Result::kTruncated) return "ends before its header is complete; nothing can be replayed";
  return "is not a recording of unlatch, or its header is damaged (no intact LCM event at its start)";
}

}  // namespace

LogHeader read_header(LogFileReader& file, std::string_view channel) {
  const auto refuse = [&file](const std::string& why) { throw LogError(file.get_name() + ": " + why); };
  LogEvent event;
  const Result result = file.next(event);
  if (result != Result::kEvent) refuse(explain_no_header(result));
  if (event.channel != channel) refuse(explain_other_kind(event.channel, channel));
  LogHeader header;
  const bool readable = decode(event.data, header);
  if (readable && header.version != kLogVersion) {
    refuse("has log version " + std::to_string(header.version) + "; this program reads version " +
           std::to_string(kLogVersion) + "; use the program that wrote it");
  }
  if (!readable) refuse("has a header that cannot be read");
  if (header.schema_hash != kSchemaHash) {
    refuse("was written by " + header.program + " with message schema " + to_hex(header.schema_hash) +
           "; this program has " + to_hex(kSchemaHash) + "; use the program that wrote it");
  }
  return header;
}

RecordingReader::RecordingReader(LogFileReader file)
    : header(read_header(file, kHeaderChannel)), file_(std::move(file)), next_tick_(header.first_tick) {}

bool RecordingReader::stop(std::string why, bool is_damage) {
  shortfall = std::move(why);
  damaged = is_damage;
  return false;
}

void RecordingReader::keep_message() {
  EventMessage event;
  StateMessage state;
  if (event_.channel == get_channel(MessageKind::kEvent)) {
    if (!decode(event_.data, event) || !is_of_session(event)) return;
    if (is_notice(event)) notices.push_back(event);
    if (events.size() < kMostEvents)
      events.push_back(event);
    else
      ++events_left_out;
  } else if (keeps_states && event_.channel == get_channel(MessageKind::kState)) {
    if (decode(event_.data, state) && is_well_formed(state)) states.push_back(state);
  }
}

bool RecordingReader::next(LogTick& tick) {
  states.clear();
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
      received = tick.received;
      return true;
    }
    if (event_.channel == kEndChannel) {
      if (!decode(event_.data, end.emplace())) {
        end.reset();
        return stop("its last record at " + place + " cannot be read", true);
      }
      received = end->received;
    } else {
      keep_message();
    }
  }
  return false;
}

}  // namespace unlatch::hil
