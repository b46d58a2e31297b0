// The list of participants, and the commands seen from each.
#include "hil/session/participants/participants.h"

#include <gtest/gtest.h>

#include "tests/hil/session/fake_connection.h"

namespace unlatch::test::participants_test {
namespace {

using hil::Admission;

TEST(Participants, RequiredOnesCountFromZeroThenGuestsAsTheyCome) {
  hil::Participants participants({"b", "a"});
  EXPECT_EQ(participants.count_missing(), 2);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "guest")), Admission::kFirstStart);
  EXPECT_EQ(participants.admit(make_hello_ack(2, "a")), Admission::kFirstStart);
  EXPECT_EQ(participants.get_index(*participants.find("b")), 0);
  EXPECT_EQ(participants.get_index(*participants.find("a")), 1);
  EXPECT_EQ(participants.get_index(*participants.find("guest")), 2);
  EXPECT_EQ(participants.find(2), participants.find("a"));
  EXPECT_EQ(participants.list_required([](const hil::Participant& p) { return !p.is_present(); }), "'b'");
  EXPECT_FALSE(participants.is_complete());
}

TEST(Participants, ANumberOrNameInUseIsRefused) {
  hil::Participants participants({"a"});
  EXPECT_EQ(participants.admit(make_hello_ack(1, "a")), Admission::kFirstStart);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "a")), Admission::kKnown);
  EXPECT_EQ(participants.admit(make_hello_ack(2, "a")), Admission::kNameTaken);
  EXPECT_EQ(participants.admit(make_hello_ack(1, "b")), Admission::kNameTaken);
}

TEST(Participants, AreSixteenAtMost) {
  hil::Participants participants({});
  for (std::int32_t i = 0; i < 16; ++i) {
    EXPECT_EQ(participants.admit(make_hello_ack(i, ("guest" + std::to_string(i)).c_str())), Admission::kFirstStart);
  }
  EXPECT_EQ(participants.admit(make_hello_ack(16, "one too many")), Admission::kFull);
}

TEST(SeenCommands, AreExactOverTheWholeWindow) {
  hil::SeenCommands seen;
  constexpr std::int64_t kWindow = hil::SeenCommands::kWindow;
  using Arrival = hil::SeenCommands::Arrival;
  for (std::int64_t i = 2; i <= kWindow; i += 2) EXPECT_EQ(seen.insert(i), Arrival::kNew);
  for (std::int64_t i = 2; i <= kWindow; ++i) EXPECT_EQ(seen.insert(i), i % 2 == 0 ? Arrival::kSeen : Arrival::kNew);
  EXPECT_EQ(seen.insert(2 * kWindow + 1), Arrival::kTooFar);
  EXPECT_EQ(seen.insert(2 * kWindow), Arrival::kNew);
  EXPECT_EQ(seen.insert(kWindow), Arrival::kSeen) << "too old to be known";
  EXPECT_EQ(seen.insert(kWindow + 1), Arrival::kNew);
  seen.allow_jump();
  EXPECT_EQ(seen.insert(std::int64_t{1} << 40), Arrival::kNew);
  EXPECT_EQ(seen.insert((std::int64_t{1} << 40) - 1), Arrival::kNew) << "as it had not come";
}

TEST(SeenCommands, TellWhatIsMissing) {
  hil::SeenCommands seen;
  for (const std::int64_t i : {1, 2, 3, 70, 200, 201}) (void)seen.insert(i);
  const auto list = [&](std::int64_t last, std::int64_t count) {
    std::vector<std::pair<std::int64_t, std::int64_t>> gaps;
    for (auto gap = seen.find_gap(last, count); gap; gap = seen.find_gap(last, count, gap->first + gap->count)) {
      gaps.emplace_back(gap->first, gap->count);
    }
    return gaps;
  };
  using Gaps = std::vector<std::pair<std::int64_t, std::int64_t>>;
  EXPECT_EQ(list(201, 201), (Gaps{{4, 66}, {71, 129}}));
  EXPECT_EQ(list(201, 100), (Gaps{{102, 98}}));
  EXPECT_EQ(list(210, 10), (Gaps{{202, 9}}));
  EXPECT_EQ(list(210, 5), (Gaps{{206, 5}}));
  EXPECT_EQ(list(3, 3), Gaps{});
}

TEST(SeenCommands, AreRecognisedInAnyOrder) {
  hil::SeenCommands seen;
  using Arrival = hil::SeenCommands::Arrival;
  EXPECT_EQ(seen.insert(3), Arrival::kNew);
  EXPECT_EQ(seen.insert(1), Arrival::kNew);
  EXPECT_EQ(seen.insert(3), Arrival::kSeen);
  EXPECT_FALSE(seen.has_all(3, 3));
  EXPECT_TRUE(seen.has_all(3, 1));
  EXPECT_EQ(seen.insert(2), Arrival::kNew);
  EXPECT_TRUE(seen.has_all(3, 3));
  EXPECT_TRUE(seen.has_all(0, 0));
}

}  // namespace
}  // namespace unlatch::test::participants_test
