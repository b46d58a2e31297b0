// A simulator for targets without operating system (bridge/target), in lockstep with flight software over a serial
// line.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>

#include "bridge/target/lockstep.h"
#include "bridge/target/separation.h"
#include "bridge/uart/session_image.h"
#include "hil/run/run.h"
#include "hil/run/simulation/model_messages.h"
#include "hil/session/participants/announcer.h"
#include "tests/bridge/target_world.h"
#include "tools/fsw/separation_sequence.h"
#include "unlatch/plan_image.h"

namespace unlatch::test {
namespace {

using target::FrameLine;
using target::Lockstep;
using target::PendingCommands;
using target::SessionImage;

constexpr const char* kBoosters = UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/scenario.yaml";
constexpr std::uint64_t kSeed = 4802;
constexpr std::int64_t kEvery = 100;  // ticks between hashes

std::string print_hash(const std::string& name, std::int64_t tick, std::int64_t hash) {
  char line[100];
  std::snprintf(line, sizeof line, "%s %lld %016llx\n", name.c_str(), static_cast<long long>(tick),
                static_cast<unsigned long long>(hash));
  return line;
}

// The plan image and the session of a scenario, as `unlatch compile` writes them; a board that uses them.
class Board {
 public:
  explicit Board(const std::string& until, std::vector<std::string> overrides = {}) {
    overrides.push_back("step.until=" + until);
    scenario_ = hil::load_scenario(kBoosters, overrides);
    simulation_ = hil::build_simulation(scenario_);
    last_tick_ = std::llround(scenario_.until / scenario_.dt);
    session_ = bridge::build_session_image(scenario_, *simulation_, last_tick_);
    const std::span<const std::byte> image = simulation_->plan().get_image();
    image_ = allocate(image.size());
    std::memcpy(image_.get(), image.data(), image.size());
    opened_ = open_plan({image_.get(), image.size()}, plan_memory_);
    state_memory_ = allocate(opened_.plan->get_state_bytes());
    workspace_memory_ = allocate(opened_.plan->get_workspace_bytes());
    state_ = State(*opened_.plan, {state_memory_.get(), opened_.plan->get_state_bytes()});
    workspace_.emplace(*opened_.plan, std::span(workspace_memory_.get(), opened_.plan->get_workspace_bytes()));
  }

  // Of a simulator that has just been switched on. Null, or the mistake.
  const char* switch_on() {
    if (const char* mistake = sessions_.open(session_)) return mistake;
    line_ = std::make_unique<FrameLine>();
    lockstep_ = std::make_unique<Lockstep>(Lockstep::Parts{*opened_.plan, state_, *workspace_, sessions_, *line_});
    return lockstep_->open();
  }
  bool fly() { return lockstep_->run(); }

  // What the session on a computer prints, with the reference flight software.
  std::string fly_reference() {
    fsw::SeparationSequence law;
    fsw::Vehicle vehicle;
    fsw::Commands commands;
    hil::SessionOptions options;
    options.flight_software = scenario_.flight_software;
    const auto catalog = hil::build_session_catalog(*simulation_, options);
    vehicle.begin(hil::build_hello(*simulation_, scenario_.name, options, catalog));
    for (const auto& item : catalog) vehicle.learn(item);
    EXPECT_EQ(law.attach(vehicle), "");
    std::string printed;
    hil::StateMessage state;
    while (simulation_->get_tick() < last_tick_) {
      for (std::int32_t part = hil::count_state_parts(*simulation_) - 1; part >= 0; --part) {
        hil::fill_state(*simulation_, part, 1'000'000, state);
        (void)vehicle.sense(state);
      }
      commands.clear();
      law.update(state.time_ns, vehicle, commands);
      for (const auto& [channel, value] : commands.get())
        simulation_->set_channel(static_cast<std::size_t>(channel), value);
      EXPECT_EQ(simulation_->step().status, StepStatus::kOk);
      const std::int64_t tick = simulation_->get_tick();
      if (tick % kEvery == 0 || tick == last_tick_)
        printed += print_hash(scenario_.name, tick, simulation_->calc_hash());
    }
    return printed;
  }

  std::vector<std::uint8_t>& session() { return session_; }
  const SessionImage& sessions() const { return sessions_; }

 private:
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{kImageAlignment}); }
  };
  using Memory = std::unique_ptr<std::byte, Free>;
  static Memory allocate(std::size_t bytes) {
    return Memory(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kImageAlignment})));
  }

  hil::Scenario scenario_;
  std::unique_ptr<hil::Simulation> simulation_;
  std::int64_t last_tick_ = 0;
  std::vector<std::uint8_t> session_;
  Memory image_, state_memory_, workspace_memory_;
  PlanMemory plan_memory_;
  OpenedPlan opened_;
  State state_;
  std::optional<Workspace> workspace_;
  SessionImage sessions_;
  std::unique_ptr<FrameLine> line_;
  std::unique_ptr<Lockstep> lockstep_;
};

class Target : public testing::Test {
 protected:
  Target() { target_world = &world_; }

  std::unique_ptr<LineParticipant> make_participant(std::uint32_t number) {
    const auto sequence = std::make_shared<unlatch_separation>();
    unlatch_separation_begin(sequence.get());
    return std::make_unique<LineParticipant>(
        world_, number, [sequence](unlatch_participant& p) { unlatch_separation_update(sequence.get(), &p); });
  }
  // The lines with hashes alone.
  std::string fly(Board& board) {
    const char* mistake = board.switch_on();
    EXPECT_EQ(mistake, nullptr) << mistake;
    EXPECT_TRUE(board.fly());
    std::string hashes;
    for (std::size_t at = 0; at < world_.printed.size();) {
      const std::size_t end = world_.printed.find('\n', at) + 1;
      if (world_.printed[at] != '#') hashes += world_.printed.substr(at, end - at);
      at = end;
    }
    return hashes;
  }

  TargetWorld world_;
};

TEST_F(Target, FliesTheHashesOfASessionOnAComputer) {
  Board board("0.7");
  const auto participant = make_participant(1);
  world_.other_end = [&] { participant->run(); };
  const std::string hashes = fly(board);
  EXPECT_EQ(hashes, board.fly_reference());
  EXPECT_EQ(std::count(hashes.begin(), hashes.end(), '\n'), 7);
  EXPECT_EQ(participant->ended, 1 + 3);  // the last State is repeated
  EXPECT_EQ(participant->refused, 0);
  EXPECT_NE(world_.printed.find("# resent 0, refused 0, not understood 0\n"), std::string::npos) << world_.printed;
}

TEST_F(Target, ANoisyLineChangesNoBit) {
  Board board("0.6");
  std::mt19937_64 draw(kSeed);
  const auto chance = [&](int in) { return draw() % static_cast<unsigned>(in) == 0; };
  world_.disturb = [&](std::vector<std::uint8_t>& bytes) {
    if (!bytes.empty() && chance(10)) bytes[draw() % bytes.size()] ^= static_cast<std::uint8_t>(1U << draw() % 8);
    if (!bytes.empty() && chance(10)) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(draw() % bytes.size()));
    if (chance(20)) bytes.insert(bytes.begin(), {'U', 'N', 'L', '1', 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 8, 0});
    if (chance(20)) bytes.insert(bytes.end(), draw() % 40, static_cast<std::uint8_t>(draw()));
  };
  const auto participant = make_participant(1);
  world_.other_end = [&] { participant->run(); };
  EXPECT_EQ(fly(board), board.fly_reference()) << "seed " << kSeed;
  EXPECT_EQ(world_.printed.find("# resent 0,"), std::string::npos) << world_.printed;
}

TEST_F(Target, ANewStartOfTheFlightSoftwareTakesItsPlaceAndChangesNoBit) {
  Board board("0.6");
  auto participant = make_participant(1);
  std::uint64_t away_until_us = 0;
  world_.other_end = [&] {
    if (world_.now_us < away_until_us) return;
    participant->run();
    if (away_until_us == 0 && participant->get().state.tick == 50) {  // nothing has been commanded yet
      participant = make_participant(2);
      away_until_us = world_.now_us + 10'000'000;
    }
  };
  EXPECT_EQ(fly(board), board.fly_reference());
  EXPECT_NE(world_.printed.find("# 'fsw' takes part from tick 51\n"), std::string::npos) << world_.printed;
}

TEST_F(Target, FlightSoftwareThatIsSilentIsWaitedForAndReported) {
  Board board("0.6");
  const auto participant = make_participant(1);
  int paused = 0;
  participant->look = [&](const unlatch_frame& frame) {
    unlatch_wire_state state;
    if (frame.kind == UNLATCH_WIRE_STATE_KIND && unlatch_wire_decode_state(&state, frame.payload, frame.length) != 0)
      paused += state.status == UNLATCH_RUN_STATUS_PAUSED ? 1 : 0;
  };
  world_.other_end = [&] {
    participant->mute = participant->get().state.tick >= 470 && paused < 5;  // among the commands
    participant->run();
  };
  EXPECT_EQ(fly(board), board.fly_reference());
  EXPECT_GE(paused, 5);
}

TEST_F(Target, EveryCommandThatMayNotActIsRefusedWithItsReason) {
  Board board("0.1");
  ASSERT_EQ(board.switch_on(), nullptr);
  PendingCommands commands;
  ASSERT_TRUE(commands.open(board.sessions()));
  unlatch_wire_command good{};
  good.sequence = 1;
  good.tick = 10;
  good.valid_until_tick = -1;
  good.value = 0.5;
  const auto add = [&](auto change) {
    unlatch_wire_command command = good;
    command.sequence = ++good.sequence;
    change(command);
    return commands.add(command, 10).reason.value_or(-1);
  };
  EXPECT_EQ(add([](auto&) {}), -1);
  EXPECT_EQ(add([](auto& c) { c.tick = 9; }), UNLATCH_REJECT_PAST_TICK);
  EXPECT_EQ(add([](auto& c) { c.valid_until_tick = 9; }), UNLATCH_REJECT_EXPIRED);
  EXPECT_EQ(add([](auto& c) { c.value = 1.5; }), UNLATCH_REJECT_OUT_OF_RANGE);
  EXPECT_EQ(add([](auto& c) { c.value = std::numeric_limits<double>::quiet_NaN(); }), UNLATCH_REJECT_NOT_FINITE);
  EXPECT_EQ(add([](auto& c) { c.channel = 21; }), UNLATCH_REJECT_UNKNOWN_CHANNEL);
  EXPECT_EQ(add([](auto& c) { c.channel = -1; }), UNLATCH_REJECT_UNKNOWN_CHANNEL);
  EXPECT_EQ(add([](auto& c) { c.tick = -1; }), UNLATCH_REJECT_MALFORMED);
  EXPECT_EQ(add([](auto& c) { c.sequence = 0; }), UNLATCH_REJECT_MALFORMED);
  EXPECT_EQ(add([](auto& c) { c.sequence = 2, c.tick = 8; }), UNLATCH_REJECT_DUPLICATE);
  EXPECT_EQ(add([](auto& c) { c.sequence = 1'000'000; }), UNLATCH_REJECT_JUMP);
  unlatch_wire_command first = good;
  first.sequence = 2;
  EXPECT_TRUE(commands.add(first, 10).repeated);
  for (std::size_t i = 1; i < PendingCommands::kPlaces; ++i) ASSERT_EQ(add([](auto& c) { c.tick = 11; }), -1);
  EXPECT_EQ(add([](auto&) {}), UNLATCH_REJECT_NO_PLACE);
}

TEST_F(Target, CommandsActInTheOrderOfTheirTicksAndNumbers) {
  Board board("0.1", {"flight_software.delay=2"});
  ASSERT_EQ(board.switch_on(), nullptr);
  PendingCommands commands;
  ASSERT_TRUE(commands.open(board.sessions()));
  const auto add = [&](std::int64_t sequence, std::int64_t tick) {
    unlatch_wire_command command{};
    command.sequence = sequence;
    command.tick = tick;
    command.valid_until_tick = -1;
    EXPECT_FALSE(commands.add(command, 0).reason);
  };
  add(3, 1), add(1, 2), add(2, 1);
  const auto take = [&](std::int64_t tick) {
    const unlatch_wire_command* const command = commands.take_due(tick);
    return command == nullptr ? -1 : command->sequence;
  };
  EXPECT_EQ(take(2), -1);
  EXPECT_EQ(take(3), 2);
  EXPECT_EQ(take(3), 3);
  EXPECT_EQ(take(3), -1);
  EXPECT_EQ(take(4), 1);
}

TEST_F(Target, ImagesThatAreBrokenOrDoNotFitAreRefused) {
  Board board("0.1");
  ASSERT_EQ(board.switch_on(), nullptr);
  const std::vector<std::uint8_t> good = board.session();
  std::mt19937_64 draw(kSeed);
  for (int trial = 0; trial < 1000; ++trial) {
    board.session() = good;
    board.session()[draw() % good.size()] ^= static_cast<std::uint8_t>(1U << draw() % 8);
    ASSERT_NE(board.switch_on(), nullptr) << "seed " << kSeed << ", trial " << trial;
  }
  board.session() = good;
  board.session().resize(good.size() - 180);
  EXPECT_NE(board.switch_on(), nullptr);
  board.session() = Board("0.1", {"bodies.core.mass=99 t"}).session();
  EXPECT_NE(std::string(board.switch_on()).find("not of one scenario"), std::string::npos);
}

TEST_F(Target, BytesOfAnyKindNeitherStopTheBoardNorChangeABit) {
  Board board("0.5");
  std::mt19937_64 draw(kSeed + 1);
  const auto participant = make_participant(1);
  world_.other_end = [&] {
    participant->run();
    if (draw() % 4 != 0) return;
    // Whole frames with the right checksum and random content, in the place of the participant's next, which is lost.
    std::uint8_t frame[UNLATCH_FRAME_LONGEST];
    const auto kind = static_cast<int>(draw() % (UNLATCH_FRAME_LAST_KIND + 1));
    const std::size_t length = draw() % 300;
    for (std::size_t i = 0; i < length; ++i) frame[UNLATCH_FRAME_HEADER_BYTES + i] = static_cast<std::uint8_t>(draw());
    if (kind == UNLATCH_WIRE_COMMAND_KIND) {
      unlatch_wire_command command{};
      command.session = static_cast<std::int64_t>(draw());
      command.sequence = static_cast<std::int64_t>(draw() % 100);
      command.tick = static_cast<std::int64_t>(draw() % 500);
      command.participant = static_cast<std::int32_t>(draw());
      command.channel = static_cast<std::int32_t>(draw());
      unlatch_wire_encode_command(&command, frame + UNLATCH_FRAME_HEADER_BYTES, UNLATCH_WIRE_COMMAND_BYTES);
      (void)unlatch_frame_seal(frame, 1, participant->get().sequence, kind, UNLATCH_WIRE_COMMAND_BYTES);
      world_.to_board.insert(world_.to_board.end(), frame,
                             frame + UNLATCH_FRAME_HEADER_BYTES + UNLATCH_WIRE_COMMAND_BYTES);
      return;
    }
    (void)unlatch_frame_seal(frame, 1, participant->get().sequence, kind, length);
    world_.to_board.insert(world_.to_board.end(), frame, frame + UNLATCH_FRAME_HEADER_BYTES + length);
  };
  EXPECT_EQ(fly(board), board.fly_reference()) << "seed " << kSeed + 1;
}

}  // namespace
}  // namespace unlatch::test
