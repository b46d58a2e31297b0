// Overruns: each policy, the attribution, and the completeness of the recording. A scripted tick source decides the
// late ticks, so no fact depends on the machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <map>
#include <numeric>
#include <set>
#include <thread>

#include "hil/session/messages/event_names.h"
#include "hil/session/realtime/clock.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::overrun_test {
namespace {

using hil::Overrun;
using hil::OverrunCause;
using hil::Pace;
using hil::RunStatus;

constexpr std::int64_t kMs = 1'000'000;          // ns
constexpr std::int64_t kLate = 3'600'000 * kMs;  // an hour: far beyond any stall of the machine
const char* const kPatient = "flight_software.timeout=30";

// Ticks without waiting; those in `late` are an hour late, all others have an hour left.
class ScriptedTicks final : public hil::TickSource {
 public:
  explicit ScriptedTicks(std::set<std::int64_t> late, std::int64_t behind = 0)
      : TickSource(kMs), late_(std::move(late)), behind_(behind) {}
  void restart(std::int64_t) noexcept override {}
  bool wait(const std::atomic<bool>& stop) noexcept override {
    const bool late = late_.count(next_++) > 0;
    awake_ns_ = hil::get_monotonic_ns();
    due_ns_ = late ? awake_ns_ - kLate : awake_ns_ + kLate;
    latency_ns_ = late ? kLate : 0;
    return !stop;
  }
  std::int64_t slip(std::int64_t) noexcept override { return ++slips, 7; }
  std::int64_t calc_behind(std::int64_t) const noexcept override { return behind_; }
  int slips = 0;

 private:
  const std::set<std::int64_t> late_;
  const std::int64_t behind_;
  std::int64_t next_ = 0;
};

struct LogContent {
  std::vector<std::string> overruns;
  std::vector<std::int64_t> overrun_ticks;
  std::vector<hil::TickTiming> timings;
  std::optional<hil::LogEnd> end;
  int states = 0;
};

LogContent read_log(const std::string& path) {
  LogContent content;
  hil::LogFileReader reader(path);
  hil::LogEvent event;
  while (reader.next(event) == hil::LogFileReader::Result::kEvent) {
    hil::EventMessage message;
    hil::TickTiming timing;
    if (event.channel == hil::kTimingChannel && decode(event.data, timing)) content.timings.push_back(timing);
    if (event.channel == hil::kEndChannel && !decode(event.data, content.end.emplace())) content.end.reset();
    if (event.channel == "UNLATCH_STATE") ++content.states;
    if (event.channel != "UNLATCH_EVENT" || !decode(event.data, message)) continue;
    if (!hil::get_name(message.name).starts_with(hil::kOverrunPrefix)) continue;
    content.overruns.emplace_back(hil::get_name(message.name));
    content.overrun_ticks.push_back(message.tick);
  }
  return content;
}

std::int64_t count_all(const hil::DurationSummary& summary) {
  return std::accumulate(summary.bins.begin(), summary.bins.end(), std::int64_t{0},
                         [](std::int64_t sum, const auto& bin) { return sum + bin.count; });
}

TEST(Overruns, EachIsCountedLoggedPublishedAndAttributed) {
  const std::string log = make_path("log");
  ScriptedTicks ticks({3, 17, 49});
  const SessionResult result = run_session(Pace::kRealtime, {}, log, {kPatient}, true, &ticks);
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(result.end.timing.overruns, 3);
  EXPECT_EQ(result.end.timing.overrun_causes[static_cast<std::size_t>(OverrunCause::kLateWakeup)], 3);
  const LogContent content = read_log(log);
  EXPECT_THAT(content.overrun_ticks, testing::ElementsAre(3, 17, 49));
  EXPECT_THAT(content.overruns, testing::Each("overrun.late_wakeup"));
  ASSERT_TRUE(content.end);
  EXPECT_EQ(content.end->timing.overruns, 3);
  ASSERT_EQ(content.end->timing.worst_overruns.size(), 3u);
  EXPECT_GE(content.end->timing.worst_overruns[0].late_ns, content.end->timing.worst_overruns[2].late_ns);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Overruns, FailEndsTheRunAtTheFirst) {
  const std::string log = make_path("log");
  ScriptedTicks ticks({3, 17});
  const SessionResult result = run_session(Pace::kRealtime, {}, log, {kPatient, "timing.overruns=fail"}, true, &ticks);
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.tick, 4);
  EXPECT_THAT(result.end.message, testing::StartsWith("tick 3 overran its period (policy: fail)"));
  EXPECT_EQ(read_log(log).overruns.size(), 1u);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Overruns, CatchUpEndsTheRunBeyondItsBoundOnly) {
  for (const bool beyond : {false, true}) {
    ScriptedTicks ticks({5}, beyond ? 9 : 8);
    const SessionResult result =
        run_session(Pace::kRealtime, {}, "", {kPatient, "timing.overruns.catch_up=8"}, true, &ticks);
    EXPECT_EQ(result.end.status, beyond ? RunStatus::kAborted : RunStatus::kDone);
    EXPECT_EQ(result.end.tick, beyond ? 6 : 50);
  }
}

TEST(Overruns, SlipMovesTheTimeBaseAndAddsUpByHowMuch) {
  ScriptedTicks ticks({5, 6, 20});
  const SessionResult result = run_session(Pace::kRealtime, {}, "", {kPatient, "timing.overruns=slip"}, true, &ticks);
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(ticks.slips, 3);
  EXPECT_EQ(result.end.timing.slipped_ns, 21);
}

TEST(Overruns, SkipOutputLeavesOutTheStatesOfLateTicks) {
  std::map<std::int64_t, int> heard;
  const auto run = [&heard](const char* policy) {
    const hil::Scenario scenario =
        hil::load_scenario_text(kSessionScenario, "session.yaml", {policy, "flight_software.required=[]"});
    const auto simulation = hil::build_simulation(scenario);
    ScriptedTicks ticks({5, 6, 49});
    hil::ExecutiveOptions options;
    options.pace = Pace::kRealtime;
    options.last_tick = 50;
    options.timing = scenario.timing;
    options.ticks = &ticks;
    hil::RingConnection connection(256, 16);
    hil::Recorder recorder("", hil::build_log_header(scenario, *simulation, Pace::kRealtime, 1, 50));
    hil::LogEnd end = hil::Executive(*simulation, connection, recorder, scenario.name, options).run();
    recorder.close(end);
    hil::Message message;
    heard.clear();
    while (connection.take(message)) {
      if (message.kind == hil::MessageKind::kState) ++heard[message.state.tick];
    }
    return end;
  };
  EXPECT_EQ(run("timing.overruns=skip_output").timing.skipped_outputs, 2);
  EXPECT_EQ(heard.count(6) + heard.count(7), 0u);
  EXPECT_EQ(heard.size(), 49u);
  EXPECT_EQ(heard.count(50), 1u) << "the last is always said";
  EXPECT_EQ(run("timing.overruns=catch_up").timing.skipped_outputs, 0);
  EXPECT_EQ(heard.size(), 51u);
}

TEST(Overruns, AreAttributedToTheLargestPartAndToWhatInterruptedIt) {
  const auto attribute = [](auto&& change) {
    Overrun overrun;
    overrun.timing = {.tick = 1, .wakeup_ns = 10, .input_ns = 10, .step_ns = 10, .output_ns = 10, .substeps = 1};
    change(overrun);
    return hil::attribute(overrun);
  };
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.wakeup_ns = 99; }), OverrunCause::kLateWakeup);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.wakeup_ns = 99, o.timing.held_up_by = hil::HeldUpBy::kTickBefore; }),
            OverrunCause::kBacklog);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.wakeup_ns = 99, o.timing.held_up_by = hil::HeldUpBy::kWarmUp; }),
            OverrunCause::kWarmUp);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.wakeup_ns = 99, o.preemptions = 1; }), OverrunCause::kLateWakeup);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.input_ns = 99; }), OverrunCause::kInputs);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.step_ns = 99; }), OverrunCause::kStep);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.step_ns = 99, o.page_faults = 3; }), OverrunCause::kStep);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.step_ns = 99, o.timing.substeps = 4; }), OverrunCause::kEvents);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.output_ns = 99; }), OverrunCause::kOutputs);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.step_ns = 99, o.faults_read = 1; }), OverrunCause::kPageFaults);
  EXPECT_EQ(attribute([](Overrun& o) { o.timing.step_ns = 99, o.preemptions = 1; }), OverrunCause::kPreempted);
}

TEST(Overruns, CountsOfAnotherThreadAreThoseThatItReadsItself) {
  const hil::ThreadCounts before = hil::read_thread_counts();
  std::optional<hil::ThreadCounts> seen;
  const pid_t here = gettid();
  std::jthread([&] { seen = hil::read_thread_counts(here); }).join();
  const hil::ThreadCounts after = hil::read_thread_counts();
  ASSERT_TRUE(seen);
  EXPECT_GT(before.page_faults, 0);
  EXPECT_TRUE(before.page_faults <= seen->page_faults && seen->page_faults <= after.page_faults);
  EXPECT_TRUE(before.faults_read <= seen->faults_read && seen->faults_read <= after.faults_read);
  EXPECT_TRUE(before.preemptions <= seen->preemptions && seen->preemptions <= after.preemptions);
  EXPECT_FALSE(hil::read_thread_counts(0));
}

TEST(Overruns, WhatBefellTheThreadLongAgoExplainsNone) {
  const auto touch_fresh_pages = [] {
    constexpr std::size_t kBytes = 64 * 4096;
    void* pages = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    for (std::size_t i = 0; i < kBytes; i += 4096) static_cast<volatile char*>(pages)[i] = 1;
    munmap(pages, kBytes);
  };
  hil::Timing timing;
  timing.begin_counts();
  touch_fresh_pages();
  EXPECT_GE(timing.account_overrun({}, 1).page_faults, 64);
  EXPECT_LT(timing.account_overrun({}, 1).page_faults, 64) << "counted by the overrun before";
  touch_fresh_pages();
  timing.disregard(hil::read_thread_counts());
  EXPECT_LT(timing.account_overrun({}, 1).page_faults, 64) << "a watcher said that it was long ago";
  touch_fresh_pages();
  std::jthread([&] { timing.watch_counts(), timing.watch_counts(); }).join();
  EXPECT_LT(timing.account_overrun({}, 1).page_faults, 64) << "before the previous call";
  std::jthread([&] { timing.watch_counts(); }).join();
  touch_fresh_pages();
  std::jthread([&] { timing.watch_counts(); }).join();
  EXPECT_GE(timing.account_overrun({}, 1).page_faults, 64) << "after the previous call";
}

TEST(Overruns, OnlyTheWorstAreKeptAndInOrder) {
  hil::Timing timing;
  timing.begin_counts();
  for (std::int64_t i = 0; i < 100; ++i) timing.account_overrun({.tick = i}, (i * 37) % 100);
  const hil::TimingSummary summary = timing.summarize();
  ASSERT_EQ(summary.worst_overruns.size(), hil::TimingSummary::kWorst);
  for (std::size_t i = 0; i < summary.worst_overruns.size(); ++i) {
    EXPECT_EQ(summary.worst_overruns[i].late_ns, 99 - static_cast<std::int64_t>(i));
  }
  EXPECT_EQ(summary.overruns, 100);
}

TEST(Timing, EveryTicksAccountIsInTheRecordingIfAskedAndHistogramsAddUp) {
  for (const Pace pace : {Pace::kRealtime, Pace::kLockstep, Pace::kFast}) {
    const std::string log = make_path("log");
    const SessionResult result = run_session(pace, {}, log, {kPatient, "timing.per_tick=true"});
    EXPECT_EQ(result.end.status, RunStatus::kDone);
    const LogContent content = read_log(log);
    ASSERT_EQ(content.timings.size(), 50u);
    for (std::size_t i = 0; i < content.timings.size(); ++i) {
      EXPECT_EQ(content.timings[i].tick, static_cast<std::int64_t>(i));
      EXPECT_GT(content.timings[i].step_ns, 0);
      EXPECT_GE(content.timings[i].substeps, 1);
    }
    EXPECT_GT(content.timings[20].substeps, 1) << "at 20.5 ms the pod leaves";
    ASSERT_TRUE(content.end);
    EXPECT_EQ(count_all(content.end->timing.step), 50);
    EXPECT_EQ(count_all(content.end->timing.wakeup), pace == Pace::kRealtime ? 50 : 0);
    EXPECT_EQ(content.end->timing.step.max, result.end.timing.step.max);
    EXPECT_TRUE(replay_log(log).result.agrees());
  }
  const std::string log = make_path("log");
  run_session(Pace::kFast, {}, log);
  EXPECT_TRUE(read_log(log).timings.empty());
}

TEST(Timing, CommandsAndAnswersAreTimed) {
  const SessionResult result = run_session(Pace::kLockstep, {}, "", {kPatient});
  EXPECT_EQ(result.end.timing.round_trip.count, 50);
  EXPECT_EQ(result.end.timing.turnaround.count, 7) << "commands came for the ticks 0, 10, 15, 20, 30, 40, 45";
}

}  // namespace
}  // namespace unlatch::test::overrun_test
