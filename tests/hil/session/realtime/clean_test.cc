// The cyclic thread between two deadlines: no heap memory, in every scenario, through events, latches, policies,
// overruns and rates; no first access to a page. RealtimeSanitizer (tools/rtsan) checks locks and waits as well.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/executive_timing.h"
#include "hil/session/realtime/real_time.h"
#include "tests/hil/scenario/scenario_support.h"
#include "tests/hil/session/session_support.h"
#include "tests/support/malloc_guard.h"

namespace unlatch::test::clean_test {
namespace {

using hil::Pace;

constexpr std::int64_t kMs = 1'000'000;  // ns

// Ticks that come after `pause`, every tenth of them late; counts the allocations and page faults of the thread between
// its first and last tick.
class CountingTicks final : public hil::TickSource {
 public:
  explicit CountingTicks(std::chrono::microseconds pause) : TickSource(kMs), pause_(pause) {}
  void restart(std::int64_t) noexcept override {}
  bool wait(const std::atomic<bool>& stop) noexcept override {
    if (!first_) {
      first_.emplace();
      counts_ = hil::read_thread_counts();
    }
    allocations =
        first_->get();  // 0 where a sanitizer has its own malloc; RealtimeSanitizer then ends the program itself
    page_faults = hil::read_thread_counts().page_faults - counts_.page_faults;
    if (pause_.count() > 0) std::this_thread::sleep_for(pause_);
    awake_ns_ = hil::get_monotonic_ns();
    due_ns_ = ++ticks % 10 == 0 ? awake_ns_ - 10 * kMs : awake_ns_;
    return !stop;
  }
  std::int64_t slip(std::int64_t) noexcept override { return 1; }
  std::int64_t calc_behind(std::int64_t) const noexcept override { return 0; }

  long allocations = -1;
  std::int64_t page_faults = -1, ticks = 0;

 private:
  const std::chrono::microseconds pause_;
  std::optional<AllocationCount> first_;
  hil::ThreadCounts counts_;
};

hil::LogEnd run(const hil::Scenario& scenario, std::int64_t last_tick, CountingTicks& ticks) {
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions options;
  options.pace = Pace::kRealtime;
  options.session = 1;
  options.last_tick = last_tick;
  options.timing = scenario.timing;
  options.timing.per_tick = true;
  options.ticks = &ticks;
  hil::RingConnection connection(256, 256);
  hil::Recorder recorder(make_path("log"),
                         hil::build_log_header(scenario, *simulation, options.pace, 1, options.last_tick));
  hil::LogEnd end = hil::Executive(*simulation, connection, recorder, scenario.name, options).run();
  recorder.close(end);
  return end;
}

std::int64_t calc_last_tick(const hil::Scenario& scenario) { return std::llround(scenario.until / scenario.dt); }

constexpr std::int64_t kLatched = 10'000;  // ticks after which the array's panels are latched

void expect_nothing_from_the_heap(std::int64_t most) {
  int scenarios = 0;
  const std::filesystem::recursive_directory_iterator begin(UNLATCH_SOURCE_DIR "/hil/scenarios");
  for (auto file = begin; file != std::filesystem::recursive_directory_iterator(); ++file) {
    if (file.depth() != 1 || !is_scenario_file(file->path())) continue;
    SCOPED_TRACE(file->path());
    const hil::Scenario scenario = hil::load_scenario(file->path());
    const bool is_late = file->path().parent_path().filename() == "array";  // its latches come last
    CountingTicks ticks(std::chrono::microseconds(0));
    const hil::LogEnd end = run(scenario, std::min(is_late ? kLatched : most, calc_last_tick(scenario)), ticks);
    EXPECT_EQ(end.status, hil::RunStatus::kDone) << end.message;
    EXPECT_EQ(ticks.allocations, 0);
    ++scenarios;
  }
  EXPECT_GE(scenarios, 5);
}

// The boosters' events are in the first 1000 ticks.
TEST(CyclicThread, TakesNothingFromTheHeapInAnyScenario) { expect_nothing_from_the_heap(2'500); }
TEST(LongCyclicThread, TakesNothingFromTheHeapInTheFirstTenThousandTicksOfAnyScenario) {
  expect_nothing_from_the_heap(kLatched);
}

TEST(CyclicThread, TakesNothingFromTheHeapWhilePoliciesAndOverrunsAct) {
  for (const char* overruns : {"catch_up", "slip", "skip_output"}) {
    for (const char* policy : {"hold", "zero", "safe"}) {
      FakeParticipant::Habits habits;
      habits.dies_at = 20;
      habits.twice = true;
      CountingTicks ticks(std::chrono::milliseconds(1));
      const SessionResult result =
          run_session(Pace::kRealtime, habits, make_path("log"),
                      {std::string("timing={per_tick: true, overruns: ") + overruns + ", states: {every: 2}}",
                       std::string("flight_software.policy=") + policy, "step.until=0.2"},
                      true, &ticks);
      EXPECT_EQ(result.end.status, hil::RunStatus::kDone) << result.end.message;
      EXPECT_GT(result.end.timing.overruns, 0);
      EXPECT_EQ(ticks.allocations, 0) << overruns << ", " << policy;
    }
  }
}

TEST(CyclicThread, TakesNothingFromTheHeapWhenAGuestJoinsLate) {
  const std::vector<std::string> overrides{"step.until=0.2"};
  hil::HelloAckMessage guest;
  guest.schema_hash = hil::kSchemaHash;
  guest.protocol = hil::kProtocolVersion;
  guest.participant = FakeParticipant::kId + 1;
  guest.dt_ns = 1'000'000;
  guest.model_hash = static_cast<std::int64_t>(
      hil::build_simulation(hil::load_scenario_text(kSessionScenario, "session.yaml", overrides))->plan().get_hash());
  hil::set_name(guest.name, "a guest whose name is as long as names may be ..");
  FakeParticipant::Habits habits;
  habits.mischief = [guest](std::int64_t tick, hil::RingConnection& connection, std::int64_t session) mutable {
    guest.session = session;
    if (tick == 20) connection.deliver(guest);
  };
  CountingTicks ticks(std::chrono::milliseconds(1));
  const SessionResult result = run_session(Pace::kRealtime, habits, make_path("log"), overrides, true, &ticks);
  EXPECT_EQ(result.end.status, hil::RunStatus::kDone) << result.end.message;
  EXPECT_EQ(std::count(result.notices.begin(), result.notices.end(), "participant.joined"), 2);
  EXPECT_EQ(ticks.allocations, 0);
}

TEST(CyclicThread, MeetsNoPageForTheFirstTime) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer meets pages of its own";
  for (const std::string& refused : hil::request_real_time()) {
    if (refused.find("mlockall") != std::string::npos) GTEST_SKIP() << refused;
  }
  const hil::Scenario scenario = hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/reference.yaml");
  CountingTicks ticks(std::chrono::microseconds(0));
  (void)run(scenario, 2000, ticks);
  EXPECT_EQ(ticks.page_faults, 0);
}

#if defined(UNLATCH_HAS_RTSAN)
[[gnu::noinline]] void allocate_in_the_cycle() noexcept UNLATCH_NONBLOCKING {
  volatile auto bait = std::make_unique<int>(1).release();
  (void)bait;
}
TEST(CyclicThreadDeathTest, TheSanitizerFindsABait) { EXPECT_DEATH(allocate_in_the_cycle(), "RealtimeSanitizer"); }
#endif

}  // namespace
}  // namespace unlatch::test::clean_test
