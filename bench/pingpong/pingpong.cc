#include "bench/pingpong/pingpong.h"

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "bridge/core/direct_connection.h"
#include "bridge/core/port.h"
#include "bridge/core/threaded_connection.h"

namespace unlatch::bench {
namespace {

using namespace std::chrono_literals;
using bridge::Port;
using bridge::Role;

constexpr auto kPatience = 10s;
constexpr auto kResendAfter = 20ms;
constexpr int kWarmUp = 50;
constexpr const char* kPaced = "_paced";

// A separate network for each pair, so that no other messages wake the measured threads.
std::unique_ptr<Port> open_port(const std::string& transport, bool paced, Role role) {
  if (transport == "dds") return bridge::open_dds_port(role, {.domain = paced ? 76 : 77});
  return bridge::open_lcm_port(role,
                               {.url = "udpm://239.255.76.67:" + std::string(paced ? "7700" : "7701") + "?ttl=0"});
}

// Answers every State with its acknowledgement.
void echo(Port& port, const std::atomic<bool>& stop) {
  hil::Message message;
  hil::StepAckMessage ack;
  while (!stop) {
    if (!port.poll(message, 100ms) || message.kind != hil::MessageKind::kState || message.state.part != 0) continue;
    ack.session = message.state.session;
    ack.sequence = message.state.sequence;
    ack.tick = message.state.tick;
    port.publish(ack);
  }
}

// The program itself, started again as the other side; it ends with its parent.
class EchoProcess {
 public:
  explicit EchoProcess(const std::string& who) : id_(fork()) {
    if (id_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execl("/proc/self/exe", "echo", "--echo", who.c_str(), nullptr);
    _exit(127);
  }
  ~EchoProcess() {
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  EchoProcess(const EchoProcess&) = delete;
  EchoProcess& operator=(const EchoProcess&) = delete;

 private:
  const pid_t id_;
};

class EchoThread {
 public:
  explicit EchoThread(std::unique_ptr<Port> port)
      : port_(std::move(port)), thread_([this] {
          pin(kTheirs);
          echo(*port_, stop_);
        }) {}
  ~EchoThread() { stop_ = true; }

 private:
  std::unique_ptr<Port> port_;
  std::atomic<bool> stop_{false};
  std::jthread thread_;
};

// The executive's side of a tick: the parts of the State, the token last, and then the wait for the answer.
class ProtocolPingPong final : public PingPong {
 public:
  ProtocolPingPong(const std::string& transport, bool paced) {
    if (transport == "inproc") {
      port_ = hub_.open(Role::kSimulator);
      thread_ = std::make_unique<EchoThread>(hub_.open(Role::kParticipant));
    } else {
      port_ = open_port(transport, paced, Role::kSimulator);
      process_ = std::make_unique<EchoProcess>(transport + (paced ? kPaced : ""));
    }
    if (paced) {
      connection_ = std::make_unique<bridge::ThreadedConnection>(*port_);
    } else {
      connection_ = std::make_unique<bridge::DirectConnection>(*port_);
    }
    state_.session = 4711;
  }
  ~ProtocolPingPong() override { connection_.reset(); }

 private:
  void send(int bodies) override {
    state_.parts = calc_parts(bodies);
    ++state_.tick;
    for (state_.part = state_.parts - 1; state_.part >= 0; --state_.part) {
      ++state_.sequence;
      connection_->send(state_);
    }
  }

  bool receive(std::chrono::nanoseconds wait) override {
    const auto deadline = std::chrono::steady_clock::now() + wait;
    while (true) {
      while (connection_->receive(arrival_)) {
        const auto* const ack = std::get_if<hil::StepAckMessage>(&arrival_.message);
        if (ack != nullptr && ack->tick == state_.tick) return true;
      }
      const auto left = deadline - std::chrono::steady_clock::now();
      if (left <= 0ns) return false;
      connection_->wait(left);
    }
  }

  bridge::InprocHub hub_;
  std::unique_ptr<Port> port_;
  std::unique_ptr<EchoThread> thread_;
  std::unique_ptr<EchoProcess> process_;
  std::unique_ptr<hil::Connection> connection_;
  hil::StateMessage state_;
  hil::Arrival arrival_;
};

// Bare ping-pong, with its other side.
class BarePingPong final : public PingPong {
 public:
  BarePingPong(const std::string& transport, bool as_one) : inner_(open_bare(transport, as_one)) {
    if (transport != "inproc") process_ = std::make_unique<EchoProcess>((as_one ? "bare_one_" : "bare_") + transport);
  }

 private:
  void send(int bodies) override { inner_->run(bodies); }
  bool receive(std::chrono::nanoseconds) override { return true; }

  std::unique_ptr<PingPong> inner_;
  std::unique_ptr<EchoProcess> process_;
};

bool strip_end(std::string& text, const std::string& suffix) {
  if (!text.ends_with(suffix)) return false;
  text.erase(text.size() - suffix.size());
  return true;
}

bool strip(std::string& text, const std::string& prefix) {
  if (!text.starts_with(prefix)) return false;
  text.erase(0, prefix.size());
  return true;
}

}  // namespace

void pin(Core core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<std::size_t>(core), &cores);
  sched_setaffinity(0, sizeof cores, &cores);  // on a machine with one core they share it
}

int calc_parts(int bodies) {
  return (bodies + static_cast<int>(hil::kBodiesPerPart) - 1) / static_cast<int>(hil::kBodiesPerPart);
}

std::size_t calc_bytes(int bodies) { return static_cast<std::size_t>(calc_parts(bodies)) * sizeof(hil::StateMessage); }

void PingPong::run(int bodies) {
  for (auto waited = 0ms; waited < kPatience; waited += kResendAfter) {
    send(bodies);
    if (receive(kResendAfter)) return;
  }
  throw std::runtime_error("ping-pong: no answer");
}

std::unique_ptr<PingPong> open_pingpong(const std::string& who) {
  pin(kOurs);
  std::string transport = who;
  const bool bare = strip(transport, "bare_");
  const bool as_one = strip(transport, "one_");
  const bool paced = strip_end(transport, kPaced);
  std::unique_ptr<PingPong> pingpong;
  if (bare) {
    pingpong = std::make_unique<BarePingPong>(transport, as_one);
  } else {
    pingpong = std::make_unique<ProtocolPingPong>(transport, paced);
  }
  for (int i = 0; i < kWarmUp; ++i) {
    if (!as_one) pingpong->run(kFew);
    pingpong->run(kMany);
  }
  return pingpong;
}

std::vector<double> measure_in_turns_us(const std::vector<std::string>& who, int bodies, int turns) {
  using Clock = std::chrono::steady_clock;
  constexpr int kFirst = 3, kTrips = 23;  // one turn: its first trips fill the caches
  std::vector<std::unique_ptr<PingPong>> pingpongs;
  for (const std::string& name : who) pingpongs.push_back(open_pingpong(name));
  std::vector<std::vector<double>> times_us(who.size());
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < who.size(); ++i) {
      for (int trip = 0; trip < kTrips; ++trip) {
        const auto begin = Clock::now();
        pingpongs[i]->run(bodies);
        if (trip < kFirst) continue;
        times_us[i].push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
      }
    }
  }
  std::vector<double> medians_us;
  for (std::vector<double>& times : times_us) {
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    medians_us.push_back(*middle);
  }
  return medians_us;
}

bool is_echo(int count, char** arguments) { return count == 3 && std::string(arguments[1]) == "--echo"; }

int run_echo(char** arguments) {
  pin(kTheirs);
  std::string transport = arguments[2];
  if (strip(transport, "bare_")) {
    const bool as_one = strip(transport, "one_");
    echo_bare(transport, as_one);
  } else {
    const bool paced = strip_end(transport, kPaced);
    const auto port = open_port(transport, paced, Role::kParticipant);
    echo(*port, std::atomic<bool>(false));
  }
  return 0;
}

}  // namespace unlatch::bench
