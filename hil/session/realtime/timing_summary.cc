#include "hil/session/realtime/timing_summary.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxBins = 4096;

// The numbers of each record in their order, for both directions.
template <class Summary, class Pass>
void pass_numbers(Summary& s, Pass&& pass) {
  for (auto* value : {&s.count, &s.min, &s.p50, &s.p90, &s.p99, &s.p999, &s.p9999, &s.p99999, &s.max}) pass(*value);
}
template <class Timing, class Pass>
void pass_counts(Timing& t, Pass&& pass) {
  for (auto* value : {&t.overruns, &t.slipped_ns, &t.skipped_outputs, &t.late_commands, &t.late_answers, &t.unanswered,
                      &t.dropped, &t.resent, &t.unused_commands}) {
    pass(*value);
  }
  for (auto& count : t.overrun_causes) pass(count);
  for (auto& count : t.rejected) pass(count);
}
template <class Worst, class Pass>
void pass_overrun(Worst& o, Pass&& pass) {
  auto& t = o.timing;
  for (auto* value : {&t.tick, &t.wakeup_ns, &t.input_ns, &t.step_ns, &t.output_ns, &o.late_ns, &o.page_faults,
                      &o.faults_read, &o.preemptions}) {
    pass(*value);
  }
}

void put(ByteWriter& out, const DurationSummary& summary) {
  pass_numbers(summary, [&out](std::int64_t value) { out.put_i64(value); });
  out.put_u32(static_cast<std::uint32_t>(summary.bins.size()));
  for (const DurationSummary::Bin& bin : summary.bins) {
    out.put_i64(bin.upper_ns);
    out.put_i64(bin.count);
  }
}

void get(ByteReader& in, DurationSummary& summary) {
  pass_numbers(summary, [&in](std::int64_t& value) { value = in.get_i64(); });
  const std::uint32_t bins = in.get_u32();
  summary.bins.clear();
  for (std::uint32_t i = 0; i < bins && i < kMaxBins && in.get_remaining() > 0; ++i) {
    DurationSummary::Bin& bin = summary.bins.emplace_back();
    bin.upper_ns = in.get_i64();
    bin.count = in.get_i64();
  }
}

}  // namespace

std::optional<HeldUpBy> to_held_up_by(std::int32_t number) noexcept {
  if (number < 0 || number > static_cast<std::int32_t>(HeldUpBy::kWarmUp)) return std::nullopt;
  return static_cast<HeldUpBy>(number);
}

void put(ByteWriter& out, const TimingSummary& timing) {
  for (const DurationSummary* summary : {&timing.step, &timing.wakeup, &timing.turnaround, &timing.round_trip}) {
    put(out, *summary);
  }
  pass_counts(timing, [&out](std::int64_t value) { out.put_i64(value); });
  out.put_u32(static_cast<std::uint32_t>(timing.worst_overruns.size()));
  for (const Overrun& overrun : timing.worst_overruns) {
    pass_overrun(overrun, [&out](std::int64_t value) { out.put_i64(value); });
    out.put_i32(overrun.timing.substeps);
    out.put_i32(static_cast<std::int32_t>(overrun.timing.held_up_by));
    out.put_i32(static_cast<std::int32_t>(overrun.cause));
  }
}

void get(ByteReader& in, TimingSummary& timing) {
  for (DurationSummary* summary : {&timing.step, &timing.wakeup, &timing.turnaround, &timing.round_trip}) {
    get(in, *summary);
  }
  pass_counts(timing, [&in](std::int64_t& value) { value = in.get_i64(); });
  const std::uint32_t count = in.get_u32();
  timing.worst_overruns.clear();
  for (std::uint32_t i = 0; i < count && i < TimingSummary::kWorst; ++i) {
    Overrun& overrun = timing.worst_overruns.emplace_back();
    pass_overrun(overrun, [&in](std::int64_t& value) { value = in.get_i64(); });
    overrun.timing.substeps = in.get_i32();
    overrun.timing.held_up_by = to_held_up_by(in.get_i32()).value_or(HeldUpBy::kNothing);
    const std::int32_t cause = in.get_i32();
    const bool known = cause >= 0 && cause < static_cast<std::int32_t>(kOverrunCauses);
    overrun.cause = known ? static_cast<OverrunCause>(cause) : OverrunCause::kStep;
  }
}

}  // namespace unlatch::hil
