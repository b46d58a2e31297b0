#include "hil/run/recording/log_format.h"

#include "hil/session/messages/bytes.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kChangeBytes = 4 + 4 + 4 + 8 + 8, kReceivedBytes = 4 + 8;
void put(ByteWriter& out, const std::vector<LogReceived>& list) {
  out.put_u32(static_cast<std::uint32_t>(list.size()));
  for (const LogReceived& one : list) {
    out.put_i32(one.value);
    out.put_f64(one.received);
  }
}

bool get(ByteReader& in, std::vector<LogReceived>& list) {
  list.clear();
  const std::size_t count = in.get_u32();
  if (count > in.get_remaining() / kReceivedBytes) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t value = in.get_i32();
    list.push_back({value, in.get_f64()});
  }
  return true;
}

constexpr std::uint32_t kHasReceived = 1, kBeginsUnresolved = 2;

}  // namespace

void encode(const LogHeader& record, std::vector<std::uint8_t>& to) {
  to.clear();
  ByteWriter out(to);
  out.put_i32(record.version);
  out.put_i32(static_cast<std::int32_t>(record.pace));
  for (const std::int64_t value :
       {record.session, record.schema_hash, record.model_hash, record.first_tick, record.last_tick}) {
    out.put_i64(value);
  }
  out.put_f64(record.dt);
  for (const std::string* text :
       {&record.program, &record.compiler, &record.scenario_name, &record.scenario_path, &record.scenario_text}) {
    out.put_text(*text);
  }
  out.put_u32(static_cast<std::uint32_t>(record.overrides.size()));
  for (const std::string& text : record.overrides) out.put_text(text);
  out.put_u32(static_cast<std::uint32_t>(record.start.size()));
  for (const std::uint64_t word : record.start) out.put_i64(static_cast<std::int64_t>(word));
  out.put_u32((record.has_received ? kHasReceived : 0) | (record.begins_unresolved ? kBeginsUnresolved : 0));
}

bool decode(std::span<const std::uint8_t> from, LogHeader& record) {
  ByteReader in(from);
  record.version = in.get_i32();
  if (record.version != kLogVersion) return in.get_remaining() > 0;  // the rest is another version's
  const std::int32_t pace = in.get_i32();
  if (pace < 0 || pace > static_cast<std::int32_t>(Pace::kFast)) return false;
  record.pace = static_cast<Pace>(pace);
  for (std::int64_t* value :
       {&record.session, &record.schema_hash, &record.model_hash, &record.first_tick, &record.last_tick}) {
    *value = in.get_i64();
  }
  record.dt = in.get_f64();
  for (std::string* text :
       {&record.program, &record.compiler, &record.scenario_name, &record.scenario_path, &record.scenario_text}) {
    *text = in.get_text();
  }
  const std::uint32_t count = in.get_u32();
  record.overrides.clear();
  for (std::uint32_t i = 0; i < count && in.get_remaining() > 0; ++i) record.overrides.push_back(in.get_text());
  const std::size_t words = in.get_u32();
  record.start.clear();
  if (record.overrides.size() != count || in.get_remaining() != 8 * words + 4) return false;
  for (std::size_t i = 0; i < words; ++i) record.start.push_back(static_cast<std::uint64_t>(in.get_i64()));
  const std::uint32_t flags = in.get_u32();
  record.has_received = (flags & kHasReceived) != 0;
  record.begins_unresolved = (flags & kBeginsUnresolved) != 0;
  return in.is_complete() && flags <= (kHasReceived | kBeginsUnresolved);
}

void encode(const LogTick& record, std::vector<std::uint8_t>& to) {
  to.clear();
  ByteWriter out(to);
  out.put_i64(record.tick);
  out.put_i64(record.hash);
  out.put_i64(record.unrecorded);
  out.put_u32(static_cast<std::uint32_t>(record.changes.size()));
  for (const LogChange& change : record.changes) {
    out.put_i32(change.channel);
    out.put_i32(static_cast<std::int32_t>(change.cause));
    out.put_i32(change.participant);
    out.put_i64(change.sequence);
    out.put_f64(change.value);
  }
  put(out, record.received);
}

bool decode(std::span<const std::uint8_t> from, LogTick& record) {
  ByteReader in(from);
  record.tick = in.get_i64();
  record.hash = in.get_i64();
  record.unrecorded = in.get_i64();
  const std::size_t count = in.get_u32();
  record.changes.clear();
  if (count > in.get_remaining() / kChangeBytes) return false;
  for (std::size_t i = 0; i < count; ++i) {
    LogChange change;
    change.channel = in.get_i32();
    const std::int32_t cause = in.get_i32();
    if (cause < 0 || static_cast<std::size_t>(cause) >= kChangeCauseNames.size()) return false;
    change.cause = static_cast<ChangeCause>(cause);
    change.participant = in.get_i32();
    change.sequence = in.get_i64();
    change.value = in.get_f64();
    record.changes.push_back(change);
  }
  return get(in, record.received) && in.is_complete();
}

void encode(const TickTiming& record, std::vector<std::uint8_t>& to) {
  to.clear();
  ByteWriter out(to);
  for (const std::int64_t value : {record.tick, record.wakeup_ns, record.input_ns, record.step_ns, record.output_ns}) {
    out.put_i64(value);
  }
  out.put_i32(record.substeps);
  out.put_i32(static_cast<std::int32_t>(record.held_up_by));
}

bool decode(std::span<const std::uint8_t> from, TickTiming& record) {
  ByteReader in(from);
  for (std::int64_t* value : {&record.tick, &record.wakeup_ns, &record.input_ns, &record.step_ns, &record.output_ns}) {
    *value = in.get_i64();
  }
  record.substeps = in.get_i32();
  const std::optional<HeldUpBy> held_up_by = to_held_up_by(in.get_i32());
  record.held_up_by = held_up_by.value_or(HeldUpBy::kNothing);
  return in.is_complete() && held_up_by;
}

void encode(const LogEnd& record, std::vector<std::uint8_t>& to) {
  to.clear();
  ByteWriter out(to);
  out.put_i64(record.tick);
  out.put_i64(record.hash);
  out.put_i32(static_cast<std::int32_t>(record.status));
  out.put_i32(record.step_status);
  out.put_i32(record.joint);
  out.put_i64(record.unrecorded);
  out.put_i64(record.states_unrecorded);
  out.put_text(record.message);
  put(out, record.received);
  put(out, record.timing);
}

bool decode(std::span<const std::uint8_t> from, LogEnd& record) {
  ByteReader in(from);
  record.tick = in.get_i64();
  record.hash = in.get_i64();
  const std::int32_t status = in.get_i32();
  if (status < 0 || status > static_cast<std::int32_t>(RunStatus::kFaulted)) return false;
  record.status = static_cast<RunStatus>(status);
  record.step_status = in.get_i32();
  record.joint = in.get_i32();
  record.unrecorded = in.get_i64();
  record.states_unrecorded = in.get_i64();
  record.message = in.get_text();
  if (!get(in, record.received)) return false;
  get(in, record.timing);
  return in.is_complete();
}

std::string get_compiler() {
#if defined(__clang__)
  return "clang++ " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

}  // namespace unlatch::hil
