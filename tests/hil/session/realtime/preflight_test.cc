// Preflight: findings on a machine that is described by files, and their verdicts.
#include "hil/session/realtime/preflight.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/watchdog.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::preflight_test {
namespace {

using Verdict = hil::PreflightCheck::Verdict;

hil::MachineFacts make_ideal() {
  hil::MachineFacts facts;
  facts.kernel = "6.1.0-rt7 #1 SMP PREEMPT_RT";
  facts.cpus = 4;
  facts.governors = {{"performance", 4}};
  facts.isolated_cpus = "2-3";
  facts.clock_source = "tsc";
  facts.timer_resolution_ns = 1;
  facts.memlock_bytes = -1;
  facts.rtprio = 99;
  facts.rt_runtime_us = -1;
  facts.rt_period_us = 1'000'000;
  facts.huge_pages = "madvise";
  facts.swap_kb = 0;
  facts.idle_exit_us = 2;
  facts.smt = false;
  facts.smi_count = 0;
  facts.core_stretch = 1;
  facts.interruptions_per_s = 0.5;
  facts.longest_interruption_ns = 9000;
  return facts;
}

const hil::PreflightCheck& find(const std::vector<hil::PreflightCheck>& checks, const std::string& name) {
  for (const auto& check : checks) {
    if (check.name == name) return check;
  }
  throw std::runtime_error("no check '" + name + "'");
}

TEST(Preflight, FindsNothingToMendOnAnIdealMachine) {
  for (const auto& check : hil::judge(make_ideal())) {
    EXPECT_EQ(check.verdict, Verdict::kGood) << check.name << ": " << check.found;
    EXPECT_TRUE(check.cost.empty() && check.mend.empty()) << check.name;
  }
}

TEST(Preflight, EverythingThatCostsSaysWhatAndHowToMendIt) {
  const auto spoil = [](const char* name, Verdict verdict, auto&& change) {
    hil::MachineFacts facts = make_ideal();
    change(facts);
    const auto checks = hil::judge(facts);
    const auto& check = find(checks, name);
    EXPECT_EQ(check.verdict, verdict) << name;
    EXPECT_FALSE(check.cost.empty()) << name;
    EXPECT_FALSE(check.mend.empty()) << name;
    for (const auto& other : checks) {
      EXPECT_EQ(other.verdict, other.name == name ? verdict : Verdict::kGood) << name << " spoils " << other.name;
    }
  };
  using Facts = hil::MachineFacts;
  spoil("kernel", Verdict::kCosts, [](Facts& f) { f.kernel = "6.1.0 #1 SMP PREEMPT_DYNAMIC"; });
  spoil("kernel", Verdict::kCosts, [](Facts& f) { f.kernel = "6.1.0 #1 SMP"; });
  spoil("governor", Verdict::kCosts, [](Facts& f) { f.governors["powersave"] = 1; });
  spoil("isolated CPUs", Verdict::kCosts, [](Facts& f) { f.isolated_cpus.clear(); });
  spoil("timer resolution", Verdict::kCosts, [](Facts& f) { f.timer_resolution_ns = 4'000'000; });
  spoil("clock source", Verdict::kCosts, [](Facts& f) { f.clock_source = "hpet"; });
  spoil("locked memory", Verdict::kMissing, [](Facts& f) { f.memlock_bytes = 8 << 20; });
  spoil("real-time priority", Verdict::kMissing, [](Facts& f) { f.rtprio = 0; });
  spoil("real-time throttling", Verdict::kCosts, [](Facts& f) { f.rt_runtime_us = 950'000; });
  spoil("transparent huge pages", Verdict::kCosts, [](Facts& f) { f.huge_pages = "always"; });
  spoil("idle states", Verdict::kCosts, [](Facts& f) { f.idle_exit_us = 200; });
  spoil("hyper-threading", Verdict::kCosts, [](Facts& f) { f.smt = true; });
  spoil("hyper-threading", Verdict::kCosts, [](Facts& f) { f.core_stretch = 2; });
  spoil("interruptions", Verdict::kCosts, [](Facts& f) { f.interruptions_per_s = 250; });
  spoil("below the kernel", Verdict::kCosts, [](Facts& f) { f.smi_count = 17; });
  spoil("below the kernel", Verdict::kCosts, [](Facts& f) { f.virtual_machine = true; });
}

TEST(Preflight, DeepIdleStatesCostNothingWhereARunMayHoldThemOff) {
  hil::MachineFacts facts = make_ideal();
  facts.idle_exit_us = 200;
  facts.may_forbid_idle = true;
  EXPECT_EQ(find(hil::judge(facts), "idle states").verdict, Verdict::kGood);
}

// A thread of higher priority takes the CPU for 3 ms out of 10; without privileges both have none, and share it.
// A script may be run: the shell accepts it.
void expect_valid(const std::string& script) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("fix" + std::to_string(getpid()));
  std::ofstream(file) << script;
  EXPECT_EQ(std::system(("sh -n " + file.string()).c_str()), 0) << script;
  std::filesystem::remove(file);
}

TEST(Preflight, AnIdealMachineNeedsNoCommands) {
  const std::string script = hil::print_fixes(make_ideal());
  EXPECT_NE(script.find("nothing to mend"), std::string::npos);
  EXPECT_EQ(script.find("echo"), std::string::npos);
  expect_valid(script);
}

TEST(Preflight, TheCommandsMendEachFindingAndNothingElse) {
  hil::MachineFacts facts = make_ideal();
  facts.kernel = "6.1.0 #1 SMP PREEMPT_DYNAMIC";
  facts.governors = {{"powersave", 4}};
  facts.isolated_cpus.clear();
  facts.huge_pages = "always";
  facts.memlock_bytes = 8 << 20;
  facts.rtprio = 0;
  facts.smi_count = 3;
  const std::string script = hil::print_fixes(facts, 2);
  for (const char* line :
       {"cpupower frequency-set -g performance", "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled",
        "@unlatch-bench - memlock unlimited", "@unlatch-bench - rtprio 99",
        "apt-get install --yes linux-image-rt-amd64",
        "isolcpus=managed_irq,domain,2 nohz_full=2 rcu_nocbs=2 irqaffinity=0-1,3", "--cpu 2", "update-grub",
        "# below the kernel: 3 system management interrupts"})
    EXPECT_NE(script.find(line), std::string::npos) << line << "\n" << script;
  for (const char* none : {"swapoff", "sched_rt_runtime_us", "idle-set", "nosmt", "tsc"})
    EXPECT_EQ(script.find(none), std::string::npos) << none;
  expect_valid(script);
}

TEST(Preflight, EveryFindingIsInTheScript) {
  hil::MachineFacts facts;  // of which nothing is known, or good
  facts.cpus = 1;           // none can be isolated
  facts.virtual_machine = true;
  const std::string script = hil::print_fixes(facts);
  for (const auto& check : hil::judge(facts)) {
    if (check.verdict == Verdict::kGood || check.mend.empty()) continue;
    EXPECT_NE(script.find("# " + check.name + ": "), std::string::npos) << check.name << "\n" << script;
  }
  EXPECT_EQ(script.find("isolcpus=m"), std::string::npos);
  EXPECT_EQ(script.find("\ncpupower frequency-set"), std::string::npos) << "nothing is known of the governor";
  expect_valid(script);
}

TEST(Preflight, TryingTheMachineNoticesWhoTakesTheCpu) {
  std::atomic<bool> begun{false};
  const std::jthread hog([&begun](const std::stop_token& stopping) {
    (void)hil::request_real_time({.priority = 90, .cpu = 0});
    begun = true;
    while (!stopping.stop_requested()) {
      const std::int64_t begin_ns = hil::get_monotonic_ns();
      while (hil::get_monotonic_ns() < begin_ns + 3'000'000) {
      }
      hil::sleep_until_ns(begin_ns + 10'000'000);
    }
  });
  while (!begun) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  hil::MachineFacts facts;
  (void)hil::try_machine(facts, 0, 0.2);
  EXPECT_GT(facts.longest_interruption_ns, 2'000'000);
  EXPECT_GT(facts.interruptions_per_s, 10);
  EXPECT_TRUE(facts.core_stretch.has_value());
}

TEST(Preflight, ReadsTheKernelsFiles) {
  const std::filesystem::path root = make_path("root");
  const auto write = [&root](const std::string& path, const std::string& text) {
    std::filesystem::create_directories((root / path).parent_path());
    std::ofstream(root / path) << text;
  };
  write("proc/sys/kernel/osrelease", "6.1.0-test\n");
  write("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian\n");
  write("sys/kernel/debug/sched/preempt", "none voluntary (full) lazy\n");
  write("sys/devices/system/cpu/isolated", "1\n");
  write("sys/devices/system/cpu/nohz_full", "(null)\n");
  write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "schedutil\n");
  for (const auto& [state, latency, disable] :
       {std::tuple{"0", "0", "0"}, std::tuple{"1", "12", "0"}, std::tuple{"2", "890", "1"}}) {
    const std::string folder = std::string("sys/devices/system/cpu/cpu0/cpuidle/state") + state;
    write(folder + "/latency", latency);
    write(folder + "/disable", disable);
  }
  write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  write("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n");
  write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
  write("proc/meminfo", "MemTotal: 8 kB\nSwapTotal:       2048 kB\n");
  write("proc/stat", "cpu  1 2 3 4 5 6 7 800 0 0\n");
  write("proc/cpuinfo", "vendor_id\t: AuthenticAMD\nflags\t\t: fpu hypervisor sse\n");
  const hil::MachineFacts facts = hil::read_machine_facts(root);
  std::filesystem::remove_all(root);
  EXPECT_EQ(facts.kernel, "6.1.0-test #1 SMP PREEMPT_DYNAMIC Debian");
  EXPECT_EQ(facts.preemption_mode, "full");
  EXPECT_EQ(facts.isolated_cpus, "1");
  EXPECT_EQ(facts.full_tickless_cpus, "");
  EXPECT_EQ(facts.governors, (std::map<std::string, int>{{"schedutil", 1}}));
  EXPECT_EQ(facts.idle_exit_us, 12) << "state 2 is disabled";
  EXPECT_EQ(facts.clock_source, "hpet");
  EXPECT_EQ(facts.huge_pages, "madvise");
  EXPECT_EQ(facts.rt_runtime_us, 950'000);
  EXPECT_EQ(facts.swap_kb, 2048);
  EXPECT_EQ(facts.stolen_ms, 800 * 1000 / sysconf(_SC_CLK_TCK));
  EXPECT_TRUE(facts.virtual_machine);
}

TEST(Preflight, WhatCannotBeFoundOutIsSaidToBeUnknown) {
  const auto checks = hil::judge(hil::read_machine_facts("/no/such/folder"));
  for (const char* name :
       {"clock source", "transparent huge pages", "swap", "idle states", "interruptions", "below the kernel"}) {
    EXPECT_EQ(find(checks, name).verdict, Verdict::kUnknown) << name;
  }
}

TEST(RealTime, RefusalsAreNamedAndTheRestIsGranted) {
  std::jthread([] {
    const auto refused = hil::request_real_time({.priority = 80, .cpu = 100'000});
    ASSERT_FALSE(refused.empty());
    EXPECT_TRUE(refused[0].starts_with("the cyclic thread is not bound to CPU 100000: ")) << refused[0];
    for (const std::string& text : refused) EXPECT_NE(text.find('('), std::string::npos) << "no remedy: " << text;
  }).join();
  EXPECT_FALSE(hil::request_priority(1000).empty());
}

// With permission idle states are prevented; without it a message describes the consequences.
TEST(RealTime, DeepIdleStatesAreHeldOffOrThatIsRefusedByName) {
  const hil::ShallowIdle awake;
  const bool may = access("/dev/cpu_dma_latency", W_OK) == 0;
  EXPECT_EQ(awake.get_refusal().empty(), may) << awake.get_refusal();
  if (may) {
    std::int32_t wanted_us = -1;
    std::ifstream("/dev/cpu_dma_latency", std::ios::binary).read(reinterpret_cast<char*>(&wanted_us), sizeof wanted_us);
    EXPECT_EQ(wanted_us, 0);
  }
  EXPECT_EQ(awake.get_refusal().find("(grant writing it") == std::string::npos, may) << awake.get_refusal();
}

TEST(Watchdog, ReportsASilenceOnceAndNoSignOfLife) {
  std::atomic<std::int64_t> beats{0};
  std::atomic<int> reports{0};
  static constexpr std::int64_t kLimit_ns = 30'000'000;
  const hil::Watchdog watchdog(beats, kLimit_ns, 0, [&reports](std::int64_t silent_ns) {
    EXPECT_GE(silent_ns, kLimit_ns);
    ++reports;
  });
  const auto wait_for = [&reports](int wanted) {
    while (reports < wanted) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  wait_for(1);  // a hang here is a failure
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(reports, 1) << "one silence, one report";
  ++beats;
  wait_for(2);
}

// A tick source that never returns in time is a stuck thread, observed from outside.
TEST(Watchdog, SeesACyclicThreadThatIsStuckAndWhere) {
  class StuckTicks final : public hil::TickSource {
   public:
    StuckTicks() : TickSource(1'000'000) {}
    void restart(std::int64_t) noexcept override {}
    bool wait(const std::atomic<bool>&) noexcept override {
      while (!released) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      due_ns_ = awake_ns_ = hil::get_monotonic_ns();
      return true;
    }
    std::int64_t slip(std::int64_t) noexcept override { return 0; }
    std::int64_t calc_behind(std::int64_t) const noexcept override { return 0; }
    std::atomic<bool> released{false};
  } ticks;
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "s.yaml", {"flight_software.required=[]"});
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions options;
  options.pace = hil::Pace::kRealtime;
  options.last_tick = 3;
  options.ticks = &ticks;
  hil::RingConnection connection(64, 64);
  hil::Recorder recorder("", hil::build_log_header(scenario, *simulation, options.pace, 1, 3));
  hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
  std::string place;
  {
    const hil::Watchdog watchdog(executive.get_beats(), 30'000'000, 0, [&](std::int64_t) {
      if (place.empty()) place = executive.describe_place();  // at the first silence
      ticks.released = true;
    });
    hil::LogEnd end = executive.run();
    EXPECT_EQ(end.status, hil::RunStatus::kDone);
    recorder.close(end);
  }
  EXPECT_EQ(place, "waiting for tick 0");
}

}  // namespace
}  // namespace unlatch::test::preflight_test
