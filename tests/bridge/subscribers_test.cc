// Sixty-four subscribers, one of which never reads: a process that is stopped after it has subscribed. The times of the
// cyclic thread's steps must not depend on them. UNLATCH_SUBSCRIBERS=processes gives every subscriber a separate
// process and measures for longer; the figures in bench/results are from there.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <iostream>
#include <list>
#include <thread>

#include "bridge/core/port.h"
#include "bridge/core/threaded_connection.h"
#include "hil/run/run.h"
#include "hil/run/simulation/model_messages.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/histogram.h"
#include "hil/session/realtime/real_time.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;

constexpr int kSubscribers = 64;
constexpr std::int64_t kTick_ns = 1'000'000;
// Growth of the median. The steps compete with the subscribers for caches and, on a small machine, for cores, so the
// median may grow by some. A wait for a subscriber would cost a thousand times as much.
constexpr double kMedianGrowth = 3;

bool is_long() {
  const char* const wish = std::getenv("UNLATCH_SUBSCRIBERS");
  return wish != nullptr && std::strcmp(wish, "processes") == 0;
}

// Runs `bridge_party dds watch N` in another process.
class Watchers {
 public:
  explicit Watchers(int count) {
    int ends[2];
    if (pipe(ends) != 0) return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const std::string number = std::to_string(count);
    std::array<const char*, 5> arguments{BRIDGE_PARTY, "dds", "watch", number.c_str(), nullptr};
    posix_spawn(&id_, BRIDGE_PARTY, &actions, nullptr, const_cast<char* const*>(arguments.data()), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = ends[0];
  }
  ~Watchers() {
    kill(SIGKILL);
    waitpid(id_, nullptr, 0);
    close(output_);
  }
  Watchers(const Watchers&) = delete;
  Watchers& operator=(const Watchers&) = delete;

  void wait_until_all_have_heard() const {
    char byte = 0;
    EXPECT_EQ(read(output_, &byte, 1), 1);
  }
  void kill(int signal) const { ::kill(id_, signal); }

 private:
  pid_t id_ = 0;
  int output_ = -1;
};

// The cyclic thread in its simplest form: wait, step, push the state.
class Cycle {
 public:
  Cycle()
      : simulation_(
            hil::build_simulation(hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/scenario.yaml"))) {
    thread_ = std::jthread([this](const std::stop_token& stopping) { run(stopping); });
  }
  // Times of step and push, over the next `ticks`.
  hil::Histogram measure(std::int64_t ticks) {
    ticks_ = ticks;
    while (ticks_ > 0) std::this_thread::sleep_for(5ms);
    hil::Histogram measured = histogram_;
    histogram_ = {};
    return measured;
  }
  [[nodiscard]] std::int64_t get_sent() const { return sent_; }
  [[nodiscard]] std::int64_t get_dropped() const { return connection_.get_dropped_out(); }
  // Stops; all pushed messages have been published.
  [[nodiscard]] bridge::PortCounts stop() {
    thread_.request_stop();
    thread_.join();
    connection_.stop();
    return port_->get_counts();
  }

 private:
  void run(const std::stop_token& stopping) {
    for (const std::string& refused : hil::request_real_time()) std::cout << refused << '\n';
    std::int64_t deadline_ns = hil::get_monotonic_ns();
    hil::StateMessage state;
    while (!stopping.stop_requested()) {
      deadline_ns += kTick_ns;
      hil::sleep_until_ns(deadline_ns);
      const std::int64_t begin_ns = hil::get_monotonic_ns();
      (void)simulation_->step();
      hil::fill_state(*simulation_, 0, kTick_ns, state);
      connection_.send(state);
      const std::int64_t took_ns = hil::get_monotonic_ns() - begin_ns;
      ++sent_;
      if (ticks_ == 0) continue;
      histogram_.record(took_ns);
      --ticks_;
    }
  }

  std::unique_ptr<hil::Simulation> simulation_;
  std::unique_ptr<bridge::Port> port_ = bridge::open_dds_port(bridge::Role::kSimulator);
  bridge::ThreadedConnection connection_{*port_};
  hil::Histogram histogram_;
  std::atomic<std::int64_t> ticks_{0}, sent_{0};
  std::jthread thread_;
};

void print(const char* what, const hil::Histogram& histogram) {
  std::cout << what << ": step and push p50 " << static_cast<double>(histogram.calc_percentile(0.5)) * 1e-3
            << " us, p90 " << static_cast<double>(histogram.calc_percentile(0.9)) * 1e-3 << " us, p99 "
            << static_cast<double>(histogram.calc_percentile(0.99)) * 1e-3 << " us, max "
            << static_cast<double>(histogram.get_max()) * 1e-3 << " us, " << histogram.get_count() << " ticks\n";
}

TEST(Subscribers, SixtyFourOfWhichOneNeverReadsDoNotMoveTheSteps) {
  const std::int64_t ticks = is_long() ? 5'000 : 1'000;
  Cycle cycle;
  const hil::Histogram alone = cycle.measure(ticks);
  print("alone", alone);

  std::list<Watchers> watchers;
  if (is_long()) {
    for (int i = 0; i < kSubscribers; ++i) watchers.emplace_back(1);
  } else {
    watchers.emplace_back(kSubscribers - 1);
    watchers.emplace_back(1);
  }
  for (const Watchers& some : watchers) some.wait_until_all_have_heard();
  watchers.back().kill(SIGSTOP);
  const hil::Histogram watched = cycle.measure(ticks);
  print("with 64 subscribers, one stopped", watched);

  EXPECT_LT(static_cast<double>(watched.calc_percentile(0.5)),
            kMedianGrowth * static_cast<double>(alone.calc_percentile(0.5)));
  const bridge::PortCounts counts = cycle.stop();
  std::cout << cycle.get_sent() << " states pushed, " << cycle.get_dropped() << " found the ring full, "
            << counts.published << " published\n";
  EXPECT_EQ(counts.published + cycle.get_dropped(), cycle.get_sent());  // no loss is uncounted
  EXPECT_EQ(counts.publish_failures, 0);                                // the subscriber that never reads blocks none
}

}  // namespace
}  // namespace unlatch::test
