// Hello, catalog and source: all at the beginning, then in turn.
#include "hil/session/participants/announcer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/run/run.h"
#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::announcer_test {
namespace {

using hil::MessageKind;
using testing::ElementsAre;

constexpr std::int64_t kInterval_ns = 10;

hil::Announcer make_announcer(FakeConnection& connection, const hil::Clock& clock, std::size_t items,
                              std::size_t parts) {
  return {hil::HelloMessage{},
          std::vector<hil::CatalogMessage>(items),
          std::vector<hil::SourceMessage>(parts),
          connection,
          clock,
          kInterval_ns};
}

TEST(Announcer, SendsAllAtTheBeginning) {
  FakeConnection connection;
  const ManualClock clock(0);
  hil::Announcer announcer = make_announcer(connection, clock, 2, 1);
  announcer.send_all();
  EXPECT_THAT(connection.list_kinds(), ElementsAre(MessageKind::kHello, MessageKind::kCatalog, MessageKind::kCatalog));
  EXPECT_EQ(connection.sent[2].catalog.sequence, 1);
}

TEST(Announcer, WaitsForAFullConnectionButNotForEver) {
  FakeConnection connection;
  connection.is_full = true;
  const ManualClock clock(-5);
  make_announcer(connection, clock, 0, 0).send_all();
  EXPECT_TRUE(connection.sent.empty());
  EXPECT_EQ(clock.now_ns, -5 + 100 * 1'000'000) << "a hundred attempts";
}

// Any reading of the clock is valid: 0 and negative times too.
TEST(Announcer, SendsOneOfEachInTurnOnceInAnInterval) {
  for (const std::int64_t begin_ns : {-1000, -10, 0, 5}) {
    FakeConnection connection;
    const ManualClock clock(begin_ns);
    hil::Announcer announcer = make_announcer(connection, clock, 1, 2);
    announcer.announce(begin_ns);
    announcer.announce(begin_ns + kInterval_ns - 1);
    EXPECT_THAT(connection.list_kinds(), ElementsAre(MessageKind::kHello, MessageKind::kSource)) << begin_ns;
    announcer.announce(begin_ns + kInterval_ns);
    announcer.announce(begin_ns + 2 * kInterval_ns);
    EXPECT_THAT(connection.list_kinds(), ElementsAre(MessageKind::kHello, MessageKind::kSource, MessageKind::kCatalog,
                                                     MessageKind::kSource, MessageKind::kHello, MessageKind::kSource));
    EXPECT_EQ(connection.sent[4].hello.sequence, 1);
  }
}

TEST(Announcer, SendsThePartsOfTheSourceThatHaveNotHadTheirTurn) {
  FakeConnection connection;
  const ManualClock clock(0);
  hil::Announcer announcer = make_announcer(connection, clock, 0, 3);
  announcer.announce(0);
  connection.sent.clear();
  EXPECT_TRUE(announcer.send_unsent_source_part());
  EXPECT_TRUE(announcer.send_unsent_source_part());
  EXPECT_FALSE(announcer.send_unsent_source_part());
  ASSERT_EQ(connection.sent.size(), 2u);
  EXPECT_EQ(connection.sent[0].source.sequence, 1);
  EXPECT_EQ(connection.sent[1].source.sequence, 2);
}

TEST(Announcer, HelloCountsTheItemsOfTheCatalog) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto simulation = hil::build_simulation(scenario);
  hil::SessionOptions options;
  options.pace = hil::Pace::kRealtime;
  options.session = 4711;
  options.flight_software = scenario.flight_software;
  const auto catalog = hil::build_session_catalog(*simulation, options);
  const hil::HelloMessage hello = hil::build_hello(*simulation, "session", options, catalog);
  EXPECT_EQ(hello.body_count, 2);
  EXPECT_EQ(hello.joint_count, 1);
  EXPECT_EQ(hello.channel_count, 2);
  EXPECT_EQ(hello.sensor_count, 3);
  EXPECT_EQ(hello.participant_count, 1);
  EXPECT_EQ(hello.timeout_ns, 50'000'000);
  EXPECT_EQ(hello.cutoff_ns, 1'000'000);
  EXPECT_EQ(catalog.size(), 9u);
  EXPECT_EQ(hil::get_name(catalog.back().name), "fsw");
  EXPECT_EQ(catalog.back().session, 4711);
}

}  // namespace
}  // namespace unlatch::test::announcer_test
