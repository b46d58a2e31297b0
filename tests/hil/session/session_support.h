// A small session: a scenario with one commanded thruster, and a participant that can misbehave on request.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hil/run/replay.h"
#include "hil/run/run.h"
#include "hil/session/executive/executive.h"
#include "hil/session/participants/ring_connection.h"

namespace unlatch::test {

inline const char* const kSessionScenario = R"(unlatch: 1
name: session
step: {dt: 0.001, until: 0.05}
bodies:
  core: {mass: 100, inertia: [10, 20, 25]}
  pod:
    mass: 5
    inertia: [1, 1, 1]
    position: [2, 0, 0]
channels:
  throttle: {initial: 0.5, range: [0.2, 1], safe: 0.3}
  trim: {initial: 0.1, range: [-1, 1], safe: 0.25}
joints:
  latch:
    between: [core, pod]
    point: [2, 0, 0]
    modes:
      held: {kind: weld}
      free: {rows: []}
    mode: held
elements:
  engine: {type: thrust, body: core, direction: [1, 0, 0], profile: 5000, channel: throttle}
  jet: {type: force, body: pod, direction: [0, 1, 0], profile: 20, channel: trim}
sensors:
  gyro: {type: rate, body: core}
events:
  - name: leave
    subject: pod
    when: {time: 0.0205}
    then: [{set_mode: {joint: latch, mode: free}}]
flight_software: {required: [fsw], timeout: 0.05, policy: hold}
)";

inline std::string make_path(const std::string& name) {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string file = std::string("unlatch_") + info->test_suite_name() + "_" + info->name() + "_" + name;
  std::replace(file.begin(), file.end(), '/', '_');  // for tests with parameters
  return (std::filesystem::temp_directory_path() / file).string();
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// A file in memory: thousands of damaged ones need no disk.
class MemoryFile {
 public:
  explicit MemoryFile(std::string bytes)
      : bytes_(std::move(bytes)), file_(fmemopen(bytes_.data(), bytes_.size(), "rb")) {
    if (!file_) throw std::runtime_error("fmemopen");
  }
  [[nodiscard]] hil::LogFileReader open() { return {file_.get(), "memory"}; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string bytes_;
  std::unique_ptr<std::FILE, Close> file_;
};

// Uses the other end of a Link, in a separate thread. Answers every State with the commands of `program`.
class FakeParticipant {
 public:
  struct Habits {
    bool ack_first = false;     // the acknowledgement overtakes the commands
    bool reversed = false;      // commands arrive last first
    bool twice = false;         // everything arrives twice
    std::int64_t deaf_at = -1;  // this tick's State is ignored the first `deaf_times`
    int deaf_times = 0;
    std::int64_t commands_lost_at = -1;          // the commands of the first answer to this tick are lost
    std::int64_t dies_at = -1;                   // answers nothing from this tick on
    std::chrono::milliseconds returns_after{0};  // 0: never; else time after which it answers again
    bool refuses = false;
    std::int64_t announces_too_many_at = -1;  // from this tick on, announces commands that it never sends
    std::int64_t repeats_itself_at = -1;      // from this tick on it repeatedly acknowledges the tick before
    std::function<void(std::int64_t tick, hil::RingConnection& connection, std::int64_t session)> mischief;
  };
  static constexpr std::int32_t kId = 7;

  FakeParticipant(hil::RingConnection& connection, Habits habits)
      : connection_(connection), habits_(std::move(habits)) {
    thread_ = std::jthread([this](const std::stop_token& stopping) {
      hil::Message message;
      while (!stopping.stop_requested()) {
        if (connection_.take(message)) {
          hear(message);
        } else {
          std::this_thread::sleep_for(std::chrono::microseconds(20));
        }
      }
    });
  }

 private:
  // Changes the throttle at every 10th tick, the trim at every 15th; at 30 both.
  static std::vector<std::pair<int, double>> program(std::int64_t tick) {
    std::vector<std::pair<int, double>> settings;
    if (tick % 10 == 0) settings.emplace_back(0, 0.5 + 0.005 * static_cast<double>(tick));
    if (tick % 15 == 0) settings.emplace_back(1, -0.01 * static_cast<double>(tick));
    if (tick == 30) settings.emplace_back(0, 0.9);  // the later command wins
    return settings;
  }

  void hear(const hil::Message& message) {
    if (message.kind == hil::MessageKind::kHello) {
      hil::HelloAckMessage ack;
      ack.session = session_ = message.hello.session;
      ack.schema_hash = hil::kSchemaHash;
      ack.model_hash = message.hello.model_hash;
      ack.dt_ns = message.hello.dt_ns;
      ack.protocol = message.hello.protocol;
      ack.participant = kId;
      ack.status = static_cast<int>(habits_.refuses ? hil::AckStatus::kRefused : hil::AckStatus::kReady);
      hil::set_name(ack.name, "fsw");
      hil::set_name(ack.reason, "the vehicle lacks channel warp");
      connection_.deliver(ack);
    } else if (message.kind == hil::MessageKind::kState && message.state.part == 0) {
      hear_state(message.state);
    }
  }

  void hear_state(const hil::StateMessage& state) {
    const auto now = std::chrono::steady_clock::now();
    if (habits_.dies_at >= 0 && state.tick >= habits_.dies_at) {
      if (!died_) died_ = now;
      if (habits_.returns_after.count() == 0 || now - *died_ < habits_.returns_after) return;
    }
    if (state.tick == habits_.deaf_at && habits_.deaf_times-- > 0) return;
    if (state.tick > answered_) {
      answered_ = state.tick;
      answer_.clear();
      for (const auto& [channel, value] : program(state.tick)) {
        hil::CommandMessage command;
        command.session = session_;
        command.sequence = ++sequence_;
        command.tick = state.tick;
        command.valid_until_tick = -1;
        command.value = value;
        command.participant = kId;
        command.channel = channel;
        answer_.push_back(command);
      }
      if (habits_.mischief) habits_.mischief(state.tick, connection_, session_);
    }
    for (int i = 0; i < (habits_.twice ? 2 : 1); ++i) send(state);
  }

  void send(const hil::StateMessage& state) {
    hil::StepAckMessage ack;
    ack.session = session_;
    ack.sequence = state.sequence;
    ack.tick = state.tick;
    ack.last_command = sequence_;
    ack.participant = kId;
    ack.command_count = static_cast<std::int32_t>(answer_.size());
    if (habits_.announces_too_many_at >= 0 && state.tick >= habits_.announces_too_many_at) {
      ack.last_command += 3;
      ack.command_count += 3;
    }
    if (habits_.repeats_itself_at >= 0 && state.tick >= habits_.repeats_itself_at) {
      ack.tick = habits_.repeats_itself_at - 1;
    }
    if (habits_.ack_first) connection_.deliver(ack);
    std::vector<hil::CommandMessage> commands = answer_;
    if (habits_.reversed) std::reverse(commands.begin(), commands.end());
    if (state.tick == habits_.commands_lost_at) {
      commands.clear();
      habits_.commands_lost_at = -1;
    }
    for (const hil::CommandMessage& command : commands) connection_.deliver(command);
    if (!habits_.ack_first) connection_.deliver(ack);
  }

  hil::RingConnection& connection_;
  Habits habits_;
  std::int64_t session_ = 0, answered_ = -1, sequence_ = 0;
  std::vector<hil::CommandMessage> answer_;
  std::optional<std::chrono::steady_clock::time_point> died_;
  std::jthread thread_;
};

struct SessionResult {
  hil::LogEnd end;
  std::vector<std::string> notices;
  std::vector<double> channels;  // at the end
};

// Runs a whole session; `log` empty: no recording is kept.
inline SessionResult run_session(hil::Pace pace, const FakeParticipant::Habits& habits, const std::string& log = "",
                                 const std::vector<std::string>& overrides = {}, bool with_participant = true,
                                 hil::TickSource* ticks = nullptr, hil::FaultInjector* faults = nullptr,
                                 const hil::Clock& clock = hil::kMonotonicClock) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml", overrides);
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions options;
  options.pace = pace;
  options.session = 4711;
  options.last_tick = static_cast<std::int64_t>(scenario.until / scenario.dt + 0.5);
  options.flight_software = scenario.flight_software;
  options.timing = scenario.timing;
  options.ticks = ticks;
  options.start_timeout_ns = 20'000'000'000;  // a stalled machine must not count as a missing participant
  options.resend_ns = 5'000'000;
  options.faults = faults;
  options.clock = &clock;
  hil::RingConnection connection(256, 256, clock);
  hil::Recorder recorder(log, hil::build_log_header(scenario, *simulation, pace, options.session, options.last_tick));
  hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
  SessionResult result;
  {
    std::optional<FakeParticipant> participant;
    if (with_participant) participant.emplace(connection, habits);
    result.end = executive.run();
  }
  recorder.close(result.end);
  hil::EventMessage notice;
  while (executive.take_notice(notice)) result.notices.emplace_back(hil::get_name(notice.name));
  result.channels.assign(simulation->channels().begin(), simulation->channels().end());
  return result;
}

struct ReplayedLog {
  hil::ReplayResult result;
  std::string shortfall;
  bool damaged = false, complete = false;
};

inline ReplayedLog replay_log(const std::string& path) {
  hil::RecordingReader recording{hil::LogFileReader(path)};
  const hil::Scenario scenario = hil::load_recorded_scenario(recording.header);
  const auto simulation = hil::build_recorded_simulation(recording.header, scenario, path);
  ReplayedLog replayed;
  replayed.result = hil::replay(recording, *simulation, nullptr);
  replayed.shortfall = recording.shortfall;
  replayed.damaged = recording.damaged;
  replayed.complete = recording.end.has_value();
  return replayed;
}

// What a recording has beside the states: events of the session, "name subject", and by tick the sensor values that
// flight software received otherwise than they were measured, beside those measured.
struct RecordedSession {
  std::vector<std::string> events;
  std::vector<std::vector<hil::LogReceived>> received;
  std::vector<std::vector<double>> measured;
};

inline RecordedSession read_recording(const std::string& path) {
  hil::RecordingReader recording{hil::LogFileReader(path)};
  const hil::Scenario scenario = hil::load_recorded_scenario(recording.header);
  const auto simulation = hil::build_recorded_simulation(recording.header, scenario, path);
  RecordedSession recorded;
  hil::replay(recording, *simulation, nullptr, [&](const StepReport&) {
    recorded.received.push_back(recording.received);
    recorded.measured.emplace_back(simulation->get_sensors().begin(), simulation->get_sensors().end());
  });
  for (const hil::EventMessage& event : recording.events)
    recorded.events.push_back(std::string(hil::get_name(event.name)) + " " + std::string(hil::get_name(event.subject)));
  return recorded;
}

}  // namespace unlatch::test
