// Checkpoints: a resumed run has the same bits; a damaged or foreign checkpoint is refused with its reason.
#include "hil/run/checkpoint.h"

#include <gtest/gtest.h>

#include <random>

#include "hil/run/recording/replay_reader.h"
#include "tests/hil/session/session_support.h"
#include "unlatch/contacts.h"

namespace unlatch::test::checkpoint_test {
namespace {

// A scenario with every kind of memory in a state: a profile in an element's own time, a ramp, an event that waits for
// its delay, one that repeats, a signal, a joint that latched, a spring that counts the turns of a hinge; channels and
// sensors that are held between their ticks.
const char* const kMemoryScenario = R"(unlatch: 1
name: memory
step: {dt: 0.001, until: 0.4}
timing: {groups: {nav: {every: 4, sensors: [gyro]}, drive: {every: 10, phase: 3, elements: [engine]}}}
bodies:
  core: {mass: 100, inertia: [10, 20, 25], rate: [0.1, 0.2, 0.3]}
  flap:
    mass: 5
    inertia: [1, 1, 1]
    position: [2, 0, 0]
    velocity: [0, 0.3, -0.4]
    rate: [0.1, 0.2, 0]
channels:
  throttle: {initial: 0.5, range: [0, 1]}
joints:
  hinge:
    between: [core, flap]
    point: [1, 0, 0]
    follower_point: [-1, 0, 0]
    modes:
      turning: {kind: revolute, axis: z}
      locked: {kind: weld}
    mode: turning
elements:
  engine:
    type: thrust
    body: core
    direction: [1, 0, 0]
    point: [-1, 0.1, 0]
    profile: {table: {times: [0, 0.05, 0.3], values: [0, 400, 100]}}
    channel: throttle
    enabled: false
  jet: {type: force, body: flap, direction: [0, 1, 0], profile: {harmonic: [{amplitude: 40, frequency: 90, phase: 0.4}]}}
  drive: {type: joint_spring, joint: hinge, axis: rot_z, effort: 9, stiffness: 3, damping: 0.2}
sensors:
  gyro: {type: rate, body: core}
  feel: {type: specific_force, body: flap, point: [0.5, 0, 0]}
  torque: {type: reaction, joint: hinge}
  lamp: {type: contact, signal: lit}
events:
  - {name: fire, when: {time: 0.0305}, delay: 25 ms, then: [{switch: {element: engine, to: true}}, {raise: lit}]}
  - {name: fade, when: {signal: lit}, then: [{ramp: {element: jet, to: 0.2, over: 0.08}}]}
  - name: latch
    when: {all: [{time: 0.15}, {angle: {joint: hinge, axis: rot_z}, above: 0.01}]}
    delay: 10.5 ms
    then: [{latch: {joint: hinge, mode: locked}}]
  - {name: blink, when: {body_rate: core, above: 0.05}, delay: 7 ms, repeat: true, then: [{raise: {signal: lit, to: 1}}]}
)";

hil::Scenario load_memory(const std::vector<std::string>& overrides = {}) {
  return hil::load_scenario_text(kMemoryScenario, "memory.yaml", overrides);
}

std::int64_t get_last_tick(const hil::Scenario& scenario) {
  return static_cast<std::int64_t>(scenario.until / scenario.dt + 0.5);
}

// Sets commands that arrive during the run: held until the next.
void command(hil::Simulation& simulation) {
  if (simulation.get_tick() % 37 == 5) {
    simulation.channels()[0] = 0.3 + 0.001 * static_cast<double>(simulation.get_tick());
  }
}

bool has_pending_event(const unlatch::State& state) {
  return std::any_of(state.events.begin(), state.events.end(),
                     [](const EventState& event) { return event.phase == EventPhase::kPending; });
}

bool has_running_ramp(const hil::Simulation& simulation) {
  const double now = simulation.get_time();
  const auto& elements = simulation.state().elements;
  return std::any_of(elements.begin(), elements.end(), [now](const ElementState& element) {
    return element.duration > 0 && now > element.start && now < element.start + element.duration;
  });
}

bool has_latched(const hil::Simulation& simulation) { return simulation.state().joints[0].mode == 1; }

// Runs the whole once, with a checkpoint at each of `ticks`; then from each checkpoint to the end, in a new simulation.
TEST(Checkpoint, ARunTakenUpAgainHasTheSameHashAtEveryTick) {
  const hil::Scenario scenario = load_memory();
  const std::int64_t last_tick = get_last_tick(scenario);
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::vector<bool> chosen(static_cast<std::size_t>(last_tick + 1));
  for (int i = 0; i < 40; ++i) chosen[random() % chosen.size()] = true;
  chosen.front() = chosen.back() = true;
  for (std::int64_t tick = 30; tick < 60; ++tick) chosen[static_cast<std::size_t>(tick)] = true;  // while `fire` waits

  std::vector<std::int64_t> hashes;
  std::vector<std::vector<std::uint64_t>> saved;  // including held values
  std::vector<std::vector<double>> sensors;
  const auto path_of = [](std::size_t tick) { return make_path(std::to_string(tick)); };
  int pending = 0, ramping = 0, latched = 0;
  const auto whole = hil::build_simulation(scenario);
  for (std::size_t tick = 0; tick < chosen.size(); ++tick) {
    hashes.push_back(whole->calc_hash());
    saved.push_back(whole->save());
    sensors.emplace_back(whole->workspace().sensors.begin(), whole->workspace().sensors.end());
    if (chosen[tick]) {
      hil::write_checkpoint(path_of(tick), scenario, *whole, last_tick);
      pending += has_pending_event(whole->state());
      ramping += has_running_ramp(*whole);
      latched += has_latched(*whole);
    }
    command(*whole);
    ASSERT_EQ(whole->step().status, StepStatus::kOk);
  }
  EXPECT_GT(pending, 0);
  EXPECT_GT(ramping, 0);
  EXPECT_GT(latched, 0);

  for (std::size_t first = 0; first < chosen.size(); ++first) {
    if (!chosen[first]) continue;
    const auto again = hil::build_simulation(scenario);
    hil::read_checkpoint(path_of(first), scenario, *again);
    std::filesystem::remove(path_of(first));
    ASSERT_EQ(again->get_tick(), static_cast<std::int64_t>(first));
    for (std::size_t tick = first; tick < chosen.size(); ++tick) {
      ASSERT_EQ(again->calc_hash(), hashes[tick]) << "tick " << tick << ", taken up at " << first;
      ASSERT_EQ(again->save(), saved[tick]) << "tick " << tick << ", taken up at " << first;
      const std::vector<double> seen(again->workspace().sensors.begin(), again->workspace().sensors.end());
      ASSERT_EQ(seen, sensors[tick]) << "sensors at tick " << tick << ", taken up at " << first;
      command(*again);
      ASSERT_EQ(again->step().status, StepStatus::kOk);
    }
  }
}

// A ball that bounces between a wall and a pusher with friction, on a cord: pairs that are closed or open, depths of
// the latest look, and elements that push or do not, are memory too.
const char* const kBouncingScenario = R"(unlatch: 1
name: bouncing
step: {dt: 1 ms, until: 0.4, contact_substeps: 4}
bodies:
  wall: {mass: 50, inertia: [9, 9, 9], shape: [{name: face, box: {size: [2, 10, 10]}}]}
  ball: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1.6, 0.1, 0], velocity: [-3, 0.4, 0], rate: [0, 0, 8], shape: [{sphere: {radius: 0.5}}]}
  plate: {mass: 20, inertia: [3, 3, 3], position: [2.5, 0, 0]}
contacts:
  blow: {between: [wall.face, ball], stiffness: 0.2 MN/m, friction: 0.3, restitution: {coefficient: 0.8, speed: 3 m/s}}
elements:
  buffer: {type: pusher, between: [plate, ball], guide: [-1, 0, 0], stroke: 0.6, preload: 900 N, stiffness: 1 kN/m, friction: 3 N}
  leash: {type: cord, between: [wall, ball], length: 1.75, stiffness: 50 kN/m}
)";

TEST(Checkpoint, WhileContactsAndPushersActItContinuesWithTheSameBits) {
  const hil::Scenario scenario = hil::load_scenario_text(kBouncingScenario, "bouncing.yaml");
  const std::int64_t last_tick = get_last_tick(scenario);
  const auto whole = hil::build_simulation(scenario);
  const std::string path = make_path("checkpoint");
  std::vector<std::unique_ptr<hil::Simulation>> taken_up;
  int closed = 0, pushing = 0;
  while (whole->get_tick() < last_tick) {
    const bool touches = get_contact_pairs(whole->plan(), whole->state(), 0)[0].closed != 0;
    const bool pushes = std::ranges::any_of(whole->state().engaged, [](auto flag) { return flag != 0; });
    closed += touches ? 1 : 0;
    pushing += pushes ? 1 : 0;
    if (touches || pushes || whole->get_tick() % 40 == 0) {
      hil::write_checkpoint(path, scenario, *whole, last_tick);
      taken_up.push_back(hil::build_simulation(scenario));
      hil::read_checkpoint(path, scenario, *taken_up.back());
    }
    ASSERT_EQ(whole->step().status, StepStatus::kOk);
    for (const auto& again : taken_up) {
      ASSERT_EQ(again->step().status, StepStatus::kOk);
      ASSERT_EQ(again->calc_hash(), whole->calc_hash()) << "tick " << whole->get_tick();
      ASSERT_EQ(again->save(), whole->save()) << "tick " << whole->get_tick();
    }
  }
  EXPECT_GT(closed, 3);
  EXPECT_GT(pushing, 3);
}

TEST(Checkpoint, ARecordingOfARunTakenUpAgainReplays) {
  const hil::Scenario scenario = load_memory();
  const std::atomic<bool> stop{false};
  const auto run = [&](hil::Simulation& simulation, const std::string& log, const std::function<void()>& look) {
    hil::RunAnalysis analysis(scenario, simulation);
    hil::Recorder recorder(log, hil::build_log_header(scenario, simulation, hil::Pace::kFast, 0, 400));
    hil::LogEnd end = hil::run_fast(simulation, analysis, &recorder, 400, stop, look);
    recorder.close(end);
    return end.hash;
  };
  const std::string checkpoint = make_path("checkpoint");
  const auto whole = hil::build_simulation(scenario);
  const std::int64_t hash = run(*whole, make_path("whole"), [&] {
    if (whole->get_tick() == 123) hil::write_checkpoint(checkpoint, scenario, *whole, 400);
  });
  const auto again = hil::build_simulation(scenario);
  hil::read_checkpoint(checkpoint, scenario, *again);
  EXPECT_EQ(run(*again, make_path("rest"), [] {}), hash);
  const ReplayedLog replayed = replay_log(make_path("rest"));
  EXPECT_TRUE(replayed.complete);
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  EXPECT_EQ(replayed.result.compared, 400 - 123 + 1);
}

class ForeignCheckpoint : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto simulation = hil::build_simulation(scenario_);
    while (simulation->get_tick() < 60) ASSERT_EQ(simulation->step().status, StepStatus::kOk);
    hil::write_checkpoint(path_, scenario_, *simulation, 400);
    bytes_ = read_bytes(path_);
  }

  // Error message if a run of `scenario` is to continue from the file at path_; "" if it does.
  std::string get_complaint(const hil::Scenario& scenario) const {
    const auto simulation = hil::build_simulation(scenario);
    const std::vector<std::uint64_t> before = simulation->save();
    try {
      hil::read_checkpoint(path_, scenario, *simulation);
      return "";
    } catch (const hil::LogError& error) {
      EXPECT_EQ(simulation->save(), before) << "a refused checkpoint changes nothing";
      return error.what();
    }
  }

  // Writes the checkpoint with its header changed by `edit`, with a valid checksum.
  template <class Edit>
  std::string get_complaint_when(Edit&& edit) const {
    hil::LogHeader header;
    {
      write_bytes(path_, bytes_);
      hil::LogFileReader file(path_);
      header = hil::read_header(file, hil::kCheckpointChannel);
    }
    edit(header);
    std::vector<std::uint8_t> data;
    encode(header, data);
    hil::LogFileWriter writer(path_);
    writer.append(0, hil::kCheckpointChannel, data);
    writer.flush();
    return get_complaint(scenario_);
  }

  const hil::Scenario scenario_ = load_memory();
  const std::string path_ = make_path("checkpoint");
  std::string bytes_;
};

bool is_refused(const std::string& bytes) {
  MemoryFile memory(bytes);
  hil::LogFileReader file = memory.open();
  try {
    hil::read_header(file, hil::kCheckpointChannel);
    return false;
  } catch (const hil::LogError&) {
    return true;
  }
}

TEST_F(ForeignCheckpoint, AFlippedByteAnywhereIsRefused) {
  ASSERT_FALSE(is_refused(bytes_));
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    std::string bytes = bytes_;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << at % 8));
    ASSERT_TRUE(is_refused(bytes)) << "byte " << at << " of " << bytes.size();
  }
}

TEST_F(ForeignCheckpoint, ATruncatedOneAndOneThatGoesOnAreRefused) {
  for (std::size_t length = 1; length < bytes_.size(); ++length) {
    ASSERT_TRUE(is_refused(bytes_.substr(0, length))) << "cut to " << length << " bytes";
  }
  write_bytes(path_, "");
  EXPECT_NE(get_complaint(scenario_).find("is empty"), std::string::npos);
  for (const std::string& more : {std::string("x"), bytes_}) {
    write_bytes(path_, bytes_ + more);
    EXPECT_NE(get_complaint(scenario_).find("goes on after its end"), std::string::npos);
  }
}

TEST_F(ForeignCheckpoint, AnotherScenarioStepOrModelIsRefusedByName) {
  EXPECT_NE(get_complaint(load_memory({"name=other"})).find("is of scenario 'memory', this run is of 'other'"),
            std::string::npos);
  EXPECT_NE(get_complaint(load_memory({"step.dt=0.002"})).find("step of 0.001 s, this run has 0.002 s"),
            std::string::npos);
  EXPECT_NE(get_complaint(load_memory({"bodies.core.mass=101"})).find("the model differs"), std::string::npos);
  EXPECT_NE(get_complaint(load_memory({"timing.groups.nav.every=5"})).find("the model differs"), std::string::npos);
  EXPECT_EQ(get_complaint(load_memory({"step.until=0.9"})), "") << "a run may end elsewhere";
}

TEST_F(ForeignCheckpoint, AnotherVersionOrSchemaIsRefusedByName) {
  EXPECT_EQ(get_complaint_when([](hil::LogHeader&) {}), "");
  EXPECT_NE(get_complaint_when([](hil::LogHeader& header) { header.version = 99; }).find("log version 99"),
            std::string::npos);
  EXPECT_NE(get_complaint_when([](hil::LogHeader& header) { header.schema_hash ^= 1; }).find("message schema"),
            std::string::npos);
  EXPECT_NE(get_complaint_when([](hil::LogHeader& header) { header.program = "unlatch 0.0.1"; }).find("unlatch 0.0.1"),
            std::string::npos);
}

// A file may come from any source, with a valid checksum: its numbers must be checked before they are used as indices.
TEST_F(ForeignCheckpoint, AStateThatCannotBeIsRefused) {
  constexpr const char* kImpossible = "cannot have";
  const auto simulation = hil::build_simulation(scenario_);
  const auto word_of = [&simulation](const void* field) {
    const auto* const begin = simulation->state().get_bytes().data();
    return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(field) - begin) / 8;
  };
  const unlatch::State& state = simulation->state();
  const auto complaint_with = [&](std::size_t word, std::uint64_t value) {
    return get_complaint_when([=](hil::LogHeader& header) { header.start.at(word) = value; });
  };
  const std::size_t mode = word_of(&state.joints[0].mode), phase = word_of(&state.events[0].phase);
  const std::size_t throttle = state.get_bytes().size() / 8;
  EXPECT_EQ(complaint_with(mode, 1), "");
  for (const std::uint64_t value : {std::uint64_t{2}, ~std::uint64_t{0}}) {
    EXPECT_NE(complaint_with(mode, value).find(kImpossible), std::string::npos);
  }
  EXPECT_NE(complaint_with(phase, 3).find(kImpossible), std::string::npos);
  EXPECT_NE(complaint_with(throttle, 0x7FF0000000000000).find(kImpossible), std::string::npos) << "infinite throttle";
  EXPECT_NE(complaint_with(1, 0).find(kImpossible), std::string::npos) << "another plan's hash";
  EXPECT_NE(get_complaint_when([](hil::LogHeader& header) { header.start.pop_back(); }).find(kImpossible),
            std::string::npos);
  EXPECT_NE(get_complaint_when([](hil::LogHeader& header) { header.start.clear(); }).find(kImpossible),
            std::string::npos);
}

TEST_F(ForeignCheckpoint, ARecordingIsNotACheckpointNorTheOtherWayRound) {
  try {
    hil::RecordingReader reader{hil::LogFileReader(path_)};
    ADD_FAILURE() << "accepted";
  } catch (const hil::LogError& error) {
    EXPECT_NE(std::string(error.what()).find("is a checkpoint, not a recording"), std::string::npos) << error.what();
  }
  ASSERT_EQ(run_session(hil::Pace::kLockstep, {}, path_).end.status, hil::RunStatus::kDone);
  EXPECT_NE(get_complaint(scenario_).find("is a recording, not a checkpoint"), std::string::npos);
}

TEST(Checkpoint, ThatCannotBeWrittenLeavesNothingBehind) {
  const hil::Scenario scenario = load_memory();
  const auto simulation = hil::build_simulation(scenario);
  EXPECT_THROW(hil::write_checkpoint("/nonexistent/folder/x", scenario, *simulation, 400), hil::LogWriteError);
  const std::filesystem::path folder = make_path("folder");
  std::filesystem::create_directories(folder / "taken/inside");
  EXPECT_THROW(hil::write_checkpoint(folder / "taken", scenario, *simulation, 400), hil::LogWriteError);
  EXPECT_THROW(hil::write_checkpoint("/dev/null", scenario, *simulation, 400), hil::LogWriteError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  hil::write_checkpoint(folder / "new", scenario, *simulation, 400);
  hil::write_checkpoint(folder / "new", scenario, *simulation, 400);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace unlatch::test::checkpoint_test
