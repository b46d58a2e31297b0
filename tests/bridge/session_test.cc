// The protocol of hil/PROTOCOL.md over every transport: whole sessions, executive, rings, threads and middleware. Run
// through tests/support/netns.sh, because LCM needs a multicast route.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <set>

#include "bridge/core/direct_connection.h"
#include "bridge/core/threaded_connection.h"
#include "hil/run/recording/replay_reader.h"
#include "tests/bridge/computer.h"
#include "tests/hil/session/session_support.h"
#include "unlatch/contacts.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;
using bridge::Port;
using bridge::Role;
using hil::Pace;
using hil::Reject;
using hil::RunStatus;
using Habits = Computer::Habits;

constexpr const char* kTwo = "flight_software.required=[guidance, separation]";
constexpr const char* kPatient = "flight_software.timeout=30";  // a stalled machine is no dead computer

// Changes the throttle at every 10th tick.
std::vector<std::pair<int, double>> drive(std::int64_t tick) {
  if (tick % 10 != 0) return {};
  return {{0, 0.5 + 0.005 * static_cast<double>(tick % 90)}};
}

class Sessions : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Port> open(Role role) {
    if (GetParam() == "dds") return bridge::open_dds_port(role);
    if (GetParam() == "lcm") return bridge::open_lcm_port(role);
    if (GetParam() == "udp") return bridge::open_udp_port(role);
    return hub_.open(role);
  }

  Computer& start(const std::string& name, Habits habits) {
    return *computers_.emplace_back(std::make_unique<Computer>(open(Role::kParticipant), name, std::move(habits)));
  }

  // Runs a session to its end; `meanwhile` runs at the same time, in this thread.
  SessionResult run(const std::vector<std::string>& overrides, Pace pace = Pace::kLockstep, const std::string& log = "",
                    const std::function<void(hil::Executive&)>& meanwhile = nullptr, bool direct = false) {
    const hil::Scenario scenario = hil::load_scenario_text(text_, "session.yaml", overrides);
    const auto simulation = hil::build_simulation(scenario);
    hil::ExecutiveOptions options;
    options.pace = pace;
    options.session = session_;
    options.last_tick = static_cast<std::int64_t>(scenario.until / scenario.dt + 0.5);
    options.flight_software = scenario.flight_software;
    options.start_timeout_ns = 10'000'000'000;
    options.announce_ns = 2'000'000;
    const auto port = open(Role::kSimulator);
    std::optional<bridge::ThreadedConnection> threaded;
    if (!direct) threaded.emplace(*port);
    bridge::DirectConnection direct_connection(*port);
    hil::Connection& connection = direct ? static_cast<hil::Connection&>(direct_connection) : *threaded;
    hil::Recorder recorder(log, hil::build_log_header(scenario, *simulation, pace, session_, options.last_tick));
    hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
    SessionResult result;
    {
      std::jthread cyclic([&] { result.end = executive.run(); });
      if (meanwhile) meanwhile(executive);
    }
    if (threaded) threaded->stop();
    recorder.close(result.end);
    hil::EventMessage notice;
    while (executive.take_notice(notice)) {
      result.notices.push_back(std::string(hil::get_name(notice.name)) + " " +
                               std::string(hil::get_name(notice.subject)));
    }
    if (!scenario.model.contacts.empty())
      blow_ = get_contact_totals(simulation->plan(), simulation->state(), 0).impulse;
    result.channels.assign(simulation->channels().begin(), simulation->channels().end());
    for (const auto& computer : computers_) computer->stop();
    return result;
  }

  static constexpr std::int64_t session_ = 4711;
  std::string text_ = kSessionScenario;
  double blow_ = 0;  // N s, impulse of the first contact, if there is one
  bridge::InprocHub hub_;
  std::vector<std::unique_ptr<Computer>> computers_;
};

TEST_P(Sessions, GoThroughTheStatesOfTheProtocol) {
  start("fsw", {.program = drive});
  const SessionResult result = run({kPatient});
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(computers_[0]->statuses,
            (std::vector<RunStatus>{RunStatus::kDiscover, RunStatus::kConfigured, RunStatus::kArmed,
                                    RunStatus::kRunning, RunStatus::kDone}));
  const hil::HelloMessage& hello = computers_[0]->hello;
  EXPECT_EQ(hello.protocol, hil::kProtocolVersion);
  EXPECT_EQ(hello.schema_hash, hil::kSchemaHash);
  EXPECT_NE(hello.model_hash, 0);
  EXPECT_EQ(hello.dt_ns, 1'000'000);
  EXPECT_EQ(hello.participant_count, 1);
}

// The pod is pushed off and thrown back by a wall while the throttle changes.
TEST_P(Sessions, ContactsAndPushersActAndAreReplayed) {
  const auto insert = [&](const std::string& after, const std::string& what) {
    text_.insert(text_.find(after) + after.size(), what);
  };
  insert("    position: [2, 0, 0]\n", "    shape: [{sphere: {radius: 0.5}}]\n");
  insert("bodies:\n",
         "  wall: {mass: 90, inertia: [9, 9, 9], position: [3.52, 0, 0], shape: [{box: {size: [2, 4, 4]}}]}\n");
  insert("elements:\n",
         "  pusher: {type: pusher, between: [core, pod], point: [2, 0, 0], guide: [1, 0, 0], stroke: 1 cm, preload: 20 "
         "kN}\n");
  text_ += "contacts: {blow: {between: [wall, pod], stiffness: 2 MN/m, friction: 0.2}}\n";
  const std::string log = make_path("log");
  start("fsw", {.program = drive});
  const SessionResult result = run({kPatient, "step.contact_substeps=8"}, Pace::kLockstep, log);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_GT(blow_, 50) << "N s: the pusher's 200 J give the pod of 5 kg some 9 m/s, and the wall turns it back";
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.complete);
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  std::filesystem::remove(log);
}

// Only missing commands are sent again, so that the time for a tick is linear in the number of its commands.
TEST_P(Sessions, TenThousandCommandsATickAreSentLittleMoreThanOnce) {
  constexpr int kTicks = 20;
  for (const int count : {100, 1000, 10'000}) {
    const Computer& computer =
        start("fsw", {.program = [count](std::int64_t) {
                std::vector<std::pair<int, double>> commands(static_cast<std::size_t>(count), {0, 0.3});
                commands.back().second = 0.7;
                return commands;
              }});
    const auto begun = std::chrono::steady_clock::now();
    const SessionResult result = run({kPatient, "step.until=0.02"}, Pace::kLockstep, "", nullptr, true);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
    EXPECT_EQ(result.channels[0], 0.7);
    // In-process a queue keeps the newest 1024 messages, so more rounds are needed.
    const std::int64_t bearable = (GetParam() == "inproc" ? 30 : 3) * kTicks * std::int64_t{count};
    EXPECT_LT(computer.commands_sent, bearable);
    std::cout << count << " commands a tick: " << took.count() / kTicks * 1e3 << " ms a tick, "
              << static_cast<double>(computer.commands_sent) / (kTicks * count) << " times sent\n";
    computers_.clear();
  }
}

// All commands are sent before the step of tick 0. The State after a tick shows its last command.
TEST_P(Sessions, AProfileOfAHundredThousandCommandsIsLoadedBeforeTheFirstStep) {
  constexpr std::size_t kCommands = 100'000, kPerTick = 100;
  constexpr std::size_t kPlaces = 16'384;  // default of the scenario
  const auto calc_value = [](std::size_t place) { return 0.2 + 0.8 * static_cast<double>(place) / kCommands; };
  Habits habits;
  habits.program = [&](std::int64_t tick) {
    std::vector<std::pair<int, double>> commands;
    for (std::size_t i = 0; tick == 0 && i < kCommands; ++i) commands.emplace_back(0, calc_value(i));
    return commands;
  };
  habits.due = [](std::size_t place) { return static_cast<std::int64_t>(place / kPerTick); };
  for (const bool has_room : {true, false}) {
    const Computer& computer = start("fsw", habits);
    const std::string log = make_path("log");
    const SessionResult result =
        run({kPatient, "step.until=1.001", has_room ? "flight_software.queue=100000" : kPatient}, Pace::kLockstep, log,
            nullptr, true);
    EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
    std::size_t acted = 0;  // at their ticks, in their order
    hil::RecordingReader reader{hil::LogFileReader(log)};
    for (hil::LogTick tick; reader.next(tick);) {
      for (const hil::LogChange& change : tick.changes) {
        if (change.value == calc_value(acted) && tick.tick == habits.due(acted)) ++acted;
      }
    }
    const auto refused = result.end.timing.rejected[static_cast<std::size_t>(Reject::kNoPlace)];
    if (has_room) {
      EXPECT_EQ(refused, 0);
      EXPECT_TRUE(computer.verdicts.empty());
      EXPECT_EQ(acted, kCommands);
    } else {  // those due first have their places
      EXPECT_EQ(refused, static_cast<std::int64_t>(kCommands) - std::int64_t{kPlaces});
      EXPECT_FALSE(computer.verdicts.empty());
      EXPECT_EQ(acted, kPlaces);
    }
    EXPECT_TRUE(replay_log(log).result.agrees());
    std::cout << computer.commands_sent << " commands sent\n";
    computers_.clear();
  }
}

// Both command the same channel; the later name decides, whichever answers first.
TEST_P(Sessions, SeveralComputersCommandInTheOrderOfTheirNames) {
  std::set<std::int64_t> hashes;
  for (const auto slow : {0, 1}) {
    start("guidance", {.id = 99,
                       .program =
                           [](std::int64_t) {
                             return std::vector<std::pair<int, double>>{{0, 0.4}};
                           },
                       .pace = slow * 300us});
    start("separation", {.id = 5,
                         .program =
                             [](std::int64_t) {
                               return std::vector<std::pair<int, double>>{{0, 0.8}};
                             },
                         .pace = (1 - slow) * 300us});
    const SessionResult result = run({kTwo, kPatient});
    EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
    EXPECT_EQ(result.channels[0], 0.8);
    hashes.insert(result.end.hash);
    computers_.clear();
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST_P(Sessions, AComputerMayLeaveAndAnotherStartOfItRejoin) {
  start("guidance", {.id = 1, .pace = 1ms});
  start("separation", {.id = 2, .leaves_at = 20});
  const std::string log = make_path("log");
  const SessionResult result =
      run({kTwo, kPatient, "step.until=1"}, Pace::kLockstep, log, [&](hil::Executive& executive) {
        while (executive.get_tick() < 30) std::this_thread::sleep_for(1ms);
        start("separation", {.id = 3, .program = [](std::int64_t) {
                               return std::vector<std::pair<int, double>>{{1, 0.5}};
                             }});
      });
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.tick, 1000);
  ASSERT_EQ(result.notices.size(), 5u);
  EXPECT_EQ(result.notices[2], "participant.left separation");
  EXPECT_EQ(result.notices[3], "policy.hold separation");
  EXPECT_EQ(result.notices[4], "participant.rejoined separation");
  EXPECT_EQ(result.channels[1], 0.5);
  EXPECT_EQ(computers_[2]->get_tick(), 999);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST_P(Sessions, ASilentComputerIsEvictedAndStaysOut) {
  start("guidance", {.id = 1, .pace = 200us});
  start("separation", {.id = 2, .dies_at = 20});
  const SessionResult result =
      run({kTwo, "flight_software.timeout=0.5", "flight_software.policy=evict", "step.until=1"}, Pace::kLockstep, "",
          [&](hil::Executive& executive) {
            while (executive.get_tick() < 30) std::this_thread::sleep_for(1ms);
            start("separation", {.id = 3});
          });
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  ASSERT_EQ(result.notices.size(), 4u);
  EXPECT_EQ(result.notices[2], "policy.evict separation");
  EXPECT_EQ(result.notices[3], "participant.refused separation");
}

TEST_P(Sessions, TwoOfOneNameAreNamed) {
  start("fsw", {.id = 1, .program = drive});
  const std::int64_t alone = run({kPatient, "step.until=0.5"}).end.hash;
  computers_.clear();
  start("fsw", {.id = 1, .program = drive, .pace = 1ms});
  const SessionResult result = run({kPatient, "step.until=0.5"}, Pace::kLockstep, "", [&](hil::Executive& executive) {
    while (executive.get_tick() < 5) std::this_thread::sleep_for(1ms);
    start("fsw", {.id = 2, .program = drive});
  });
  EXPECT_EQ(result.end.hash, alone);
  EXPECT_EQ(result.notices, (std::vector<std::string>{"participant.joined fsw", "participant.name_taken fsw"}));
  ASSERT_FALSE(computers_[1]->verdicts.empty());
  EXPECT_EQ(computers_[1]->verdicts[0].reason, static_cast<int>(Reject::kNameTaken));
  EXPECT_TRUE(computers_[0]->verdicts.empty());
}

// Each reason, by its name in the schema, with the wrong message sent in place of a good command.
struct Misdeed {
  Reject reason;
  std::function<void(hil::CommandMessage& command)> spoil;
};
constexpr std::int64_t kHorizon = 60'000;  // ticks, the scenario's default of 60 s
const Misdeed kMisdeeds[] = {
    {Reject::kWrongSession, [](hil::CommandMessage& c) { c.session += 1; }},
    {Reject::kPastTick, [](hil::CommandMessage& c) { c.tick -= 1; }},
    {Reject::kDuplicate,
     [](hil::CommandMessage& c) {
       c.sequence = 1;
       ++c.tick;  // not of a State that may be repeated meanwhile
     }},
    {Reject::kExpired, [](hil::CommandMessage& c) { c.valid_until_tick = c.tick - 1; }},
    {Reject::kNotFinite, [](hil::CommandMessage& c) { c.value = std::numeric_limits<double>::quiet_NaN(); }},
    {Reject::kNotFinite, [](hil::CommandMessage& c) { c.value = -std::numeric_limits<double>::infinity(); }},
    {Reject::kOutOfRange, [](hil::CommandMessage& c) { c.value = 1.01; }},
    {Reject::kUnknownChannel, [](hil::CommandMessage& c) { c.channel = 2; }},
    {Reject::kUnknownChannel, [](hil::CommandMessage& c) { c.channel = -1; }},
    {Reject::kMalformed, [](hil::CommandMessage& c) { c.tick = std::numeric_limits<std::int64_t>::min(); }},
    {Reject::kMalformed, [](hil::CommandMessage& c) { c.sequence = 0; }},
    {Reject::kTooFar, [](hil::CommandMessage& c) { c.tick += kHorizon + 1; }},
    {Reject::kJump, [](hil::CommandMessage& c) { c.sequence += hil::SeenCommands::kWindow + 1; }},
};

TEST_P(Sessions, EachRefusalIsCountedAndPublished) {
  start("fsw", {.id = 1, .program = drive});
  const std::int64_t well_behaved = run({kPatient}).end.hash;
  computers_.clear();

  std::array<std::int64_t, hil::kRejectReasons> sent{};
  std::vector<std::int64_t> numbers;
  start("fsw", {.id = 1, .program = drive, .mischief = [&](const hil::StateMessage& state, Computer& computer) {
                  if (state.tick != 25) return;
                  for (const Misdeed& misdeed : kMisdeeds) {
                    hil::CommandMessage command = computer.make_command(state.tick, 0, 0.9);
                    misdeed.spoil(command);
                    numbers.push_back(command.sequence);
                    ++sent[static_cast<std::size_t>(misdeed.reason)];
                    computer.say(command);
                  }
                  // The answer to this State overtakes them on no transport; even so, give them time.
                  std::this_thread::sleep_for(20ms);
                }});
  const SessionResult result = run({kPatient});
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.hash, well_behaved);
  std::set<std::pair<std::int64_t, Reject>> heard;
  for (const hil::VerdictMessage& verdict : computers_[0]->verdicts) {
    heard.emplace(verdict.refers_to, static_cast<Reject>(verdict.reason));
    EXPECT_EQ(verdict.applied_tick, -1);
  }
  for (std::size_t i = 0; i < std::size(kMisdeeds); ++i) {
    EXPECT_TRUE(heard.contains({numbers[i], kMisdeeds[i].reason})) << hil::get_text(kMisdeeds[i].reason);
  }
  for (std::size_t i = 0; i < hil::kRejectReasons; ++i) {
    const auto reason = static_cast<Reject>(i);
    EXPECT_EQ(result.end.timing.rejected[i], sent[i]) << hil::get_text(reason);
    EXPECT_EQ(computers_[0]->health.rejected[i], result.end.timing.rejected[i]) << hil::get_text(reason);
  }
}

TEST_P(Sessions, MalformedBytesAreCountedAndPublished) {
  if (GetParam() == "inproc") GTEST_SKIP() << "there are no bytes in-process";
  constexpr int kCount = 3;  // see party.cc
  start("fsw", {.id = 1, .program = drive, .mischief = [&](const hil::StateMessage& state, Computer&) {
                  if (state.tick != 25) return;
                  EXPECT_EQ(std::system((BRIDGE_PARTY " " + GetParam() + " stunt").c_str()), 0);
                }});
  const SessionResult result = run({kPatient});
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  const auto malformed = static_cast<std::size_t>(Reject::kMalformed);
  EXPECT_EQ(result.end.timing.rejected[malformed], kCount);
  EXPECT_EQ(computers_[0]->health.rejected[malformed], kCount);
}

TEST_P(Sessions, RealtimeFlagsACommandBehindTheCutOff) {
  const std::string log = make_path("log");
  start("fsw", {.id = 1, .program = drive});
  // The cut-off is a microsecond after the State: every answer is late.
  const SessionResult result = run({kPatient, "flight_software.cutoff=0.001"}, Pace::kRealtime, log);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_GE(result.end.timing.late_commands, 3);
  const auto& verdicts = computers_[0]->verdicts;
  const auto late = std::find_if(verdicts.begin(), verdicts.end(), [](const hil::VerdictMessage& verdict) {
    return verdict.reason == static_cast<int>(Reject::kLate);
  });
  ASSERT_NE(late, verdicts.end());
  EXPECT_GT(late->applied_tick, 0);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

INSTANTIATE_TEST_SUITE_P(All, Sessions, testing::Values("inproc", "dds", "lcm", "udp"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace unlatch::test
