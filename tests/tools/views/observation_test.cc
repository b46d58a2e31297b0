// The view of `unlatch watch`, without a transport: losses, sessions, hostile names, screens of any size.
#include "tools/watch/observation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "hil/run/simulation/source_text.h"
#include "tools/common/text.h"
#include "tools/watch/screen.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;
using tools::Observation;

class Watching : public testing::Test {
 protected:
  void hear(const hil::Message& message) { observation_.hear(message, now_); }
  void pass(std::chrono::milliseconds time) { now_ += time; }
  const tools::View& look() { return observation_.look(now_, {}); }

  void hear_hello(std::int64_t session, int joints = 1) {
    hil::HelloMessage hello;
    hello.session = session;
    hello.schema_hash = hil::kSchemaHash;
    hello.dt_ns = 1'000'000;
    hello.last_tick = 1000;
    hello.joint_count = joints;
    hear(hello);
  }
  void hear_state(std::int64_t session, std::int64_t sequence, hil::RunStatus status = hil::RunStatus::kRunning) {
    hil::StateMessage state;
    state.session = session;
    state.sequence = state.tick = sequence;
    state.parts = 1;
    state.status = static_cast<std::int32_t>(status);
    hear(state);
  }
  bool has_notice(const std::string& part) {
    const auto& notices = look().notices;
    return std::any_of(notices.begin(), notices.end(),
                       [&part](const auto& notice) { return notice.text.find(part) != std::string::npos; });
  }

  Observation observation_;
  Observation::Time now_{1h};
};

TEST_F(Watching, CountsWhatIsMissingBetweenTheFirstAndTheLast) {
  for (const std::int64_t sequence : {100, 101, 104, 105, 110}) hear_state(7, sequence);
  EXPECT_EQ(look().lost, 2 + 4);
  EXPECT_EQ(look().repeated, 0);
}

TEST_F(Watching, AStateSaidAgainIsNoLoss) {
  for (const std::int64_t sequence : {5, 5, 5, 6}) hear_state(7, sequence);
  EXPECT_EQ(look().lost, 0);
  EXPECT_EQ(look().repeated, 2);
}

TEST_F(Watching, FollowsOneSessionUntilItIsSilent) {
  hear_hello(7);
  hear_state(7, 1);
  hear_hello(8);
  hear_state(8, 50);
  EXPECT_EQ(look().session, 7);
  EXPECT_TRUE(has_notice("another simulator"));
  pass(2000ms);
  EXPECT_TRUE(has_notice("stopped sending"));
  hear_state(8, 51);
  EXPECT_EQ(look().session, 8);
  EXPECT_EQ(look().lost, 0);
  EXPECT_TRUE(has_notice("now follows"));
}

TEST_F(Watching, OthersAreReportedOnceEachAndInventedOnesDoNotFillTheNotices) {
  const auto count_reported = [this] {
    const auto& notices = look().notices;
    return std::count_if(notices.begin(), notices.end(),
                         [](const auto& notice) { return notice.text.find("another simulator") != std::string::npos; });
  };
  hear_hello(7);
  hear_state(7, 1);
  for (int round = 0; round < 5; ++round) {
    for (const std::int64_t other : {8, 9}) hear_hello(other);
  }
  EXPECT_EQ(count_reported(), 2);
  for (int other = 100; other < 1000; ++other) hear_hello(other);
  EXPECT_EQ(count_reported(), 8);
}

TEST_F(Watching, AFloodOfOneNoticePushesOutNoOther) {
  hear_state(7, 1);
  hil::EventMessage event;
  event.session = 7;
  hil::set_name(event.name, "release");
  hear(event);
  for (std::int64_t i = 0; i < 5000; ++i) {
    hil::VerdictMessage verdict;
    verdict.session = 7;
    verdict.refers_to = i;
    verdict.channel = -1;
    verdict.reason = static_cast<std::int32_t>(hil::Reject::kPastTick);
    hear(verdict);
  }
  EXPECT_TRUE(has_notice("release"));
  const auto& notices = look().notices;
  ASSERT_EQ(std::count_if(notices.begin(), notices.end(), [](const auto& one) { return one.count == 5000; }), 1);
  EXPECT_NE(notices.back().text.find("message 4999"), std::string::npos) << "the latest";
}

TEST_F(Watching, ASessionThatHasEndedMakesWayAtOnce) {
  hear_state(7, 1, hil::RunStatus::kDone);
  hear_hello(8);
  EXPECT_EQ(look().session, 8);
}

TEST_F(Watching, WhatComesBeforeHelloIsNotForgotten) {
  hil::CatalogMessage item;
  item.session = 7;
  item.kind = static_cast<std::int32_t>(hil::CatalogKind::kJoint);
  hil::set_name(item.name, "nose");
  hear(item);
  hil::ReactionsMessage reactions;
  reactions.session = 7;
  reactions.parts = 1;
  reactions.tick = 3;
  reactions.count = 6;
  reactions.multipliers[5] = 42;
  hear(reactions);
  for (const hil::SourceMessage& part : hil::build_source(std::string(5000, 'x'), {}, 7)) hear(part);
  hear_hello(7);
  ASSERT_EQ(look().joints.size(), 1U);
  EXPECT_EQ(look().joints[0].name, "nose");
  EXPECT_EQ(look().joints[0].reaction[5], 42);
  EXPECT_EQ(look().reactions_tick, 3);
  EXPECT_NE(look().scenario_note.find("cannot be read"), std::string::npos) << look().scenario_note;
}

TEST_F(Watching, ParticipantsMakeNoSession) {
  hil::CommandMessage command;
  command.session = 9;
  hear(command);
  EXPECT_EQ(look().session, 0);
}

TEST_F(Watching, NamesFromOutsideCannotDrawOnTheScreen) {
  EXPECT_EQ(tools::clean_text("\033[2Jnose\x7f"), "?[2Jnose?");
  EXPECT_EQ(tools::clean_text("\xc2\x9b"
                              "31m"),
            "?31m");  // CSI in one character
  EXPECT_EQ(tools::clean_text("a\xff\xe2\x82"), "a???");
  EXPECT_EQ(tools::clean_text("Düse –"), "Düse –");
}

TEST_F(Watching, IndicesOutOfRangeChangeNothing) {
  hear_hello(7, 2);
  hil::CatalogMessage item;
  item.session = 7;
  item.kind = static_cast<std::int32_t>(hil::CatalogKind::kJoint);
  item.index = 65536;
  hear(item);
  hil::ReactionsMessage reactions;
  reactions.session = 7;
  reactions.parts = 65536;
  reactions.part = 65535;
  reactions.count = hil::kReactionsPerPart;
  hear(reactions);
  hil::StateMessage state;
  state.session = 7;
  state.part = 65535;
  state.parts = 65536;
  state.body_count = hil::kBodiesPerPart;
  state.joint_count = hil::kJointsPerPart;
  hear(state);
  EXPECT_EQ(look().joints.size(), 2U);
}

TEST_F(Watching, ScreensAreNeverLargerThanTheTerminal) {
  hear_hello(7, 100);
  hear_state(7, 1);
  hear(hil::HealthMessage{.session = 7, .step_p50_ns = 5'000, .step_max_ns = 90'000'000});
  for (int i = 0; i < 300; ++i) {
    hil::EventMessage event;
    event.session = 7;
    event.sequence = i;
    hil::set_name(event.name, "Übergang der Düse, ein langer Name");
    hear(event);
  }
  for (const std::size_t columns : {1U, 7U, 40U, 80U, 300U}) {
    for (const std::size_t rows : {1U, 2U, 5U, 24U, 100U}) {
      const auto lines = tools::draw(look(), {columns, rows, false, "dds"});
      EXPECT_LE(lines.size(), rows);
      for (const std::string& line : lines) {
        const auto characters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xc0) != 0x80; });
        EXPECT_LE(static_cast<std::size_t>(characters), columns) << line;
      }
    }
  }
}

TEST_F(Watching, ATerminalOf80ColumnsHasEveryColumnAndSaysWhatItsMinimumIsOf) {
  tools::View view;
  view.session = 7;
  view.reactions_tick = 1;
  view.joints = {{"booster1-nose", "retracted", {-123456, 1.234e-5, -3.2e-12, 4e6, -5.4321, 0}}};
  view.bodies = {"core", "booster1"};
  view.clearances.resize(1);
  view.clearances[0].a = 0;
  view.clearances[0].name_a = view.bodies[0];
  view.clearances[0].b = 1;
  view.clearances[0].name_b = view.bodies[1];
  view.health = hil::HealthMessage{};
  view.health->dropped = 12345;
  view.health->resent = 12345;
  const auto lines = tools::draw(view, {80, 24, false, "dds"});
  const auto has = [&lines](const std::string& part) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(has("rot_z N,N m"));
  EXPECT_TRUE(has("-5.432        0"));
  EXPECT_TRUE(has("-3.2e-12"));
  EXPECT_TRUE(has("smallest of the states seen here"));
  EXPECT_TRUE(has("resent 12345; absent 0"));
}

// Each counter is another number: all of them are on the screen, whole, and so are the newest notice and some joints.
TEST_F(Watching, ATerminalOf80By24HasEveryCounterHoweverLarge) {
  tools::View view;
  view.session = 0x7edcba9876543210;
  view.has_hello = true;
  view.hello.dt_ns = 1'000'000;
  view.scenario = "a-scenario-with-a-long-name";
  view.reactions_tick = 1;
  view.joints.resize(20, {"booster1-nose", "retracted", {}});
  view.clearances.resize(10);
  view.participants.push_back({"guidance", 1, hil::AckStatus::kReady, 1'234'567, 1'234'568});
  view.notices.push_back({1.5, "the newest notice", false});
  std::int64_t next = 1'000'001;
  std::vector<std::string> expected{"waits for flight software, realtime", "1234568 commands", "the newest notice",
                                    "booster1-n"};
  const auto draw_number = [&](std::int64_t& counter, const std::string& name) {
    counter = next++;
    expected.push_back(name + " " + std::to_string(counter));
  };
  view.health = hil::HealthMessage{};
  view.health->step_max_ns = view.health->wakeup_max_ns = 123'456'700;
  expected.insert(expected.end(), {"worst 123456.7 of 1000 us", "worst 123456.7 us"});
  draw_number(view.health->overruns, "overruns");
  draw_number(view.health->dropped, "dropped");
  draw_number(view.health->resent, "resent");
  draw_number(view.health->late, "late");
  draw_number(view.health->missing, "absent");
  draw_number(view.health->rejected[3], "refused");
  draw_number(view.lost, "lost");
  draw_number(view.repeated, "repeated");
  draw_number(view.port.malformed, "malformed");
  for (const auto& [kind, name] : {std::pair{hil::MessageKind::kState, "State"},
                                   {hil::MessageKind::kCommand, "Command"},
                                   {hil::MessageKind::kStepAck, "StepAck"},
                                   {hil::MessageKind::kEvent, "Event"}}) {
    view.rates[static_cast<std::size_t>(kind)] = static_cast<double>(++next % 100'000);
    expected.push_back(std::string(name) + " " + std::to_string(next % 100'000) + "/s");
  }
  const auto lines = tools::draw(view, {80, 24, false, "dds"});
  EXPECT_LE(lines.size(), 24U);
  std::string screen;
  for (const std::string& line : lines) {
    EXPECT_LE(tools::count_characters(line), 80U) << line;
    screen += line + "\n";
  }
  for (const std::string& part : expected) EXPECT_NE(screen.find(part), std::string::npos) << part << "\n" << screen;
}

TEST(SourceText, IsPutTogetherFromPartsInAnyOrderWithRepetitions) {
  std::mt19937_64 random(20261121);
  std::string text(3 * hil::kSourcePerPart + 17, 'x');
  for (char& c : text) c = static_cast<char>('a' + random() % 26);
  const std::vector<std::string> overrides{"a.b=1", "", "c=2"};
  std::vector<hil::SourceMessage> parts = hil::build_source(text, overrides, 7);
  ASSERT_EQ(parts.size(), 4U);
  parts.insert(parts.end(), parts.begin(), parts.begin() + 2);
  std::shuffle(parts.begin(), parts.end(), random);
  hil::SourceText source;
  for (const hil::SourceMessage& part : parts) source.add(part);
  ASSERT_TRUE(source.is_complete());
  EXPECT_EQ(source.split(), (std::vector<std::string>{text, "a.b=1", "", "c=2"}));
}

TEST(SourceText, TakesNothingFromOtherSessionsOrSizes) {
  const std::vector<hil::SourceMessage> parts = hil::build_source(std::string(5000, 'x'), {}, 7);
  hil::SourceText source;
  source.add(parts[0]);
  hil::SourceMessage other = parts[1];
  other.session = 8;
  source.add(other);
  other = parts[1];
  other.parts = 9;
  source.add(other);
  other = parts[1];
  other.count = 3;
  source.add(other);
  EXPECT_EQ(source.get_missing(), parts.size() - 1);
}

}  // namespace
}  // namespace unlatch::test
