// The cyclic thread's sign of life.
#include "hil/session/executive/heartbeat.h"

#include <gtest/gtest.h>

namespace unlatch::test::heartbeat_test {
namespace {

using hil::RunPlace;

TEST(Heartbeat, EachBeatChangesTheCount) {
  hil::Heartbeat heartbeat;
  const std::int64_t before = heartbeat.get_beats();
  heartbeat.beat(RunPlace::kWaiting);
  heartbeat.beat(RunPlace::kWaiting);
  EXPECT_EQ(heartbeat.get_beats(), before + 2);
}

TEST(Heartbeat, ThePlaceNamesTheTickOnceTheRunHasBegun) {
  hil::Heartbeat heartbeat;
  EXPECT_EQ(heartbeat.describe_place(), "before the first tick");
  heartbeat.set_tick(412);
  EXPECT_EQ(heartbeat.get_tick(), 412);
  const std::pair<RunPlace, const char*> places[] = {{RunPlace::kWaiting, "waiting for tick 412"},
                                                     {RunPlace::kReceiving, "receiving the inputs of tick 412"},
                                                     {RunPlace::kStepping, "in the step of tick 412"},
                                                     {RunPlace::kPublishing, "publishing results of tick 412"},
                                                     {RunPlace::kEnding, "at the end, after tick 412"}};
  for (const auto& [place, text] : places) {
    heartbeat.beat(place);
    EXPECT_EQ(heartbeat.describe_place(), text);
  }
}

}  // namespace
}  // namespace unlatch::test::heartbeat_test
